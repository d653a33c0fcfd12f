//! What the particle engine needs to know.

use serde::{Deserialize, Serialize};

/// What the particle engine needs to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParticleScene {
    /// g \[m/s²\]; the engine applies the full weight m g.
    pub gravity: [f64; 2],
    /// Wall segments; grains stay on the left of a → b, and off both ends.
    pub walls: Vec<Wall>,
    /// Period in x and y \[m\], where the domain is periodic.
    pub period: [Option<f64>; 2],
    /// Coulomb coefficient between grains.
    pub friction: f64,
    /// Coulomb coefficient between grains and walls.
    pub wall_friction: f64,
    /// Moment of inertia over m r²: 1/2 for disks, 2/5 for spheres.
    pub inertia_factor: f64,
    /// Contact residual (natural map) at which a solve stops, relative to |g|Δt.
    pub tolerance: f64,
    /// Sweeps allowed; more is an error.
    pub sweeps_max: usize,
    /// Sub-steps allowed in a coupling step; more is an error.
    pub sub_steps_max: u32,
    /// Threads the engine may use.
    pub threads: usize,
}

/// A wall segment from a to b \[m\]; solid on its right.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Start.
    pub a: [f64; 2],
    /// End.
    pub b: [f64; 2],
}

impl Wall {
    /// From a point to the nearest point of the segment \[m\].
    pub fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        let ([ax, ay], [bx, by]) = (self.a, self.b);
        let (tx, ty) = (bx - ax, by - ay);
        let along = ((x - ax) * tx + (y - ay) * ty) / (tx * tx + ty * ty);
        let along = along.clamp(0.0, 1.0);
        (x - ax - along * tx).hypot(y - ay - along * ty)
    }
}
