//! An engine's side of the protocol: what it implements ([`FluidEngine`], [`ParticleEngine`]) and the
//! loop that serves the coupler with it. Read `traits`, `session`, `lockstep`, `seats`, `serve`.

mod lockstep;
mod seats;
mod serve;
mod session;
mod traits;

pub use serve::{run_fluid, run_particles, serve_fluid, serve_particles};
pub use traits::{
    FluidAnswer, FluidEngine, FluidForces, GrainAnswer, InitialGrains, MeshDescription,
    ParticleEngine, SolidResponse,
};
