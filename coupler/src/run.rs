//! A whole run: connect the engines, step to the end, report to the orchestrator.

use protocol::engine::InitialGrains;
use protocol::error::Error;
use protocol::ipc::coupler_link;
use protocol::message::{FailureKind, Role};
use protocol::partner::Partner;
use protocol::runspace::RunSpace;
use protocol::scene::CouplerScene;
use space::{Dim, Dimension};

use crate::clock::Clock;
use crate::cost::{Meter, Totals};
use crate::error::CouplerError;
use crate::listener::Listener;
use crate::observe;
use crate::record::{Recording, Target};
use crate::report::StepReport;
use crate::simulation::Simulation;

/// Connect to the engines of this run, and to the orchestrator if there is one, and run the scene;
/// what passes between them is recorded when that is asked for.
pub fn run<const D: usize, const N: usize>(
    scene: CouplerScene,
    grains: &InitialGrains,
    runspace: &RunSpace,
    record: Option<&Target>,
) -> Result<(), CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let mut listener = Listener::connect(runspace)?;
    let mut totals = Totals::default();
    let mut simulation = None;
    let mut recording = Recording::default();
    let result = Recording::begin(record, &scene)
        .map_err(CouplerError::from)
        .and_then(|begun| {
            recording = begun;
            connect::<D, N>(scene, grains, runspace, &recording)
        })
        .and_then(|connected| {
            let simulation = simulation.insert(connected);
            step_to_the_end(simulation, &mut listener, &mut totals, &mut recording)
        });
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

/// Steps until the scene's end, with a report of each. When asked to stop it does so after a step,
/// and its last state is put out.
fn step_to_the_end<const D: usize, const N: usize>(
    simulation: &mut Simulation<D, N>,
    listener: &mut Listener,
    totals: &mut Totals,
    recording: &mut Recording,
) -> Result<(), CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let mut clock = Clock::new(&simulation.scene);
    let fluid = simulation.system.fluid();
    let cell = fluid.map_or(f64::INFINITY, |seat| seat.mesh.smallest_cell());
    listener.started(simulation)?;
    while !clock.is_over(simulation.state.time) {
        let speed = observe::speed_max(&simulation.state.grains.velocity)
            .max(observe::speed_max(&simulation.state.flow.velocity));
        let dt = clock.next_step(simulation.state.time, speed, cell);
        let meter = Meter::start(&simulation.system);
        let report = step_with_retries(simulation, &mut clock, listener, dt)?;
        let cost = meter.stop(&simulation.system);
        totals.add(&report, &cost);
        listener.step(observe::columns(simulation, &report, &cost))?;
        recording.look(listener)?;
        let stop = listener.stop_requested();
        let time = simulation.state.time;
        if clock.output_due(time) || stop {
            listener.snapshot(simulation)?;
        }
        if stop && !clock.is_over(time) {
            let step = simulation.state.step;
            return Err(CouplerError::Interrupted { step });
        }
    }
    Ok(())
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
    let mut dt = dt;
    loop {
        let error = match simulation.advance(dt) {
            Err(error) if may_be_halved(&error) => error,
            other => return other,
        };
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

/// A broken invariant stays one (exit 7); what does not converge ends the run as that (exit 8).
fn no_smaller(error: CouplerError, step: u64, dt: f64, step_min: f64) -> CouplerError {
    match error {
        CouplerError::Porosity { .. } | CouplerError::GrainOutside { .. } => error,
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
        | CouplerError::GrainOutside { .. } => true,
        CouplerError::Protocol(Error::Engine { failure, .. }) => {
            failure.kind == FailureKind::NotConverged
        }
        _ => false,
    }
}
