//! Boundary conditions of the fluid: one enumeration from the scene to the equations.

use serde::{Deserialize, Serialize};

/// A boundary condition of the fluid. Velocities are superficial; `V` is a vector, on its way as flat
/// numbers, in an engine of its own type ([`Boundary::try_map`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Boundary<V = Vec<f64>> {
    /// u = 0.
    NoSlip,
    /// u·n = 0, no tangential traction.
    Slip,
    /// Joined with the opposite side of the rectangle.
    Periodic,
    /// u given; also a moving wall.
    Inflow {
        /// Superficial velocity \[m/s\]; of the maximum when parabolic.
        velocity: V,
        /// Shape across the boundary.
        profile: Profile,
    },
    /// Pressure given at the boundary's highest point \[Pa\]; hydrostatic (ρ g) along it.
    Open {
        /// Pressure \[Pa\].
        pressure: f64,
    },
}

impl<V> Boundary<V> {
    /// The same condition with its vectors in another form; the error of a vector that has none.
    pub fn try_map<W, E>(&self, vector: impl FnOnce(&V) -> Result<W, E>) -> Result<Boundary<W>, E> {
        Ok(match self {
            Boundary::NoSlip => Boundary::NoSlip,
            Boundary::Slip => Boundary::Slip,
            Boundary::Periodic => Boundary::Periodic,
            Boundary::Inflow { velocity, profile } => Boundary::Inflow {
                velocity: vector(velocity)?,
                profile: *profile,
            },
            Boundary::Open { pressure } => Boundary::Open {
                pressure: *pressure,
            },
        })
    }
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
