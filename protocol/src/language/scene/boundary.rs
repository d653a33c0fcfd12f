//! Boundary conditions of the fluid.

use serde::{Deserialize, Serialize};

/// A boundary condition of the fluid. Velocities are superficial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Boundary {
    /// u = 0.
    NoSlip,
    /// u·n = 0, no tangential traction.
    Slip,
    /// Joined with the opposite side of the rectangle.
    Periodic,
    /// u given; also a moving wall.
    Inflow {
        /// Superficial velocity \[m/s\]; of the maximum when parabolic.
        velocity: [f64; 2],
        /// Shape across the boundary.
        profile: Profile,
    },
    /// Pressure given at the boundary's highest point \[Pa\]; hydrostatic (ρ g) along it.
    Open {
        /// Pressure \[Pa\].
        pressure: f64,
    },
}

/// Shape of an inflow across its boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// The same everywhere.
    Uniform,
    /// Zero at both ends, `velocity` in the middle.
    Parabolic,
}
