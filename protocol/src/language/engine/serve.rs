//! Serving a coupler with an engine, over any channel or as the process of a run.

use std::process::ExitCode;

use crate::language::error::Error;
use crate::language::message::Role;
use crate::run::process;
use crate::transport::channel::Channel;
use crate::transport::ipc::engine_link;

use super::lockstep::serve;
use super::seats::{FluidSeat, ParticleSeat};
use super::traits::{FluidEngine, ParticleEngine};

/// Serve the coupler at the other end of `link` until `Finish`.
pub fn serve_fluid(engine: &mut impl FluidEngine, link: Box<dyn Channel>) -> Result<(), Error> {
    serve(&mut FluidSeat(engine), link)
}

/// Serve the coupler at the other end of `link` until `Finish`.
pub fn serve_particles(
    engine: &mut impl ParticleEngine,
    link: Box<dyn Channel>,
) -> Result<(), Error> {
    serve(&mut ParticleSeat(engine), link)
}

/// `main` of a fluid engine's process: enters the run named by the environment, serves the coupler
/// until `Finish`, returns the exit code.
pub fn run_fluid(mut engine: impl FluidEngine) -> ExitCode {
    process::run(Role::Fluid.seat(), |runspace| {
        let link = engine_link(runspace, Role::Fluid)?;
        serve_fluid(&mut engine, link)
    })
}

/// `main` of a particle engine's process; see [`run_fluid`].
pub fn run_particles(mut engine: impl ParticleEngine) -> ExitCode {
    process::run(Role::Particles.seat(), |runspace| {
        let link = engine_link(runspace, Role::Particles)?;
        serve_particles(&mut engine, link)
    })
}
