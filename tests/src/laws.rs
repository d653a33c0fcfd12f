//! What drag laws of spheres say of uniform suspensions and beds, in the words of their authors.
//!
//! ```text
//!   γ(φ, w) w = φ V Δρ g,   v = φ w      (H1)   force balance without a flux of the mixture
//! ```
//!
//! | symbol | meaning                                                                  | unit |
//! | ------ | ------------------------------------------------------------------------ | ---- |
//! | w      | slip, sphere minus fluid                                                 | m/s  |
//! | v      | fall speed of the spheres; flux that carries them where they are at rest | m/s  |
//! | φ      | porosity, 1 − c                                                          | –    |

use std::f64::consts::PI;

/// Equal spheres and the fluid around them, in the gravity of the Earth.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// r \[m\]
    pub radius: f64,
    /// ρ_p \[kg/m³\]
    pub grain_density: f64,
    /// ρ \[kg/m³\]
    pub density: f64,
    /// μ \[Pa s\]
    pub viscosity: f64,
}

/// Glass beads of 100 µm in water.
pub const GLASS_IN_WATER: Pair = Pair {
    radius: 5e-5,
    grain_density: 2500.0,
    density: 1000.0,
    viscosity: 1e-3,
};

/// Root of a function that grows with a speed \[m/s\], by bisection.
pub fn root(excess: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (1e-15, 1e3);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        match excess(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

impl Pair {
    /// V \[m³\]
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    /// Weight of the spheres of unit volume in the fluid, c Δρ g \[N/m³\].
    pub fn weight(&self, solid: f64) -> f64 {
        solid * (self.grain_density - self.density) * 9.81
    }

    /// Pressure gradient of a flux through a bed, without the hydrostatic part \[Pa/m\].
    ///
    /// ```text
    ///   150 μ c²/(φ³ d²) U + 1.75 ρ c/(φ³ d) U²      (H2)  Ergun 1952
    /// ```
    pub fn ergun_gradient(&self, solid: f64, flux: f64) -> f64 {
        let (cube, diameter) = ((1.0 - solid).powi(3), 2.0 * self.radius);
        let viscous = 150.0 * self.viscosity * solid * solid / (cube * diameter * diameter);
        let inertial = 1.75 * self.density * solid / (cube * diameter);
        viscous * flux + inertial * flux * flux // (H2)
    }

    /// Flux that carries a bed by (H2): v of (H1).
    pub fn ergun(&self, solid: f64) -> f64 {
        root(|flux| self.ergun_gradient(solid, flux) - self.weight(solid))
    }

    /// v of (H1) with the drag of Wen and Yu (1966).
    pub fn wen_yu(&self, solid: f64) -> f64 {
        let (porosity, diameter) = (1.0 - solid, 2.0 * self.radius);
        let area = PI * self.radius * self.radius;
        let carried = self.weight(porosity) * self.volume();
        let slip = root(|slip| {
            let reynolds = self.density * porosity * diameter * slip / self.viscosity;
            let coefficient = 24.0 / reynolds * (1.0 + 0.15 * reynolds.powf(0.687));
            let alone = 0.5 * self.density * area * coefficient * slip * slip;
            alone * porosity.powf(-1.65) - carried
        });
        porosity * slip
    }

    /// Minimum fluidisation of Wen and Yu's correlation \[m/s\], which knows no porosity.
    ///
    /// ```text
    ///   Re = √(33.7² + 0.0408 Ar) − 33.7,   Ar = ρ Δρ g d³/μ²      (H3)  Wen and Yu 1966
    /// ```
    pub fn wen_yu_minimum(&self) -> f64 {
        let diameter = 2.0 * self.radius;
        let archimedes =
            self.density * self.weight(1.0) * diameter.powi(3) / (self.viscosity * self.viscosity);
        let reynolds = (33.7_f64.powi(2) + 0.0408 * archimedes).sqrt() - 33.7; // (H3)
        reynolds * self.viscosity / (self.density * diameter)
    }
}
