//! The two seats of a coupled system that engines take.

use serde::{Deserialize, Serialize};

/// Which seat of the coupled system an engine takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Role {
    /// Solves the fluid on a mesh.
    Fluid,
    /// Moves the grains.
    Particles,
}

impl Role {
    /// Name of the seat.
    pub fn seat(self) -> &'static str {
        match self {
            Role::Fluid => "fluid",
            Role::Particles => "particles",
        }
    }
}
