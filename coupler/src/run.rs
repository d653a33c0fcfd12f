//! A whole run: connect the engines, step to the end, report to the orchestrator.

use std::time::Instant;

use protocol::configure::CouplerScene;
use protocol::engine::InitialGrains;
use protocol::error::Error;
use protocol::field::Field;
use protocol::ipc::coupler_link;
use protocol::messages::{Diagnostic, FailureKind, Role};
use protocol::monitor::MonitorSender;
use protocol::partner::Partner;
use protocol::process::cpu_seconds;
use protocol::runspace::RunSpace;

use crate::clock::Clock;
use crate::coupling::{self, Coupling, StepReport};
use crate::engines::{ParticleSeat, value};
use crate::error::CouplerError;
use crate::observe::{self, StepCost};
use crate::record::{self, Recording};

/// Connect to the engines of this run, and to the orchestrator if there is one, and run the scene;
/// what passes between them is recorded when that is asked for.
pub fn run(
    scene: CouplerScene,
    grains: &InitialGrains,
    runspace: &RunSpace,
    record: Option<&record::Request>,
) -> Result<(), CouplerError> {
    let mut monitor = MonitorSender::connect(runspace)?;
    let mut totals = Totals::default();
    let mut coupling = None;
    let mut recording = Recording::default();
    let result = Recording::begin(record, &scene)
        .map_err(CouplerError::from)
        .and_then(|begun| {
            recording = begun;
            connect(scene, grains, runspace, &recording)
        })
        .and_then(|connected| {
            let connected = coupling.insert(connected);
            step_to_the_end(connected, &mut monitor, &mut totals, &mut recording)
        });
    let exit = result.as_ref().map_or_else(CouplerError::exit_code, |()| 0);
    recording.finish(exit, &mut monitor, &mut totals.named)?;
    // The orchestrator hears how it ended before the engines leave: processes that end on their own
    // are a sign of trouble to it.
    match (&result, &mut monitor) {
        (Ok(()), Some(monitor)) => monitor.finished(totals.named)?,
        (Err(error), Some(monitor)) => {
            monitor.stopped(error.exit_code(), &error.to_string(), totals.named)?;
        }
        (_, None) => {}
    }
    let engine_lost = matches!(
        result,
        Err(CouplerError::Protocol(
            Error::PartnerLost { .. } | Error::TimeLimit { .. }
        ))
    );
    match &mut coupling {
        Some(coupling) if !engine_lost => result.and(finish(coupling)),
        _ => result,
    }
}

fn connect(
    scene: CouplerScene,
    grains: &InitialGrains,
    runspace: &RunSpace,
    recording: &Recording,
) -> Result<Coupling, CouplerError> {
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
    Coupling::new(scene, fluid, particles, grains)
}

fn finish(coupling: &mut Coupling) -> Result<(), CouplerError> {
    if let Some(seat) = &mut coupling.fluid {
        seat.partner().finish()?;
    }
    if let Some(partner) = coupling.particles.as_mut().and_then(ParticleSeat::partner) {
        partner.finish()?;
    }
    Ok(())
}

/// Steps until the scene's end, with a report of each. When asked to stop it does so after a step,
/// and its last state is put out.
fn step_to_the_end(
    coupling: &mut Coupling,
    monitor: &mut Option<MonitorSender>,
    totals: &mut Totals,
    recording: &mut Recording,
) -> Result<(), CouplerError> {
    let mut clock = Clock::new(coupling.scene());
    let cell = coupling
        .fluid
        .as_ref()
        .map_or(f64::INFINITY, coupling::smallest_cell);
    announce(coupling, monitor)?;
    while !clock.is_over(coupling.time) {
        let speed = observe::speed_max(&coupling.grains.velocity)
            .max(observe::speed_max(&coupling.fluid_state.velocity));
        let dt = clock.next_step(coupling.time, speed, cell);
        let begin = Meter::start(coupling);
        let report = step_with_retries(coupling, &mut clock, dt)?;
        let cost = begin.stop(coupling);
        totals.add(coupling, &report, &cost);
        let columns = observe::columns(coupling, &report, &cost);
        match monitor {
            Some(monitor) => monitor.step(columns)?,
            None => print_line(&columns),
        }
        recording.look(monitor)?;
        let stop = monitor.as_mut().is_some_and(MonitorSender::stop_requested);
        if clock.output_due(coupling.time) || stop {
            snapshot(coupling, monitor)?;
        }
        if stop && !clock.is_over(coupling.time) {
            return Err(CouplerError::Interrupted {
                step: coupling.step,
            });
        }
    }
    Ok(())
}

