//! The seats that an engine may take.

use protocol::message::Role;

/// A seat of the coupled system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Seat {
    /// The fluid engine's.
    Fluid,
    /// The particle engine's.
    Particles,
}

impl Seat {
    /// The role of who takes it.
    pub fn role(self) -> Role {
        match self {
            Seat::Fluid => Role::Fluid,
            Seat::Particles => Role::Particles,
        }
    }
}
