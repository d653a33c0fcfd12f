//! The particle seat: the only file that knows the protocol.

use std::io::Write;
use std::num::NonZeroU32;
use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use protocol::engine::{Computed, InitialGrains, Inputs, Outputs, ParticleEngine};
use protocol::field::Field;
use protocol::message::{Advance, Capability, Diagnostic, Failure, FailureKind};
use protocol::report::ParticleReport;
use protocol::scene::{ParticleScene, Wall, fixed};
use rapier2d_f64::prelude::PhysicsPipeline;

use crate::contacts::{Contacts, crossing};
use crate::world::{Model, Segment, Settings, World};

/// Sweeps of an iteration: one that corrects overlaps and one that does not.
const SWEEPS: f64 = 2.0;
/// First bytes of a checkpoint.
const MARK: &[u8; 16] = b"rapier-grains 1\n";

/// Grains on the contact solver of rapier: soft contacts, tuned for grains.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    settings: Settings,
}

struct Engine {
    settings: Settings,
    sub_steps_max: u32,
    run: Option<Run>,
}

/// What there is after `Configure`.
struct Run {
    model: Model,
    accepted: World,
    candidate: World,
}

/// `main` of the engine's process.
pub fn run() -> ExitCode {
    protocol::engine::run_particles(Engine {
        settings: Arguments::parse().settings,
        sub_steps_max: 1,
        run: None,
    })
}

impl ParticleEngine for Engine {
    fn identity(&self) -> (&'static str, &'static str) {
        ("rapier-particles", env!("CARGO_PKG_VERSION"))
    }

    fn capabilities(&self) -> Vec<Capability> {
        vec![
            Capability::ImplicitDrag,
            Capability::ContactState,
            Capability::Checkpoint,
            Capability::Spin,
        ]
    }

    fn configure(
        &mut self,
        scene: &ParticleScene,
        mut grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        if let Some(period) = scene.period.iter().flatten().next() {
            let why = format!(
                "rapier-particles has no periodic sides, the scene has a period of {period} m"
            );
            return Err(Failure::new(FailureKind::Scene, why));
        }
        let gravity = fixed(&scene.gravity).map_err(unusable_scene)?;
        let walls: Result<Vec<Segment>, String> = scene.walls.iter().map(segment).collect();
        let held: Vec<bool> = grains.fixed.iter().map(|&fixed| fixed != 0.0).collect();
        for k in (0..grains.velocity.len()).filter(|k| held[k / 2]) {
            grains.velocity[k] = 0.0;
        }
        let inertia = grains.mass.iter().zip(&grains.radius);
        let model = Model {
            settings: self.settings,
            gravity,
            walls: walls.map_err(unusable_scene)?,
            friction: [scene.friction, scene.wall_friction],
            inertia: inertia
                .map(|(m, r)| scene.inertia_factor * m * r * r)
                .collect(),
            radius: grains.radius.clone(),
            mass: grains.mass.clone(),
            fixed: held,
        };
        warn_of_overlap(&model);
        let accepted = World::new(&model, &grains.position, &grains.velocity);
        let candidate = accepted.clone();
        self.sub_steps_max = scene.sub_steps_max;
        self.run = Some(Run {
            model,
            accepted,
            candidate,
        });
        Ok(grains)
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        mut outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        let [drag, force] = [Field::GrainDrag, Field::GrainForce].map(|field| inputs.get(field));
        let sub_steps = self.sub_steps(request)?;
        let Run {
            model,
            accepted,
            candidate,
        } = self.run.as_mut().ok_or_else(not_configured)?;
        *candidate = accepted.clone();
        // Rapier's workspace: a fresh one, so that nothing of an earlier request is left in it.
        let mut pipeline = PhysicsPipeline::new();
        let count = model.radius.len();
        let places = |world: &World| -> Vec<f64> {
            (0..count).flat_map(|grain| world.position(grain)).collect()
        };
        let start = places(accepted);
        let mut before = start.clone();
        for _ in 0..sub_steps.get() {
            let dt = request.dt / f64::from(sub_steps.get());
            let stepped = candidate.step(model, &mut pipeline, dt, drag, force);
            stepped.map_err(|grain| {
                let why = format!("grain {grain} is no longer at a finite place");
                Failure::new(FailureKind::NotFinite, why)
            })?;
            let after = places(candidate);
            if let Some((grain, wall)) = crossing(model, &before, &after) {
                let why = format!(
                    "grain {grain} crossed wall {wall} in a sub-step of {dt:e} s: a smaller \
                     --sub-step-max or a higher --frequency is needed"
                );
                return Err(Failure::new(FailureKind::NotConverged, why));
            }
            before = after;
        }
        let velocity = outputs.take(Field::GrainVelocity);
        let mean_velocity = outputs.take(Field::GrainMeanVelocity);
        for k in 0..2 * count {
            velocity[k] = candidate.velocity(k / 2)[k % 2];
            mean_velocity[k] = (before[k] - start[k]) / request.dt;
        }
        outputs.take(Field::GrainPosition).copy_from_slice(&before);
        for (grain, spin) in outputs.take(Field::GrainSpin).iter_mut().enumerate() {
            *spin = candidate.spin(grain);
        }
        let contacts = Contacts::of(candidate, model);
        outputs
            .take(Field::GrainContact)
            .copy_from_slice(&contacts.state);
        let iterations = f64::from(sub_steps.get()) * f64::from(model.settings.iterations);
        let numbers = [
            ("contact_sweeps", SWEEPS * iterations),
            ("penetration_max", contacts.penetration),
            ("kinetic_energy", candidate.kinetic_energy(model)),
        ];
        let told = numbers.map(|(name, value)| Diagnostic {
            name: name.to_owned(),
            value,
        });
        Ok(Computed {
            report: ParticleReport {
                touching: Some(contacts.active as u64),
                sub_steps,
            },
            diagnostics: told.to_vec(),
        })
    }

