//! Boundary conditions of the fluid: one enumeration from the scene to the equations.

use std::convert::Infallible;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A boundary condition of the fluid, as a scene writes it and as it travels. Velocities are
/// superficial; `V` is a vector: flat numbers on the way, of a fixed length in a scene and an engine
/// ([`Boundary::try_map`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Boundary<V = Vec<f64>> {
    /// u = 0.
    NoSlip,
    /// u·n = 0, no tangential traction.
    Slip,
    /// Joined with the opposite side of the rectangle.
    Periodic,
    /// Velocity given; also a moving wall.
    Inflow {
        /// Superficial velocity (m/s); the largest one when parabolic.
        velocity: V,
        /// Shape across the boundary: "uniform" or "parabolic".
        #[serde(default)]
        profile: Profile,
    },
    /// Pressure given at the highest point, hydrostatic (ρ g) along the boundary.
    Open {
        /// Pressure (Pa).
        pressure: f64,
    },
    /// u given, along the boundary: a wall that moves.
    MovingWall {
        /// Velocity of the wall (m/s).
        velocity: V,
    },
}

impl<V> Boundary<V> {
    /// The same condition with its vectors in another form.
    pub fn map<W>(&self, vector: impl FnOnce(&V) -> W) -> Boundary<W> {
        let Ok(mapped) = self.try_map(|v| Ok::<W, Infallible>(vector(v)));
        mapped
    }

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
            Boundary::MovingWall { velocity } => Boundary::MovingWall {
                velocity: vector(velocity)?,
            },
        })
    }
}

impl<V: AsRef<[f64]>> Boundary<V> {
    /// The numbers given with it, each with its place below the name of the boundary in a scene.
    pub fn numbers(&self) -> Option<(&'static str, &[f64])> {
        match self {
            Boundary::NoSlip | Boundary::Slip | Boundary::Periodic => None,
            Boundary::Inflow { velocity, .. } => Some(("inflow.velocity", velocity.as_ref())),
            Boundary::Open { pressure } => Some(("open.pressure", std::slice::from_ref(pressure))),
            Boundary::MovingWall { velocity } => Some(("no-slip.velocity", velocity.as_ref())),
        }
    }
}

/// What grains meet at a boundary of the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GrainBoundary {
    /// A wall.
    Wall,
    /// Nothing: they go on, and one that leaves the mesh ends the run.
    Open,
    /// Nothing, and they are taken out where they leave the mesh.
    Removed,
}

/// Shape of an inflow across its boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// The same everywhere.
    #[default]
    Uniform,
    /// Zero at both ends, `velocity` in the middle.
    Parabolic,
}
