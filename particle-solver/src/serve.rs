//! The particle seat: the only file that knows the protocol. It translates, nothing more.

use std::path::Path;
use std::process::ExitCode;

use protocol::engine::{Computed, InitialGrains, Inputs, Outputs, ParticleEngine, PlaneOrSpace};
use protocol::field::Field;
use protocol::message::{Advance, Capability, Diagnostic, Failure, FailureKind};
use protocol::process::may_leave_out;
use protocol::report::ParticleReport;
use protocol::scene::{ContactSolver, ParticleScene, Wall, fixed};

use space::{Dim, Dimension, Linear, Spin, Vector, flat};

use crate::error::Error;
use crate::grains::{Grains, State, without};
use crate::setup::Setup;
use crate::small::choice::Solver;
use crate::step::candidate::Candidate;
use crate::step::engine::ContactEngine;
use crate::step::request::{Forces, Request};
use crate::walls::facet::Facet;

/// The built-in particle engine.
pub type Engine = PlaneOrSpace<Particles<2>, Particles<3>>;

/// The same in `D` dimensions.
#[derive(Debug, Default)]
pub struct Particles<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    solver: Option<ContactEngine<D>>,
    /// Volumes of the grains, which are asked for with the others that stay \[m³\].
    volume: Vec<f64>,
    /// Searches and looks at walls up to the last accepted step.
    counted: [u64; 2],
    /// Were there candidates for a contact in some step?
    met: bool,
    /// Were contacts solved in small steps in some step?
    pressed: bool,
}

/// `main` of the engine's process.
pub fn run() -> ExitCode {
    protocol::engine::run_particles(Engine::default())
}

impl<const D: usize> ParticleEngine for Particles<D>
where
    Dim<D>: Dimension<D>,
{
    fn identity(&self) -> (&'static str, &'static str) {
        ("sillage-particles", env!("CARGO_PKG_VERSION"))
    }

    fn capabilities(&self) -> Vec<Capability> {
        vec![
            Capability::ImplicitDrag,
            Capability::ContactState,
            Capability::Checkpoint,
            Capability::MovingWalls,
            Capability::Spin,
            Capability::RemovesGrains,
        ]
    }

    fn configure(
        &mut self,
        scene: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        let mut solver = build(scene, &grains).map_err(failure)?;
        solver.search_always(!may_leave_out());
        let grains = InitialGrains {
            velocity: flat::numbers(&solver.accepted().velocity).to_vec(),
            ..grains
        };
        tracing::info!(
            grains = solver.grains().count(),
            walls = scene.walls.len(),
            "grains; one thread is used, whatever the scene allows"
        );
        self.solver = Some(solver);
        self.volume.clone_from(&grains.volume);
        Ok(grains)
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        let request = Request {
            step: request.step,
            pass: request.pass,
            dt: request.dt,
            sub_steps: request.sub_steps,
            tolerance: request.tolerance,
        };
        let forces = Forces {
            drag: inputs.get(Field::GrainDrag),
            force: inputs
                .get(Field::GrainForce)
                .map(vectors)
                .transpose()
                .map_err(failure)?,
        };
        let solver = self.solver.as_mut().ok_or_else(not_configured)?;
        let candidate = solver.advance(&request, &forces).map_err(failure)?;
        write(candidate, outputs)?;
        let small = candidate.report.sinking.is_some();
        if small && !self.pressed {
            let sub_steps = candidate.report.sub_steps;
            tracing::info!(
                step = request.step,
                sub_steps,
                "contacts are solved in small steps"
            );
        }
        self.pressed |= small;
        if candidate.report.candidates > 0 && !self.met {
            tracing::info!(
                step = request.step,
                "grains or walls are near enough to meet"
            );
            self.met = true;
        }
        let (report, mut numbers) = told(candidate)?;
        let [searches, looks] = [0, 1].map(|k| (solver.searches()[k] - self.counted[k]) as f64);
        numbers.push(named("contact_searches", searches));
        numbers.push(named("contact_wall_looks", looks));
        Ok(Computed {
            report,
            diagnostics: numbers,
        })
    }

    fn commit(&mut self) -> Result<(), Failure> {
        self.solver()?.commit().map_err(failure)?;
        self.counted = self.solver()?.searches();
        Ok(())
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.solver()?.save(path).map_err(failure)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        let solver = self.solver()?;
        solver.restore(path).map_err(failure)?;
        self.counted = solver.searches();
        Ok(())
    }

    fn remove(&mut self, grains: &[usize]) -> Result<InitialGrains, Failure> {
        self.solver()?.remove(grains).map_err(failure)?;
        self.volume = without(&self.volume, grains);
        let solver = self.solver.as_ref().ok_or_else(not_configured)?;
        Ok(present(solver, &self.volume))
    }
}

impl<const D: usize> Particles<D>
where
    Dim<D>: Dimension<D>,
{
    fn solver(&mut self) -> Result<&mut ContactEngine<D>, Failure> {
        self.solver.as_mut().ok_or_else(not_configured)
    }
}

fn not_configured() -> Failure {
    Failure::new(FailureKind::Engine, "the engine is not configured")
}

/// The class of an error.
fn failure(error: Error) -> Failure {
    let kind = match &error {
        Error::Setup(_) => FailureKind::Scene,
        Error::NotFinite { .. } => FailureKind::NotFinite,
        Error::NotConverged { .. }
        | Error::SubSteps { .. }
        | Error::SmallSteps { .. }
        | Error::Overlap { .. }
        | Error::Crowded { .. }
        | Error::TooFar { .. }
        | Error::Margin { .. } => FailureKind::NotConverged,
        Error::Request(_) | Error::Checkpoint { .. } => FailureKind::Engine,
    };
    Failure::new(kind, error.to_string())
}

