//! Numbers of several simplices side by side, and sums over corners and components.
//!
//! Loops only, no closures: they would not be compiled for the instructions of the caller.

use std::ops::{Add, AddAssign, Div, Mul, Sub};

use crate::equations::stabilization::Real;

/// Simplices of a group.
pub const LANES: usize = 4;

/// One number of each simplex of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// 0 in each.
    pub const ZERO: Lanes = Lanes([0.0; LANES]);

    /// The larger of two, lane by lane.
    #[inline(always)]
    pub fn max(mut self, other: Lanes) -> Lanes {
        for l in 0..LANES {
            self.0[l] = if self.0[l] > other.0[l] {
                self.0[l]
            } else {
                other.0[l]
            };
        }
        self
    }

    /// The smaller of two, lane by lane.
    #[inline(always)]
    pub fn min(mut self, other: Lanes) -> Lanes {
        for l in 0..LANES {
            self.0[l] = if self.0[l] < other.0[l] {
                self.0[l]
            } else {
                other.0[l]
            };
        }
        self
    }
}

macro_rules! lane_by_lane {
    ($($operator:ident $function:ident $symbol:tt)*) => {$(
        impl $operator for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $function(mut self, other: Lanes) -> Lanes {
                for l in 0..LANES {
                    self.0[l] $symbol other.0[l];
                }
                self
            }
        }
        impl $operator<f64> for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $function(mut self, other: f64) -> Lanes {
                for l in 0..LANES {
                    self.0[l] $symbol other;
                }
                self
            }
        }
    )*};
}
lane_by_lane!(Add add += Sub sub -= Mul mul *= Div div /=);

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Lanes) {
        *self = *self + other;
    }
}

impl Real for Lanes {
    #[inline(always)]
    fn sqrt(mut self) -> Lanes {
        for l in 0..LANES {
            self.0[l] = self.0[l].sqrt();
        }
        self
    }

    #[inline(always)]
    fn recip(mut self) -> Lanes {
        for l in 0..LANES {
            self.0[l] = 1.0 / self.0[l];
        }
        self
    }
}

/// a·b
#[inline(always)]
pub fn dot<const D: usize>(a: &[Lanes; D], b: &[Lanes; D]) -> Lanes {
    let mut sum = a[0] * b[0];
    for d in 1..D {
        sum += a[d] * b[d];
    }
    sum
}

/// Σ f_i
#[inline(always)]
pub fn sum<const N: usize>(values: &[Lanes; N]) -> Lanes {
    let mut sum = values[0];
    for i in 1..N {
        sum += values[i];
    }
    sum
}

/// Σ N_i f_i
#[inline(always)]
pub fn interpolate<const N: usize>(shape: &[f64; N], values: &[Lanes; N]) -> Lanes {
    let mut sum = values[0] * shape[0];
    for i in 1..N {
        sum += values[i] * shape[i];
    }
    sum
}

/// Σ f_i ∇N_i
#[inline(always)]
pub fn slope<const D: usize, const N: usize>(
    values: &[Lanes; N],
    gradient: &[[Lanes; D]; N],
) -> [Lanes; D] {
    let mut slope = [Lanes::ZERO; D];
    for d in 0..D {
        slope[d] = values[0] * gradient[0][d];
        for i in 1..N {
            slope[d] += values[i] * gradient[i][d];
        }
    }
    slope
}
