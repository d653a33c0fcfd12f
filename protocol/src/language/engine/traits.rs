//! What an engine implements; the loop that connects it to the coupler is in `lockstep`.

use std::path::Path;

use crate::language::message::{Advance, Capability, Diagnostic, Failure, FailureKind};
use crate::language::report::{FluidReport, ParticleReport};
use crate::language::scene::{FluidScene, ParticleScene, Refinement};

use super::fields::{Inputs, Outputs};
use super::told::{InitialGrains, MeshDescription};

/// What is told of a candidate beside its fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Computed<R> {
    /// What the coupler goes by.
    pub report: R,
    /// Numbers for people; finite, SI units.
    pub diagnostics: Vec<Diagnostic>,
}

impl<R> From<R> for Computed<R> {
    fn from(report: R) -> Computed<R> {
        Computed {
            report,
            diagnostics: Vec::new(),
        }
    }
}

/// A solver that takes the fluid seat.
pub trait FluidEngine {
    /// Name and version, for the hello.
    fn identity(&self) -> (&'static str, &'static str);
    /// What it can do.
    fn capabilities(&self) -> Vec<Capability>;
    /// Take the scene's part, build the mesh and the initial state. Vectors of the scene fit its
    /// dimension; an engine refuses dimensions that it cannot do.
    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure>;
    /// Compute a candidate from the accepted state, which it must not change: fields that are sent to the
    /// fluid come in, all of a fluid candidate go out (the table of `protocol::field`).
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure>;
    /// Accept the last candidate.
    fn commit(&mut self) -> Result<(), Failure>;
    /// Write the accepted state.
    fn save(&mut self, path: &Path) -> Result<(), Failure>;
    /// Read the accepted state.
    fn restore(&mut self, path: &Path) -> Result<(), Failure>;
    /// Change to a mesh with cells of these sizes, before a step, and carry the accepted state over to it; none
    /// where the mesh stays as it is. Asked of engines with `Capability::Adapts` only, whose mesh depends on the
    /// sizes asked last and on the scene, not on the meshes before.
    fn adapt(&mut self, _: &Refinement) -> Result<Option<MeshDescription>, Failure> {
        Ok(None)
    }
}

/// A solver that takes the particle seat.
pub trait ParticleEngine {
    /// Name and version, for the hello.
    fn identity(&self) -> (&'static str, &'static str);
    /// What it can do.
    fn capabilities(&self) -> Vec<Capability>;
    /// Take the scene's part and the initial grains; answer with the grains that will be run. An engine
    /// refuses dimensions that it cannot do.
    fn configure(
        &mut self,
        scene: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure>;
    /// Compute a candidate from the accepted state, which it must not change: fields that are sent to the
    /// particles come in, all of a particle candidate go out (the table of `protocol::field`).
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure>;
    /// Accept the last candidate.
    fn commit(&mut self) -> Result<(), Failure>;
    /// Write the accepted state.
    fn save(&mut self, path: &Path) -> Result<(), Failure>;
    /// Read the accepted state.
    fn restore(&mut self, path: &Path) -> Result<(), Failure>;
    /// Take grains out of the accepted state, between a commit and the next step: by their numbers in the
    /// present order, ascending. The others keep their order; answer with them as they are now. Asked of
    /// engines with `Capability::RemovesGrains` only.
    fn remove(&mut self, grains: &[usize]) -> Result<InitialGrains, Failure> {
        let why = format!("{} grains leave, and this engine keeps all", grains.len());
        Err(Failure::new(FailureKind::Engine, why))
    }
}
