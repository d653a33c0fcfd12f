//! A whole run: connect the engines, step to the end, report to the orchestrator.

use std::path::PathBuf;
use std::time::Instant;

use protocol::engine::InitialGrains;
use protocol::error::Error;
use protocol::ipc::coupler_link;
use protocol::message::{FailureKind, Role};
use protocol::partner::Partner;
use protocol::runspace::RunSpace;
use protocol::scene::CouplerScene;
use space::{Dim, Dimension};

use crate::checkpoint::Kept;
use crate::checkpoints::{Checkpoints, Moment, Rule};
use crate::clock::Clock;
use crate::cost::{Meter, Totals};
use crate::error::CouplerError;
use crate::listener::Listener;
use crate::observe;
use crate::record::{Recording, Target};
use crate::report::StepReport;
use crate::simulation::Simulation;

/// What a run takes beside its scene, and what it leaves.
#[derive(Debug, Clone, Default)]
pub struct Files {
    /// Record what passes between the processes.
    pub record: Option<Target>,
    /// Keep the state of the run.
    pub checkpoints: Option<Rule>,
    /// Go on from the checkpoint in this folder.
    pub resume: Option<PathBuf>,
    /// Record a run that goes on from its checkpoint, not what came before.
    pub record_anew: bool,
}

/// Connect to the engines of this run, and to the orchestrator if there is one, and run the scene from its
/// start or from a checkpoint.
pub fn run<const D: usize, const N: usize>(
    scene: CouplerScene,
    grains: &InitialGrains,
    runspace: &RunSpace,
    files: &Files,
) -> Result<(), CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let mut listener = Listener::connect(runspace)?;
    let mut course = Course {
        totals: Totals::default(),
        recording: Recording::default(),
        checkpoints: Checkpoints::new(files.checkpoints.clone(), None),
    };
    let mut simulation: Option<Simulation<D, N>> = None;
    let result = course
        .begin(scene, grains, runspace, files)
        .and_then(|(begun, clock, radius)| {
            let simulation = simulation.insert(begun);
            let (course, listener) = (&mut course, &mut listener);
            listener.started(simulation, &radius)?;
            if files.resume.is_none() {
                listener.snapshot(simulation)?;
            }
            course.checkpoints.require_engines(simulation, listener)?;
            course.step_to_the_end(simulation, clock, listener)
        });
    let Course {
        mut totals,
        mut recording,
        ..
    } = course;
    let exit = result.as_ref().map_or_else(CouplerError::exit_code, |()| 0);
    recording.finish(exit, &mut listener, &mut totals.named)?;
    // The orchestrator hears how it ended before the engines leave: processes that end on their own
    // are a sign of trouble to it.
    listener.ended(result.as_ref().err(), totals.named)?;
    match &mut simulation {
        Some(simulation) if !engine_lost(&result) => result.and(simulation.finish()),
        _ => result,
    }
}

fn engine_lost(result: &Result<(), CouplerError>) -> bool {
    matches!(
        result,
        Err(CouplerError::Protocol(
            Error::PartnerLost { .. } | Error::TimeLimit { .. }
        ))
    )
}

fn connect<const D: usize, const N: usize>(
    scene: CouplerScene,
    grains: &InitialGrains,
    runspace: &RunSpace,
    recording: &Recording,
) -> Result<Simulation<D, N>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let seat = |role: Role| -> Result<Option<Partner>, CouplerError> {
        Ok(if scene.has_process(role) {
            let link = recording.tap(role, coupler_link(runspace, role)?);
            Some(Partner::greet(role, link, &scene.limits)?)
        } else {
            None
        })
    };
    let fluid = seat(Role::Fluid)?;
    let particles = seat(Role::Particles)?;
    Simulation::new(scene, fluid, particles, grains)
}

/// What goes along with the steps of a run.
struct Course {
    totals: Totals,
    recording: Recording,
    checkpoints: Checkpoints,
}

/// A simulation at its first step, its clock, and the radii of the grains that it began with \[m\].
type Begun<const D: usize, const N: usize> = (Simulation<D, N>, Clock, Vec<f64>);

impl Course {
    /// Connect, and bring all to where the run begins or goes on.
    fn begin<const D: usize, const N: usize>(
        &mut self,
        scene: CouplerScene,
        grains: &InitialGrains,
        runspace: &RunSpace,
        files: &Files,
    ) -> Result<Begun<D, N>, CouplerError>
    where
        Dim<D>: Dimension<D>,
    {
        let resume = files.resume.as_deref();
        let kept = resume.map(|folder| Kept::<D>::read(folder, &scene));
        let kept = kept.transpose()?;
        let mut clock = Clock::new(&scene);
        let before = kept.as_ref().filter(|_| !files.record_anew);
        let recorded = before.map(|kept| kept.recorded);
        self.recording = Recording::begin(files.record.as_ref(), &scene, recorded)?;
        // What brings a run back to where it was is no part of it.
        self.recording.pause(before.is_some());
        let mut simulation = connect(scene, grains, runspace, &self.recording)?;
        let radius = simulation.state.grains.radius.clone();
        if let (Some(kept), Some(folder)) = (kept, resume) {
            clock.remember(kept.clock);
            self.totals.named.clone_from(&kept.totals);
            kept.restore(folder, &mut simulation)?;
            let step = simulation.state.step;
            self.checkpoints = Checkpoints::new(files.checkpoints.clone(), Some(step));
            self.recording.pause(false);
        }
        Ok((simulation, clock, radius))
    }

