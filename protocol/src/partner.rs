//! The coupler's side of a link to one engine.

use std::path::Path;

use crate::configure::{FluidScene, Limits, ParticleScene};
use crate::engine::{InitialGrains, MeshDescription};
use crate::error::Error;
use crate::field::Field;
use crate::messages::{Advance, Done, Hello, Role};
use crate::runspace::RunSpace;

/// One engine, seen from the coupler.
pub struct Partner {
    hello: Hello,
}

fn not_yet<T>() -> Result<T, Error> {
    Err(Error::transport("protocol", "not connected in this build"))
}

impl Partner {
    /// Wait for the engine of this seat to say hello.
    pub fn accept(_role: Role, _runspace: &RunSpace, _limits: &Limits) -> Result<Partner, Error> {
        not_yet()
    }
    /// What the engine said about itself.
    pub fn hello(&self) -> &Hello {
        &self.hello
    }
    /// Send the fluid's part of the scene; answered by the mesh.
    pub fn configure_fluid(&mut self, _scene: &FluidScene) -> Result<MeshDescription, Error> {
        not_yet()
    }
    /// Send the particles' part of the scene; answered by the grains that will be run.
    pub fn configure_particles(
        &mut self,
        _scene: &ParticleScene,
        _grains: &InitialGrains,
    ) -> Result<InitialGrains, Error> {
        not_yet()
    }
    /// Compute a candidate. `request.fields` is filled here from `inputs`.
    pub fn advance(
        &mut self,
        _request: &Advance,
        _inputs: &[(Field, &[f64])],
        _outputs: &mut [(Field, &mut Vec<f64>)],
    ) -> Result<Done, Error> {
        not_yet()
    }
    /// Accept the last candidate of this step.
    pub fn commit(&mut self, _step: u64) -> Result<(), Error> {
        not_yet()
    }
    /// Let the engine write its accepted state.
    pub fn save(&mut self, _path: &Path) -> Result<(), Error> {
        not_yet()
    }
    /// Let the engine read its accepted state.
    pub fn restore(&mut self, _path: &Path) -> Result<(), Error> {
        not_yet()
    }
    /// The run is over; returns when the engine has left.
    pub fn finish(&mut self) -> Result<(), Error> {
        not_yet()
    }
}
