//! An engine's side of the protocol: what it implements ([`FluidEngine`], [`ParticleEngine`]) and the
//! loop that serves the coupler with it. Read `told`, `fields`, `traits`, `session`, `lockstep`, `seats`,
//! `serve`; `dimensions` makes one of two.

mod dimensions;
mod fields;
mod lockstep;
mod seats;
mod serve;
mod session;
pub(crate) mod told;
mod traits;

pub use dimensions::PlaneOrSpace;
pub use fields::{Inputs, Outputs};
pub use serve::{run_fluid, run_particles, serve_fluid, serve_particles};
pub use told::{FacetDescription, InitialGrains, MeshDescription, without};
pub use traits::{Computed, FluidEngine, ParticleEngine};
