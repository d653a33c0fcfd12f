//! A particle engine whose grains do not move: what a test of a fluid or a one-way study needs.

use std::path::Path;
use std::process::ExitCode;

use protocol::engine::{Computed, InitialGrains, Inputs, Outputs, ParticleEngine};
use protocol::field::Field;
use protocol::message::{Advance, Capability, Failure, FailureKind};
use protocol::report::ParticleReport;
use protocol::scene::ParticleScene;

/// All that a checkpoint holds.
const MARK: &str = "frozen-particles: grains that do not move have no state\n";
/// `grain_contact` of a grain that is held.
const HELD: f64 = 2.0;

/// The grains, at rest.
#[derive(Debug, Default)]
struct Engine {
    grains: InitialGrains,
}

fn main() -> ExitCode {
    protocol::engine::run_particles(Engine::default())
}

impl ParticleEngine for Engine {
    fn identity(&self) -> (&'static str, &'static str) {
        ("frozen-particles", env!("CARGO_PKG_VERSION"))
    }

    fn capabilities(&self) -> Vec<Capability> {
        // A drag of any size is taken: it does not move them.
        vec![
            Capability::ImplicitDrag,
            Capability::ContactState,
            Capability::Checkpoint,
            Capability::RemovesGrains,
        ]
    }

    fn configure(
        &mut self,
        _scene: &ParticleScene,
        mut grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        grains.velocity.fill(0.0);
        self.grains.clone_from(&grains);
        Ok(grains)
    }

    fn advance(
        &mut self,
        _request: &Advance,
        _inputs: &Inputs<'_>,
        mut outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        outputs
            .take(Field::GrainPosition)
            .copy_from_slice(&self.grains.position);
        outputs.take(Field::GrainVelocity).fill(0.0);
        outputs.take(Field::GrainMeanVelocity).fill(0.0);
        outputs.take(Field::GrainContact).fill(HELD);
        Ok(ParticleReport::one_step().into())
    }

    fn commit(&mut self) -> Result<(), Failure> {
        Ok(())
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        std::fs::write(path, MARK).map_err(|error| unusable(path, error))
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        match std::fs::read(path) {
            Ok(bytes) if bytes == MARK.as_bytes() => Ok(()),
            Ok(_) => Err(unusable(path, "not a checkpoint of frozen-particles")),
            Err(error) => Err(unusable(path, error)),
        }
    }

    fn remove(&mut self, grains: &[usize]) -> Result<InitialGrains, Failure> {
        self.grains = self.grains.without(grains);
        Ok(self.grains.clone())
    }
}

fn unusable(path: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::new(FailureKind::Engine, format!("{}: {why}", path.display()))
}