    /// Steps until the scene's end, with a report of each. When asked to stop it does so after a step,
    /// and its last state is put out. What a run that fails was in before its last step is kept.
    fn step_to_the_end<const D: usize, const N: usize>(
        &mut self,
        simulation: &mut Simulation<D, N>,
        mut clock: Clock,
        listener: &mut Listener,
    ) -> Result<(), CouplerError>
    where
        Dim<D>: Dimension<D>,
    {
        while !clock.is_over(simulation.state.time) {
            let mut before = self.moment(&clock);
            if let Err(error) = self.step(simulation, &mut clock, &mut before, listener) {
                if simulation.is_settled() && !is_of_the_link(&error) {
                    self.keep(simulation, before, listener)?;
                }
                return Err(error);
            }
            let stop = listener.stop_requested();
            let time = simulation.state.time;
            let (put_out, over) = (clock.output_due(time), clock.is_over(time));
            if put_out {
                listener.snapshot(simulation)?;
            }
            if stop || over || self.checkpoints.due(simulation.state.step) {
                self.keep(simulation, self.moment(&clock), listener)?;
            }
            if stop && !over {
                // After the checkpoint: a run that goes on has no such state.
                if !put_out {
                    listener.snapshot(simulation)?;
                }
                let step = simulation.state.step;
                return Err(CouplerError::Interrupted { step });
            }
        }
        Ok(())
    }

    fn step<const D: usize, const N: usize>(
        &mut self,
        simulation: &mut Simulation<D, N>,
        clock: &mut Clock,
        before: &mut Moment,
        listener: &mut Listener,
    ) -> Result<(), CouplerError>
    where
        Dim<D>: Dimension<D>,
    {
        let meter = Meter::start(&simulation.system);
        if simulation.follow()? {
            // A step that fails begins on this mesh.
            before.recorded = self.recording.passed();
            self.totals.add_mesh(meter.elapsed());
        }
        let speed = observe::speed_max(&simulation.state.grains.velocity)
            .max(observe::speed_max(&simulation.state.flow.velocity));
        let fluid = simulation.system.fluid();
        let cell = fluid.map_or(f64::INFINITY, |seat| seat.smallest_cell);
        let dt = clock.next_step(simulation.state.time, speed, cell);
        let report = step_with_retries(simulation, clock, listener, dt)?;
        let cost = meter.stop(&simulation.system);
        self.totals.add(&report, &cost);
        if let Some(seat) = simulation.system.fluid() {
            self.totals.add_mesh_changes(&seat.diagnostics);
        }
        listener.step(observe::columns(simulation, &report, &cost))?;
        self.recording.look(listener)
    }

    fn moment(&self, clock: &Clock) -> Moment {
        Moment {
            clock: clock.memory(),
            recorded: self.recording.passed(),
        }
    }

    fn keep<const D: usize, const N: usize>(
        &mut self,
        simulation: &mut Simulation<D, N>,
        moment: Moment,
        listener: &mut Listener,
    ) -> Result<(), CouplerError>
    where
        Dim<D>: Dimension<D>,
    {
        let begun = Instant::now();
        let (totals, recording) = (&self.totals.named, &self.recording);
        let kept = self
            .checkpoints
            .keep(simulation, moment, totals, recording, listener)?;
        if kept {
            self.totals.add_checkpoint(begun.elapsed().as_secs_f64());
        }
        Ok(())
    }
}

/// Is somebody gone or silent, so that not all can be asked for their state?
fn is_of_the_link(error: &CouplerError) -> bool {
    match error {
        CouplerError::Protocol(Error::Engine { .. }) => false,
        error => matches!(error, CouplerError::Protocol(_)),
    }
}

/// One step; a step that fails is tried again with half its length, as far as the clock allows and until a
/// stop is asked for: the last accepted step is then the last one. Its state is not put out, engines that
/// have begun another step cannot tell it.
fn step_with_retries<const D: usize, const N: usize>(
    simulation: &mut Simulation<D, N>,
    clock: &mut Clock,
    listener: &mut Listener,
    dt: f64,
) -> Result<StepReport, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let (mut dt, mut failed) = (dt, 0);
    loop {
        let error = match simulation.advance(dt) {
            Ok(report) => return Ok(StepReport { failed, ..report }),
            Err(error) if may_be_halved(&error) => error,
            Err(error) => return Err(error),
        };
        failed += 1;
        let step = simulation.state.step + 1;
        let Some(smaller) = clock.retry(dt) else {
            return Err(no_smaller(error, step, 0.5 * dt, clock.step_min()));
        };
        tracing::warn!(step, dt, smaller, %error, "step halved");
        if listener.stop_requested() {
            let step = simulation.state.step;
            return Err(CouplerError::Interrupted { step });
        }
        dt = smaller;
    }
}

/// Exit code of what is not finite, or breaks an invariant.
const BROKEN: i32 = 7;

/// A broken invariant stays one (exit 7); what does not converge ends the run as that (exit 8).
fn no_smaller(error: CouplerError, step: u64, dt: f64, step_min: f64) -> CouplerError {
    match error {
        error if error.exit_code() == BROKEN => error,
        error => CouplerError::StepTooSmall {
            step,
            dt,
            step_min,
            why: error.to_string(),
        },
    }
}

fn may_be_halved(error: &CouplerError) -> bool {
    match error {
        CouplerError::NotConverged { .. }
        | CouplerError::Porosity { .. }
        | CouplerError::GrainOutside { .. }
        | CouplerError::NotFinite { .. }
        | CouplerError::Unbalanced { .. }
        | CouplerError::Protocol(Error::NotFinite { .. }) => true,
        CouplerError::Protocol(Error::Engine { failure, .. }) => matches!(
            failure.kind,
            FailureKind::NotConverged | FailureKind::NotFinite
        ),
        _ => false,
    }
}
