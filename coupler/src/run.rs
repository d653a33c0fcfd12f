//! A whole run: connect the engines, step to the end, report to the orchestrator.

use std::time::Instant;

use protocol::configure::CouplerScene;
use protocol::engine::InitialGrains;
use protocol::error::Error;
use protocol::field::Field;
use protocol::messages::{Diagnostic, FailureKind, Role};
use protocol::monitor::MonitorSender;
use protocol::partner::Partner;
use protocol::runspace::RunSpace;

use crate::clock::Clock;
use crate::coupling::{self, Coupling, StepReport};
use crate::engines::value;
use crate::error::CouplerError;
use crate::observe::{self, StepCost};

/// Connect to the engines of this run, and to the orchestrator if there is one, and run the scene.
pub fn run(
    scene: CouplerScene,
    grains: &InitialGrains,
    runspace: &RunSpace,
) -> Result<(), CouplerError> {
    let mut monitor = MonitorSender::connect(runspace)?;
    let result = connect(scene, grains, runspace).and_then(|mut coupling| {
        let result = step_to_the_end(&mut coupling, monitor.as_mut());
        if !matches!(
            result,
            Err(CouplerError::Protocol(
                Error::PartnerLost { .. } | Error::TimeLimit { .. }
            ))
        ) {
            finish(&mut coupling)?;
        }
        result
    });
    if let (Err(error), Some(monitor)) = (&result, &mut monitor) {
        monitor.stopped(error.exit_code(), &error.to_string())?;
    }
    result
}

fn connect(
    scene: CouplerScene,
    grains: &InitialGrains,
    runspace: &RunSpace,
) -> Result<Coupling, CouplerError> {
    let seat = |needed: bool, role: Role| -> Result<Option<Partner>, CouplerError> {
        Ok(if needed {
            Some(Partner::accept(role, runspace, &scene.limits)?)
        } else {
            None
        })
    };
    let fluid = seat(scene.fluid.is_some(), Role::Fluid)?;
    let particles = seat(scene.particles.is_some(), Role::Particles)?;
    Coupling::new(scene, fluid, particles, grains)
}

fn finish(coupling: &mut Coupling) -> Result<(), CouplerError> {
    if let Some(seat) = &mut coupling.fluid {
        seat.partner().finish()?;
    }
    if let Some(seat) = &mut coupling.particles {
        seat.partner().finish()?;
    }
    Ok(())
}

/// Steps until the scene's end, with a report of each.
pub fn step_to_the_end(
    coupling: &mut Coupling,
    mut monitor: Option<&mut MonitorSender>,
) -> Result<(), CouplerError> {
    let mut clock = Clock::new(&coupling.scene);
    let mut totals = Totals::default();
    let cell = coupling
        .fluid
        .as_ref()
        .map_or(f64::INFINITY, coupling::smallest_cell);
    announce(coupling, &mut monitor)?;
    while !clock.is_over(coupling.time) {
        let speed = observe::speed_max(&coupling.grains.velocity)
            .max(observe::speed_max(&coupling.fluid_state.velocity));
        let dt = clock.next_step(coupling.time, speed, cell);
        let begin = Meter::start(coupling);
        let report = step_with_retries(coupling, &mut clock, dt)?;
        let cost = begin.stop(coupling);
        totals.add(coupling, &report, &cost);
        let columns = observe::columns(coupling, &report, &cost);
        match &mut monitor {
            Some(monitor) => monitor.step(columns)?,
            None => print_line(&columns),
        }
        if clock.output_due(coupling.time) {
            snapshot(coupling, &mut monitor)?;
        }
        if monitor
            .as_mut()
            .is_some_and(|monitor| monitor.stop_requested())
        {
            return Err(CouplerError::Interrupted {
                step: coupling.step,
            });
        }
    }
    match monitor {
        Some(monitor) => Ok(monitor.finished(totals.diagnostics())?),
        None => Ok(()),
    }
}

/// One step; where the scene allows it, a step that does not converge is halved.
fn step_with_retries(
    coupling: &mut Coupling,
    clock: &mut Clock,
    dt: f64,
) -> Result<StepReport, CouplerError> {
    let mut dt = dt;
    loop {
        match coupling.advance(dt) {
            Err(error) if may_be_halved(&error) => match clock.retry(dt) {
                Some(smaller) => {
                    tracing::warn!(step = coupling.step + 1, dt, smaller, %error, "step halved");
                    dt = smaller;
                }
                None if clock.step_min() < dt => {
                    let step_min = clock.step_min();
                    return Err(CouplerError::StepTooSmall {
                        step: coupling.step + 1,
                        dt: 0.5 * dt,
                        step_min,
                        why: error.to_string(),
                    });
                }
                None => return Err(error),
            },
            other => return other,
        }
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
    coupling: &Coupling,
    monitor: &mut Option<&mut MonitorSender>,
) -> Result<(), CouplerError> {
    let Some(sender) = monitor else { return Ok(()) };
    let hellos = coupling.hellos();
    let mesh = coupling.fluid.as_ref().map(|seat| &seat.mesh);
    sender.started(&hellos, mesh, &coupling.grains.radius)?;
    snapshot(coupling, monitor)
}

fn snapshot(
    coupling: &Coupling,
    monitor: &mut Option<&mut MonitorSender>,
) -> Result<(), CouplerError> {
    let Some(monitor) = monitor else {
        return Ok(());
    };
    let mut fields: Vec<(Field, &[f64])> = Vec::new();
    if let Some(seat) = &coupling.fluid {
        fields.push((Field::InterstitialVelocity, &coupling.fluid_state.velocity));
        fields.push((Field::Pressure, &seat.pressure));
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
}

impl Meter {
    fn start(_: &Coupling) -> Meter {
        Meter {
            begin: Instant::now(),
            cpu: cpu_seconds(),
        }
    }

    fn stop(&self, coupling: &Coupling) -> StepCost {
        let engine = |diagnostics: Option<&Vec<Diagnostic>>| {
            diagnostics
                .and_then(|list| value(list, "cpu_seconds"))
                .unwrap_or(0.0)
        };
        StepCost {
            wall: self.begin.elapsed().as_secs_f64(),
            cpu_fluid: engine(coupling.fluid.as_ref().map(|seat| &seat.diagnostics)),
            cpu_particles: engine(coupling.particles.as_ref().map(|seat| &seat.diagnostics)),
            cpu_coupler: cpu_seconds() - self.cpu,
        }
    }
}

/// CPU time of this process so far \[s\].
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
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
        self.worst("passes_max", f64::from(report.passes));
    }

    fn diagnostics(self) -> Vec<Diagnostic> {
        self.named
    }
}