fn build<const D: usize>(
    scene: &ParticleScene,
    grains: &InitialGrains,
) -> Result<ContactEngine<D>, Error>
where
    Dim<D>: Dimension<D>,
{
    let walls: Result<Vec<Facet<D>>, String> = scene.walls.iter().map(facet).collect();
    let setup = Setup {
        gravity: Vector::from(fixed(&scene.gravity).map_err(Error::Setup)?),
        walls: walls.map_err(Error::Setup)?,
        period: fixed(&scene.period).map_err(Error::Setup)?,
        friction: scene.friction,
        wall_friction: scene.wall_friction,
        inertia_factor: scene.inertia_factor,
        solver: scene.solver.map(solver),
        tolerance: scene.tolerance,
        sweeps_max: scene.sweeps_max,
        sub_steps_max: scene.sub_steps_max,
    };
    let properties = Grains {
        radius: grains.radius.clone(),
        mass: grains.mass.clone(),
        fixed: grains.fixed.iter().map(|&fixed| fixed != 0.0).collect(),
    };
    let position = vectors(&grains.position)?.to_vec();
    let velocity = vectors(&grains.velocity)?.to_vec();
    let state = State::new(&properties, position, velocity)?;
    ContactEngine::new(setup, properties, state)
}

/// How the scene has contacts solved.
fn solver(wished: ContactSolver) -> Solver {
    match wished {
        ContactSolver::SmallSteps => Solver::SmallSteps,
        ContactSolver::Converged => Solver::Converged,
    }
}

/// A wall of the scene: as many corners as dimensions.
fn facet<const D: usize>(wall: &Wall) -> Result<Facet<D>, String> {
    let corners = wall.corners.iter();
    let corners: Result<Vec<[f64; D]>, String> = corners.map(|corner| fixed(corner)).collect();
    let corners = fixed::<D, [f64; D]>(&corners?)?;
    let velocity = match &wall.velocity {
        Some(velocity) => fixed(velocity)?,
        None => [0.0; D],
    };
    Ok(Facet {
        corners: corners.map(Vector::from),
        velocity: velocity.into(),
    })
}

/// Vectors from interleaved components.
fn vectors<const D: usize>(interleaved: &[f64]) -> Result<&[Vector<D>], Error> {
    flat::vectors(interleaved).ok_or_else(|| {
        Error::Setup(format!(
            "{} components of vectors, not {D} of each",
            interleaved.len()
        ))
    })
}

/// The grains as they are now.
fn present<const D: usize>(solver: &ContactEngine<D>, volume: &[f64]) -> InitialGrains
where
    Dim<D>: Dimension<D>,
{
    let (grains, state) = (solver.grains(), solver.accepted());
    InitialGrains {
        dimension: D,
        position: flat::numbers(&state.position).to_vec(),
        velocity: flat::numbers(&state.velocity).to_vec(),
        radius: grains.radius.clone(),
        mass: grains.mass.clone(),
        volume: volume.to_vec(),
        fixed: grains.fixed.iter().map(|&fixed| fixed.into()).collect(),
    }
}

/// Write a candidate into the coupler's buffers.
fn write<const D: usize>(candidate: &Candidate<D>, mut outputs: Outputs<'_>) -> Result<(), Failure>
where
    Dim<D>: Dimension<D>,
{
    let vectors = [
        (
            Field::GrainPosition,
            flat::numbers(&candidate.state.position),
        ),
        (
            Field::GrainVelocity,
            flat::numbers(&candidate.state.velocity),
        ),
        (
            Field::GrainMeanVelocity,
            flat::numbers(&candidate.mean_velocity),
        ),
    ];
    for (field, source) in vectors {
        let target = outputs.take(field);
        if target.len() != source.len() {
            let why = format!(
                "room for {} numbers, {} to write",
                target.len(),
                source.len()
            );
            return Err(Failure::new(FailureKind::Engine, why));
        }
        target.copy_from_slice(source);
    }
    let spin = outputs.take(Field::GrainSpin);
    let components = <Spin<D>>::COMPONENTS;
    for (target, source) in spin.chunks_exact_mut(components).zip(&candidate.state.spin) {
        (0..components).for_each(|k| target[k] = source.component(k));
    }
    let contact = outputs.take(Field::GrainContact);
    for (target, source) in contact.iter_mut().zip(&candidate.contact) {
        *target = f64::from(*source);
    }
    Ok(())
}

/// What the coupler goes by, and numbers for people.
fn told<const D: usize>(
    candidate: &Candidate<D>,
) -> Result<(ParticleReport, Vec<Diagnostic>), Failure>
where
    Dim<D>: Dimension<D>,
{
    let report = &candidate.report;
    let typed = ParticleReport::new(report.sub_steps)
        .ok_or_else(|| Failure::new(FailureKind::Engine, "a candidate of no sub-step"))?;
    let typed = ParticleReport {
        touching: Some(report.contacts as u64),
        ..typed
    };
    let mut numbers = vec![
        named("contact_candidates", report.candidates as f64),
        named("contact_sweeps", report.sweeps as f64),
        named("contact_attempts", report.attempts as f64),
        named("penetration_max", report.penetration_max),
        named("kinetic_energy", report.kinetic_energy),
    ];
    match report.sinking {
        Some(sinking) => numbers.push(named("contact_sinking", sinking)),
        None => numbers.extend([
            named("contact_sinking", 0.0),
            named("contact_residual", report.residual.rms),
            named("contact_residual_max", report.residual.max),
        ]),
    }
    Ok((typed, numbers))
}

fn named(name: &str, value: f64) -> Diagnostic {
    Diagnostic {
        name: name.to_owned(),
        value,
    }
}