/// One step; a step that fails is tried again with half its length, as far as the clock allows.
fn step_with_retries(
    coupling: &mut Coupling,
    clock: &mut Clock,
    dt: f64,
) -> Result<StepReport, CouplerError> {
    let mut dt = dt;
    loop {
        let error = match coupling.advance(dt) {
            Err(error) if may_be_halved(&error) => error,
            other => return other,
        };
        let step = coupling.step + 1;
        let Some(smaller) = clock.retry(dt) else {
            return Err(no_smaller(error, step, 0.5 * dt, clock.step_min()));
        };
        tracing::warn!(step, dt, smaller, %error, "step halved");
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

fn announce(
    coupling: &mut Coupling,
    monitor: &mut Option<MonitorSender>,
) -> Result<(), CouplerError> {
    let Some(sender) = monitor else { return Ok(()) };
    let hellos = coupling.hellos();
    let mesh = coupling.fluid.as_ref().map(|seat| &seat.mesh);
    sender.started(&hellos, mesh, &coupling.grains.radius)?;
    snapshot(coupling, monitor)
}

/// The state as it is put out, with what is read only here.
fn snapshot(
    coupling: &mut Coupling,
    monitor: &mut Option<MonitorSender>,
) -> Result<(), CouplerError> {
    let Some(monitor) = monitor else {
        return Ok(());
    };
    coupling.contact_states()?;
    let mut fields: Vec<(Field, &[f64])> = Vec::new();
    if let Some(seat) = &mut coupling.fluid {
        fields.push((Field::InterstitialVelocity, &coupling.fluid_state.velocity));
        fields.push((Field::Pressure, seat.pressure()?));
        fields.push((Field::Porosity, &coupling.porosity));
    }
    if coupling.particles.is_some() {
        fields.push((Field::GrainPosition, &coupling.grains.position));
        fields.push((Field::GrainVelocity, &coupling.grains.velocity));
        fields.push((Field::GrainContact, &coupling.grains.contact));
    }
    Ok(monitor.snapshot(coupling.step, coupling.time, &fields)?)
}

/// Without an orchestrator the run is followed on standard output: one JSON object a step.
fn print_line(columns: &[Diagnostic]) {
    let object: serde_json::Map<String, serde_json::Value> = columns
        .iter()
        .map(|column| (column.name.clone(), column.value.into()))
        .collect();
    println!("{}", serde_json::Value::Object(object));
}

/// Measures one step.
struct Meter {
    begin: Instant,
    cpu: f64,
    waited: f64,
}

impl Meter {
    fn start(coupling: &Coupling) -> Meter {
        Meter {
            begin: Instant::now(),
            cpu: cpu_seconds(),
            waited: waited(coupling),
        }
    }

    /// Engines count from the last accepted step on: passes and failed attempts are in it.
    fn stop(&self, coupling: &Coupling) -> StepCost {
        let of = |diagnostics: Option<&Vec<Diagnostic>>, name: &str| {
            diagnostics
                .and_then(|list| value(list, name))
                .unwrap_or(0.0)
        };
        let fluid = coupling.fluid.as_ref().map(|seat| &seat.diagnostics);
        let particles = coupling.particles.as_ref().map(|seat| &seat.diagnostics);
        let (wall, waited) = (
            self.begin.elapsed().as_secs_f64(),
            waited(coupling) - self.waited,
        );
        let (wall_fluid, wall_particles) = (of(fluid, WALL), of(particles, WALL));
        StepCost {
            wall,
            cpu_fluid: of(fluid, "cpu_seconds"),
            cpu_particles: of(particles, "cpu_seconds"),
            cpu_coupler: cpu_seconds() - self.cpu,
            wall_fluid,
            wall_particles,
            wall_exchange: waited - wall_fluid - wall_particles,
            wall_coupler: wall - waited,
        }
    }
}

const WALL: &str = "wall_seconds";

/// Wall time waited for the engines so far \[s\].
fn waited(coupling: &Coupling) -> f64 {
    coupling.fluid.as_ref().map_or(0.0, |seat| seat.wall)
        + coupling.particles.as_ref().map_or(0.0, |seat| seat.wall)
}

/// Sums and worst values over a run.
#[derive(Default)]
struct Totals {
    named: Vec<Diagnostic>,
}

impl Totals {
    fn sum(&mut self, name: &str, amount: f64) {
        self.update(name, amount, |old, new| old + new);
    }

    fn worst(&mut self, name: &str, amount: f64) {
        self.update(name, amount, f64::max);
    }

    fn update(&mut self, name: &str, amount: f64, combine: impl Fn(f64, f64) -> f64) {
        match self.named.iter_mut().find(|total| total.name == name) {
            Some(total) => total.value = combine(total.value, amount),
            None => self.named.push(Diagnostic {
                name: name.to_owned(),
                value: amount,
            }),
        }
    }

    fn add(&mut self, coupling: &Coupling, report: &StepReport, cost: &StepCost) {
        self.sum("steps", 1.0);
        self.sum("passes", f64::from(report.passes));
        self.sum("seconds_wall", cost.wall);
        self.sum("cpu_fluid", cost.cpu_fluid);
        self.sum("cpu_particles", cost.cpu_particles);
        self.sum("cpu_coupler", cost.cpu_coupler);
        self.sum("wall_fluid", cost.wall_fluid);
        self.sum("wall_particles", cost.wall_particles);
        self.sum("wall_exchange", cost.wall_exchange);
        self.sum("wall_coupler", cost.wall_coupler);
        let share = (self.get("wall_exchange") + self.get("wall_coupler"))
            / self.get("seconds_wall").max(f64::MIN_POSITIVE);
        self.update("coupling_share", share, |_, new| new);
        let seats = [
            (
                "fluid",
                coupling.fluid.as_ref().map(|seat| &seat.diagnostics),
            ),
            (
                "particles",
                coupling.particles.as_ref().map(|seat| &seat.diagnostics),
            ),
        ];
        for (seat, diagnostics) in seats {
            for diagnostic in diagnostics
                .into_iter()
                .flatten()
                .filter(|d| d.name.starts_with("seconds_"))
            {
                self.sum(&format!("{seat}_{}", diagnostic.name), diagnostic.value);
            }
        }
        self.worst("volume_defect_max", report.budget.volume_defect);
        self.worst("momentum_defect_max", report.budget.momentum_defect);
        self.worst("third_law_defect_max", report.budget.third_law_defect);
        self.worst("interaction_defect_max", report.interaction_defect);
        self.worst("energy_defect_max", report.budget.energy_defect);
        self.worst("transfer_loss_max", report.budget.transfer_loss.abs());
        self.worst("passes_max", f64::from(report.passes));
    }

    fn get(&self, name: &str) -> f64 {
        value(&self.named, name).unwrap_or(0.0)
    }
}
