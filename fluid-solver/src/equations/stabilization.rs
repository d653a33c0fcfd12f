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

/// Element means that the parameters depend on.
#[derive(Debug, Clone, Copy)]
pub struct Scales {
    /// α/Δt \[1/s\].
    pub rate: f64,
    /// ρφ \[kg/m³\].
    pub inertia: f64,
    /// μφ \[Pa s\].
    pub viscosity: f64,
    /// β \[kg/(m³ s)\].
    pub drag: f64,
    /// What of β is not in β_c \[kg/(m³ s)\].
    pub relieved: f64,
    /// |a| \[m/s\].
    pub speed: f64,
    /// P = φ + c.
    pub mixture: f64,
    /// h \[m\].
    pub size: f64,
}

impl Scales {
    /// τ of the momentum residual \[m³ s/kg\].
    pub fn momentum(&self) -> f64 {
        let transient = self.inertia * self.rate;
        let convective = 2.0 * self.inertia * self.speed / self.size;
        let viscous = 12.0 * self.viscosity / (self.size * self.size);
        let squares = transient * transient + convective * convective + viscous * viscous;
        1.0 / (squares + self.drag * self.drag).sqrt() // (S1)
    }

    /// b0: what holds a node beside the drag \[kg/(m³ s)\].
    pub fn other_than_drag(&self) -> f64 {
        let convective = self.inertia * self.speed / self.size;
        convective + 3.0 * self.viscosity / (self.size * self.size) // (S3)
    }

    /// Drag from which on it is left out of τ_c, where the least of the corners is `least` \[kg/(m³ s)\].
    pub fn viscous_bound(&self, least: f64) -> f64 {
        least + 12.0 * self.viscosity / (self.size * self.size)
    }

    /// τ_c of the continuity residual \[Pa s\], for a unit grad-div factor.
    pub fn continuity(&self) -> f64 {
        let convective = 0.5 * self.inertia * self.speed * self.size;
        let resistive = (self.drag - self.relieved) * self.size * self.size;
        (self.viscosity + convective + resistive) / (self.mixture * self.mixture) // (S2)
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
