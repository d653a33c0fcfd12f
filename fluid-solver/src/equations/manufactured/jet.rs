//! Numbers that carry their first and second derivatives in N variables, the last of them time.

use std::ops::{Add, Mul, Neg, Sub};

/// Value, gradient and Hessian in (x…, t).
#[derive(Debug, Clone, Copy)]
pub struct Jet<const N: usize> {
    /// f
    pub value: f64,
    /// ∂_i f
    pub first: [f64; N],
    /// ∂_i ∂_j f
    pub second: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    /// What does not depend on the variables.
    pub fn constant(value: f64) -> Jet<N> {
        Jet {
            value,
            first: [0.0; N],
            second: [[0.0; N]; N],
        }
    }

    /// Independent variable number `k`.
    pub fn variable(value: f64, k: usize) -> Jet<N> {
        let mut jet = Jet::constant(value);
        jet.first[k] = 1.0;
        jet
    }

    /// f(self) from f, f' and f''.
    fn chain(self, f: f64, df: f64, ddf: f64) -> Jet<N> {
        let mut out = Jet::constant(f);
        for i in 0..N {
            out.first[i] = df * self.first[i];
            for j in 0..N {
                out.second[i][j] = df * self.second[i][j] + ddf * self.first[i] * self.first[j];
            }
        }
        out
    }

    /// sin f
    pub fn sin(self) -> Jet<N> {
        self.chain(self.value.sin(), self.value.cos(), -self.value.sin())
    }

    /// cos f
    pub fn cos(self) -> Jet<N> {
        self.chain(self.value.cos(), -self.value.sin(), -self.value.cos())
    }

    /// exp f
    pub fn exp(self) -> Jet<N> {
        let e = self.value.exp();
        self.chain(e, e, e)
    }

    /// 1/f
    pub fn recip(self) -> Jet<N> {
        let r = 1.0 / self.value;
        self.chain(r, -r * r, 2.0 * r * r * r)
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Jet<N>;
    fn add(self, other: Jet<N>) -> Jet<N> {
        let mut out = Jet::constant(self.value + other.value);
        for i in 0..N {
            out.first[i] = self.first[i] + other.first[i];
            for j in 0..N {
                out.second[i][j] = self.second[i][j] + other.second[i][j];
            }
        }
        out
    }
}

impl<const N: usize> Neg for Jet<N> {
    type Output = Jet<N>;
    fn neg(self) -> Jet<N> {
        self * -1.0
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Jet<N>;
    fn sub(self, other: Jet<N>) -> Jet<N> {
        self + -other
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Jet<N>;
    fn mul(self, other: Jet<N>) -> Jet<N> {
        let mut out = Jet::constant(self.value * other.value);
        for i in 0..N {
            out.first[i] = self.first[i] * other.value + self.value * other.first[i];
            for j in 0..N {
                out.second[i][j] = self.second[i][j] * other.value
                    + self.value * other.second[i][j]
                    + self.first[i] * other.first[j]
                    + self.first[j] * other.first[i];
            }
        }
        out
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Jet<N>;
    fn mul(self, factor: f64) -> Jet<N> {
        self * Jet::constant(factor)
    }
}

impl<const N: usize> Add<f64> for Jet<N> {
    type Output = Jet<N>;
    fn add(self, term: f64) -> Jet<N> {
        self + Jet::constant(term)
    }
}
