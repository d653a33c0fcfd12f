//! The two seats as the scheme sees them: typed calls over the protocol's partners. Here flat
//! numbers become vectors, and numbers become enumerations. Read in this order:
//!
//! * [`request`]: the place of a candidate in the run
//! * [`fluid`]: the fluid engine's seat
//! * [`particles`]: the particle engine's seat
//! * [`door`]: from what crosses the boundary to what the coupler computes with

pub mod door;
pub mod fluid;
pub mod particles;
pub mod request;

pub use fluid::FluidSeat;
pub use particles::ParticleSeat;
pub use request::Request;
