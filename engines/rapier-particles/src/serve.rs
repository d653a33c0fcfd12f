//! The particle seat: the only file that knows the protocol.

use std::io::Write;
use std::num::NonZeroU32;
use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use protocol::engine::{Computed, InitialGrains, Inputs, Outputs, ParticleEngine, PlaneOrSpace};
use protocol::field::Field;
use protocol::message::{Advance, Capability, Diagnostic, Failure, FailureKind};
use protocol::report::ParticleReport;
use protocol::scene::{ParticleScene, Wall, fixed};
use space::{Dim, Dimension, Linear, Spin, Vector, flat};

use crate::bodies::Bodies;
use crate::contacts::Contacts;
use crate::model::{Model, Settings, crossing};
use crate::{plane, solid};

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

/// The rapier of the plane, or that of space.
type Engine = PlaneOrSpace<Grains<2, 3, plane::World>, Grains<3, 4, solid::World>>;

/// Grains in `D` dimensions, `N` corners a simplex.
struct Grains<const D: usize, const N: usize, W> {
    settings: Settings,
    sub_steps_max: u32,
    run: Option<Run<D, W>>,
}

/// What there is after `Configure`.
struct Run<const D: usize, W> {
    model: Model<D>,
    accepted: W,
    candidate: W,
}

/// `main` of the engine's process.
pub fn run() -> ExitCode {
    let settings = Arguments::parse().settings;
    protocol::engine::run_particles(Engine::new(Grains::new(settings), Grains::new(settings)))
}

impl<const D: usize, const N: usize, W: Bodies<D>> ParticleEngine for Grains<D, N, W>
where
    Dim<D>: Dimension<D>,
{
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
        let gravity: [f64; D] = fixed(&scene.gravity).map_err(unusable_scene)?;
        let walls: Result<Vec<_>, String> = scene.walls.iter().map(corners).collect();
        let held: Vec<bool> = grains.fixed.iter().map(|&fixed| fixed != 0.0).collect();
        for k in (0..grains.velocity.len()).filter(|k| held[k / D]) {
            grains.velocity[k] = 0.0;
        }
        let inertia = grains.mass.iter().zip(&grains.radius);
        let model = Model {
            settings: self.settings,
            gravity: gravity.into(),
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
        let place = vectors(&grains.position).map_err(unusable_scene)?;
        let velocity = vectors(&grains.velocity).map_err(unusable_scene)?;
        let accepted = W::new(&model, place, velocity);
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
        let (drag, force) = (inputs.get(Field::GrainDrag), inputs.get(Field::GrainForce));
        let force = force.map(vectors).transpose().map_err(broken)?;
        let sub_steps = self.sub_steps(request)?;
        let Run {
            model,
            accepted,
            candidate,
        } = self.run.as_mut().ok_or_else(not_configured)?;
        *candidate = accepted.clone();
        // A fresh workspace, so that nothing of an earlier request is left in it.
        let mut pipeline = W::Pipeline::default();
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
            if let Some((grain, wall)) = crossing::<D, N>(model, &before, &after) {
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
        for k in 0..D * before.len() {
            velocity[k] = candidate.velocity(k / D)[k % D];
            mean_velocity[k] = (before[k / D][k % D] - start[k / D][k % D]) / request.dt;
        }
        let position = outputs.take(Field::GrainPosition);
        position.copy_from_slice(flat::numbers(&before));
        let components = <Spin<D>>::COMPONENTS;
        for (k, spin) in outputs.take(Field::GrainSpin).iter_mut().enumerate() {
            *spin = candidate.spin(k / components).component(k % components);
        }
        let contacts = Contacts::of(&candidate.pairs(model), &model.fixed);
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
        let decoded = bincode::serde::decode_from_slice::<W, _>(state, configuration);
        let (world, length) = decoded.map_err(|error| unusable(path, error))?;
        if length != state.len() || world.count() != run.model.radius.len() {
            return Err(unusable(path, "not a checkpoint of these grains"));
        }
        run.accepted = world;
        Ok(())
    }
}

impl<const D: usize, const N: usize, W> Grains<D, N, W> {
    fn new(settings: Settings) -> Self {
        Grains {
            settings,
            sub_steps_max: 1,
            run: None,
        }
    }

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
fn warn_of_overlap<const D: usize>(model: &Model<D>) {
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

/// The corners of a wall of the scene.
fn corners<const D: usize>(wall: &Wall) -> Result<[Vector<D>; D], String> {
    let corners = wall.corners.iter().map(|corner| fixed::<D, f64>(corner));
    let corners: Result<Vec<[f64; D]>, String> = corners.collect();
    Ok(fixed::<D, [f64; D]>(&corners?)?.map(Vector::from))
}

/// Vectors from interleaved components.
fn vectors<const D: usize>(numbers: &[f64]) -> Result<&[Vector<D>], String> {
    let count = numbers.len();
    flat::vectors(numbers).ok_or_else(|| format!("{count} components of vectors, not {D} of each"))
}

/// Centres of all grains \[m\].
fn places<const D: usize>(world: &impl Bodies<D>) -> Vec<Vector<D>>
where
    Dim<D>: Dimension<D>,
{
    (0..world.count())
        .map(|grain| world.position(grain))
        .collect()
}

fn broken(why: String) -> Failure {
    Failure::new(FailureKind::Engine, why)
}

fn unusable_scene(why: String) -> Failure {
    Failure::new(FailureKind::Scene, why)
}

fn unusable(path: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::new(FailureKind::Engine, format!("{}: {why}", path.display()))
}
