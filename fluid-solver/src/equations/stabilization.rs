//! Stabilisation parameters: what keeps equal-order pressure, sharp convection and stiff drag stable.
//!
//! ```text
//!   τ   = [(ρφα/Δt)² + (2ρφ|a|/h)² + (12μφ/h²)² + β²]^(−1/2)          (S1)
//!   τ_c = θ [μφ + ρφ|a|h/2 + β_c h²] / P²,   P = φ + c                (S2)
//!   b0  = ρφ|a|/h + 3μφ/h²                                            (S3)
//! ```
//!
//! | symbol | meaning | unit |
//! | ------ | ------- | ---- |
//! | α/Δt   | weight of the new velocity in the time derivative | 1/s |
//! | a      | convecting velocity, interstitial | m/s |
//! | h      | diameter of the ball (disk) of the size of the simplex | m |
//! | θ      | `grad_div` factor | – |
//! | β_c    | β; where held grains drag unevenly min(β, β_min + 12μφ/h²), blended by ϑ of (H3) | kg/(m³ s) |
//! | b0     | what holds a node beside the drag; without ρφα/Δt, or short steps add up | kg/(m³ s) |
//!
//! After Codina's algebraic subscales (2000) with the resistance of Badia and Codina (2009): the
//! subscale velocity −τR carries mass through P∇q, the subscale pressure acts through div(P w).
//! β must be in τ: without it the pressure drop of a stiff plug vanishes.

use std::ops::{Add, Div, Mul, Sub};

/// One number, or that of several simplices side by side.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Mul<f64, Output = Self>
{
    /// √x
    fn sqrt(self) -> Self;
    /// 1/x
    fn recip(self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn recip(self) -> f64 {
        1.0 / self
    }
}

/// Element means that the parameters depend on.
#[derive(Debug, Clone, Copy)]
pub struct Scales<T> {
    /// α/Δt \[1/s\].
    pub rate: f64,
    /// ρφ \[kg/m³\].
    pub inertia: T,
    /// μφ \[Pa s\].
    pub viscosity: T,
    /// β \[kg/(m³ s)\].
    pub drag: T,
    /// What of β is not in β_c \[kg/(m³ s)\].
    pub relieved: T,
    /// |a| \[m/s\].
    pub speed: T,
    /// P = φ + c.
    pub mixture: T,
    /// h \[m\].
    pub size: T,
}

impl<T: Real> Scales<T> {
    /// τ of the momentum residual \[m³ s/kg\].
    #[inline(always)]
    pub fn momentum(&self) -> T {
        let transient = self.inertia * self.rate;
        let convective = self.inertia * 2.0 * self.speed / self.size;
        let viscous = self.viscosity * 12.0 / (self.size * self.size);
        let squares = transient * transient + convective * convective + viscous * viscous;
        (squares + self.drag * self.drag).sqrt().recip() // (S1)
    }

    /// b0: what holds a node beside the drag \[kg/(m³ s)\].
    #[inline(always)]
    pub fn other_than_drag(&self) -> T {
        let convective = self.inertia * self.speed / self.size;
        convective + self.viscosity * 3.0 / (self.size * self.size) // (S3)
    }

    /// Drag from which on it is left out of τ_c, where the least of the corners is `least` \[kg/(m³ s)\].
    #[inline(always)]
    pub fn viscous_bound(&self, least: T) -> T {
        least + self.viscosity * 12.0 / (self.size * self.size)
    }

    /// τ_c of the continuity residual \[Pa s\], for a unit grad-div factor.
    #[inline(always)]
    pub fn continuity(&self) -> T {
        let convective = self.inertia * 0.5 * self.speed * self.size;
        let resistive = (self.drag - self.relieved) * self.size * self.size;
        (self.viscosity + convective + resistive) / (self.mixture * self.mixture) // (S2)
    }

    /// The same of one of several simplices.
    #[inline(always)]
    pub fn map<U>(&self, one: impl Fn(T) -> U) -> Scales<U> {
        Scales {
            rate: self.rate,
            inertia: one(self.inertia),
            viscosity: one(self.viscosity),
            drag: one(self.drag),
            relieved: one(self.relieved),
            speed: one(self.speed),
            mixture: one(self.mixture),
            size: one(self.size),
        }
    }
}

/// The mean over the corners of a simplex.
pub(super) fn mean<const N: usize>(value: &[f64; N]) -> f64 {
    let mut sum = value[0];
    for k in 1..N {
        sum += value[k];
    }
    sum / N as f64
}
