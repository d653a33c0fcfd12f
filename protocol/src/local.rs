//! Engines on threads of this process, for tests: the same loop and the same messages, on the heap.

use crate::engine::{FluidEngine, ParticleEngine};
use crate::error::Error;
use crate::partner::Partner;

/// Run a fluid engine on a thread; `make` is called on that thread.
pub fn spawn_fluid<E: FluidEngine>(
    _make: impl FnOnce() -> E + Send + 'static,
) -> Result<Partner, Error> {
    Err(Error::transport("protocol", "not connected in this build"))
}

/// Run a particle engine on a thread; `make` is called on that thread.
pub fn spawn_particles<E: ParticleEngine>(
    _make: impl FnOnce() -> E + Send + 'static,
) -> Result<Partner, Error> {
    Err(Error::transport("protocol", "not connected in this build"))
}
