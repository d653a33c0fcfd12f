//! An engine of two: one for scenes of the plane, one for those of space.

use std::path::Path;

use crate::language::message::{Advance, Capability, Failure};
use crate::language::report::{FluidReport, ParticleReport};
use crate::language::scene::{FluidScene, ParticleScene, Refinement};

use super::fields::{Inputs, Outputs};
use super::told::{InitialGrains, MeshDescription};
use super::traits::{Computed, FluidEngine, ParticleEngine};

/// The engine `P` in the plane and `S` in space; the scene decides. Both have one identity and one list of
/// capabilities, those of `P`.
#[derive(Debug, Default)]
pub struct PlaneOrSpace<P, S> {
    plane: P,
    space: S,
    in_space: bool,
}

impl<P, S> PlaneOrSpace<P, S> {
    /// Of these two.
    pub fn new(plane: P, space: S) -> PlaneOrSpace<P, S> {
        PlaneOrSpace {
            plane,
            space,
            in_space: false,
        }
    }
}

impl<P: FluidEngine, S: FluidEngine> PlaneOrSpace<P, S> {
    fn fluid(&mut self) -> &mut dyn FluidEngine {
        match self.in_space {
            false => &mut self.plane,
            true => &mut self.space,
        }
    }
}

impl<P: ParticleEngine, S: ParticleEngine> PlaneOrSpace<P, S> {
    fn particles(&mut self) -> &mut dyn ParticleEngine {
        match self.in_space {
            false => &mut self.plane,
            true => &mut self.space,
        }
    }
}

impl<P: FluidEngine, S: FluidEngine> FluidEngine for PlaneOrSpace<P, S> {
    fn identity(&self) -> (&'static str, &'static str) {
        self.plane.identity()
    }

    fn capabilities(&self) -> Vec<Capability> {
        self.plane.capabilities()
    }

    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        self.in_space = scene.dimension == 3;
        self.fluid().configure(scene)
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure> {
        self.fluid().advance(request, inputs, outputs)
    }

    fn commit(&mut self) -> Result<(), Failure> {
        self.fluid().commit()
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.fluid().save(path)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.fluid().restore(path)
    }

    fn adapt(&mut self, sizes: &Refinement) -> Result<Option<MeshDescription>, Failure> {
        self.fluid().adapt(sizes)
    }
}

impl<P: ParticleEngine, S: ParticleEngine> ParticleEngine for PlaneOrSpace<P, S> {
    fn identity(&self) -> (&'static str, &'static str) {
        self.plane.identity()
    }

    fn capabilities(&self) -> Vec<Capability> {
        self.plane.capabilities()
    }

    fn configure(
        &mut self,
        scene: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        self.in_space = scene.dimension == 3;
        self.particles().configure(scene, grains)
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        self.particles().advance(request, inputs, outputs)
    }

    fn commit(&mut self) -> Result<(), Failure> {
        self.particles().commit()
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.particles().save(path)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.particles().restore(path)
    }

    fn remove(&mut self, grains: &[usize]) -> Result<InitialGrains, Failure> {
        self.particles().remove(grains)
    }
}
