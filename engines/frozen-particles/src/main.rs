//! A particle engine whose grains do not move: what a test of a fluid or a one-way study needs.

use std::path::Path;
use std::process::ExitCode;

use protocol::engine::{FluidForces, GrainAnswer, InitialGrains, ParticleEngine};
use protocol::message::{Advance, Capability, Diagnostic, Failure, FailureKind};
use protocol::scene::ParticleScene;

/// All that a checkpoint holds.
const MARK: &str = "frozen-particles: grains that do not move have no state\n";
/// `grain_contact` of a grain that is held.
const HELD: f64 = 2.0;

/// Where the grains are.
#[derive(Debug, Default)]
struct Engine {
    position: Vec<f64>,
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
        ]
    }

    fn configure(
        &mut self,
        _scene: &ParticleScene,
        mut grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        grains.velocity.fill(0.0);
        self.position.clone_from(&grains.position);
        Ok(grains)
    }

    fn advance(
        &mut self,
        _request: &Advance,
        _fluid: &FluidForces<'_>,
        answer: GrainAnswer<'_>,
    ) -> Result<Vec<Diagnostic>, Failure> {
        answer.position.copy_from_slice(&self.position);
        answer.velocity.fill(0.0);
        answer.mean_velocity.fill(0.0);
        answer.contact.fill(HELD);
        Ok(vec![Diagnostic {
            name: "sub_steps".to_owned(),
            value: 1.0,
        }])
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
}

fn unusable(path: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::new(FailureKind::Engine, format!("{}: {why}", path.display()))
}