    fn commit(&mut self) -> Result<(), Failure> {
        let run = self.run.as_mut().ok_or_else(not_configured)?;
        std::mem::swap(&mut run.accepted, &mut run.candidate);
        Ok(())
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        let run = self.run.as_ref().ok_or_else(not_configured)?;
        let configuration = bincode::config::standard();
        let bytes = bincode::serde::encode_to_vec(&run.accepted, configuration);
        let bytes = bytes.map_err(|error| unusable(path, error))?;
        let written = std::fs::write(path, [MARK.as_slice(), &bytes].concat());
        written.map_err(|error| unusable(path, error))
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        let run = self.run.as_mut().ok_or_else(not_configured)?;
        let bytes = std::fs::read(path).map_err(|error| unusable(path, error))?;
        let state = bytes.strip_prefix(MARK.as_slice());
        let state = state.ok_or_else(|| unusable(path, "not a checkpoint of rapier-particles"))?;
        let configuration = bincode::config::standard();
        let decoded = bincode::serde::decode_from_slice::<World, _>(state, configuration);
        let (world, length) = decoded.map_err(|error| unusable(path, error))?;
        if length != state.len() || world.count() != run.model.radius.len() {
            return Err(unusable(path, "not a checkpoint of these grains"));
        }
        run.accepted = world;
        Ok(())
    }
}

impl Engine {
    fn sub_steps(&self, request: &Advance) -> Result<NonZeroU32, Failure> {
        if let Some(asked) = NonZeroU32::new(request.sub_steps) {
            return Ok(asked);
        }
        let needed = (request.dt / self.settings.sub_step_max).ceil().max(1.0);
        if needed > f64::from(self.sub_steps_max) {
            let why = format!(
                "{needed} sub-steps of at most {} s are needed, contact.sub_steps_max is {}",
                self.settings.sub_step_max, self.sub_steps_max
            );
            return Err(Failure::new(FailureKind::NotConverged, why));
        }
        Ok(NonZeroU32::new(needed as u32).unwrap_or(NonZeroU32::MIN))
    }
}

/// A spring that is too soft for small grains is a wrong setting, not a wrong scene.
fn warn_of_overlap(model: &Model) {
    const TOO_MUCH: f64 = 1e-2;
    let smallest = model.radius.iter().copied().fold(f64::INFINITY, f64::min);
    let rate = 2.0 * std::f64::consts::PI * model.settings.frequency;
    let overlap = model.weight() / (rate * rate) / smallest;
    if overlap > TOO_MUCH {
        let enough = model.settings.frequency * (overlap / TOO_MUCH).sqrt();
        // On a log that may be full.
        let _ = writeln!(
            std::io::stderr(),
            "rapier-particles: a grain at rest will overlap by about {overlap:.1e} of the smallest \
             radius; --frequency {enough:.0} makes it 1e-2"
        );
    }
}

fn not_configured() -> Failure {
    Failure::new(FailureKind::Engine, "the engine is not configured")
}

/// A wall of the scene, which must be in the plane.
fn segment(wall: &Wall) -> Result<Segment, String> {
    let [a, b] = match &wall.corners[..] {
        [a, b] => [fixed(a)?, fixed(b)?],
        other => return Err(format!("a wall with {} corners", other.len())),
    };
    Ok(Segment { a, b })
}

fn unusable_scene(why: String) -> Failure {
    Failure::new(FailureKind::Scene, why)
}

fn unusable(path: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::new(FailureKind::Engine, format!("{}: {why}", path.display()))
}
