//! Numbers that carry their first and second derivatives in x, y and t, for manufactured sources.

use std::ops::{Add, Mul, Neg, Sub};

/// Value, gradient and Hessian in (x, y, t).
#[derive(Debug, Clone, Copy)]
pub struct Jet {
    pub value: f64,
    pub first: [f64; 3],
    pub second: [[f64; 3]; 3],
}

impl Jet {
    pub fn constant(value: f64) -> Jet {
        Jet {
            value,
            first: [0.0; 3],
            second: [[0.0; 3]; 3],
        }
    }

    /// Independent variable number `k` (0: x, 1: y, 2: t).
    pub fn variable(value: f64, k: usize) -> Jet {
        let mut jet = Jet::constant(value);
        jet.first[k] = 1.0;
        jet
    }

    /// f(self) from f, f' and f''.
    fn chain(self, f: f64, df: f64, ddf: f64) -> Jet {
        let mut out = Jet::constant(f);
        for i in 0..3 {
            out.first[i] = df * self.first[i];
            for j in 0..3 {
                out.second[i][j] = df * self.second[i][j] + ddf * self.first[i] * self.first[j];
            }
        }
        out
    }

    pub fn sin(self) -> Jet {
        self.chain(self.value.sin(), self.value.cos(), -self.value.sin())
    }

    pub fn cos(self) -> Jet {
        self.chain(self.value.cos(), -self.value.sin(), -self.value.cos())
    }

    pub fn exp(self) -> Jet {
        let e = self.value.exp();
        self.chain(e, e, e)
    }

    pub fn recip(self) -> Jet {
        let r = 1.0 / self.value;
        self.chain(r, -r * r, 2.0 * r * r * r)
    }
}

impl Add for Jet {
    type Output = Jet;
    fn add(self, other: Jet) -> Jet {
        let mut out = Jet::constant(self.value + other.value);
        for i in 0..3 {
            out.first[i] = self.first[i] + other.first[i];
            for j in 0..3 {
                out.second[i][j] = self.second[i][j] + other.second[i][j];
            }
        }
        out
    }
}

impl Neg for Jet {
    type Output = Jet;
    fn neg(self) -> Jet {
        self * -1.0
    }
}

impl Sub for Jet {
    type Output = Jet;
    fn sub(self, other: Jet) -> Jet {
        self + -other
    }
}

impl Mul for Jet {
    type Output = Jet;
    fn mul(self, other: Jet) -> Jet {
        let mut out = Jet::constant(self.value * other.value);
        for i in 0..3 {
            out.first[i] = self.first[i] * other.value + self.value * other.first[i];
            for j in 0..3 {
                out.second[i][j] = self.second[i][j] * other.value
                    + self.value * other.second[i][j]
                    + self.first[i] * other.first[j]
                    + self.first[j] * other.first[i];
            }
        }
        out
    }
}

impl Mul<f64> for Jet {
    type Output = Jet;
    fn mul(self, factor: f64) -> Jet {
        self * Jet::constant(factor)
    }
}

impl Add<f64> for Jet {
    type Output = Jet;
    fn add(self, term: f64) -> Jet {
        self + Jet::constant(term)
    }
}
