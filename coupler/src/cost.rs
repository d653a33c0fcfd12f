//! What steps cost, and sums and worst values over a run.

use std::time::Instant;

use protocol::message::Diagnostic;
use protocol::process::cpu_seconds;
use space::{Dim, Dimension};

use crate::report::StepReport;
use crate::seats::request::value;
use crate::system::System;

/// Diagnostic of both engines: wall time inside the engine since the last accepted step.
const WALL: &str = "wall_seconds";
/// The same of CPU time.
const CPU: &str = "cpu_seconds";
/// Diagnostics of the fluid engine: parts of that.
const PHASE: &str = "seconds_";
/// The same in `steps.csv` and in the totals.
const PHASE_OF_FLUID: &str = "cpu_fluid_";
const TOTAL_OF_PHASE: &str = "fluid_seconds_";
/// Diagnostics of the fluid engine: what a new mesh has done to volume, momentum and energy, and how much of
/// what there was that is.
const OF_MESH: &str = "mesh_";
const SHARE: &str = "_share";

/// Times of one step \[s\].
#[derive(Debug, Clone, Default)]
pub struct StepCost {
    /// Wall time of the step.
    pub wall_step: f64,
    /// CPU time of the fluid engine.
    pub cpu_fluid: f64,
    /// What of it the fluid engine tells apart, and the rest.
    pub phases: Vec<(String, f64)>,
    /// CPU time of the particle engine.
    pub cpu_particles: f64,
    /// CPU time of the coupler.
    pub cpu_coupler: f64,
    /// Wall time inside the fluid engine (S2).
    pub wall_fluid: f64,
    /// Wall time inside the particle engine (S4, S5).
    pub wall_particles: f64,
    /// Wall time waited for the engines beyond that: the exchange.
    pub wall_exchange: f64,
    /// Wall time of the coupler itself (S1, S3, S6).
    pub wall_coupler: f64,
}

impl StepCost {
    /// Name and value of each, in the order of `steps.csv`.
    pub fn columns(&self) -> Vec<(String, f64)> {
        let phases = self.phases.iter();
        let phases = phases.map(|(phase, seconds)| (format!("{PHASE_OF_FLUID}{phase}"), *seconds));
        let named = |(name, seconds): (&str, f64)| (name.to_owned(), seconds);
        let whole = [("wall_step", self.wall_step), ("cpu_fluid", self.cpu_fluid)];
        let others = [
            ("cpu_particles", self.cpu_particles),
            ("cpu_coupler", self.cpu_coupler),
            ("wall_fluid", self.wall_fluid),
            ("wall_particles", self.wall_particles),
            ("wall_exchange", self.wall_exchange),
            ("wall_coupler", self.wall_coupler),
        ];
        let whole = whole.into_iter().map(named);
        whole.chain(phases).chain(others.map(named)).collect()
    }
}

/// Measures one step.
pub struct Meter {
    begin: Instant,
    cpu: f64,
    waited: f64,
}

impl Meter {
    /// The step begins.
    pub fn start<const D: usize, const N: usize>(system: &System<D, N>) -> Meter
    where
        Dim<D>: Dimension<D>,
    {
        Meter {
            begin: Instant::now(),
            cpu: cpu_seconds(),
            waited: waited(system),
        }
    }

    /// Wall time since then \[s\].
    pub fn elapsed(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    /// The step is accepted. Engines count from the last accepted step on: passes and failed attempts
    /// are in it.
    pub fn stop<const D: usize, const N: usize>(&self, system: &System<D, N>) -> StepCost
    where
        Dim<D>: Dimension<D>,
    {
        let [fluid, particles] = seats(system);
        let of = |seat: &[Diagnostic], name| value(seat, name).unwrap_or(0.0);
        let wall = self.begin.elapsed().as_secs_f64();
        let waited = waited(system) - self.waited;
        let (wall_fluid, wall_particles) = (of(fluid, WALL), of(particles, WALL));
        StepCost {
            wall_step: wall,
            phases: phases(fluid),
            cpu_fluid: of(fluid, CPU),
            cpu_particles: of(particles, CPU),
            cpu_coupler: cpu_seconds() - self.cpu,
            wall_fluid,
            wall_particles,
            wall_exchange: waited - wall_fluid - wall_particles,
            wall_coupler: wall - waited,
        }
    }
}

/// What of an engine's CPU time it tells apart, and the rest \[s\]; empty when it tells nothing apart.
fn phases(told: &[Diagnostic]) -> Vec<(String, f64)> {
    let named = told
        .iter()
        .filter_map(|d| Some((d.name.strip_prefix(PHASE)?, d.value)));
    let mut phases: Vec<_> = named
        .map(|(phase, seconds)| (phase.to_owned(), seconds))
        .collect();
    if !phases.is_empty() {
        let sum: f64 = phases.iter().map(|(_, seconds)| seconds).sum();
        let whole = value(told, CPU).unwrap_or(sum);
        phases.push(("rest".to_owned(), whole - sum));
    }
    phases
}

/// Diagnostics of both seats.
fn seats<const D: usize, const N: usize>(system: &System<D, N>) -> [&[Diagnostic]; 2]
where
    Dim<D>: Dimension<D>,
{
    let fluid = system.fluid().map_or(&[][..], |seat| &seat.diagnostics);
    let particles = system
        .particles()
        .map_or(&[][..], |seat| seat.diagnostics());
    [fluid, particles]
}

/// Wall time waited for the engines so far \[s\].
fn waited<const D: usize, const N: usize>(system: &System<D, N>) -> f64
where
    Dim<D>: Dimension<D>,
{
    let fluid = system.fluid().map_or(0.0, |seat| seat.wall);
    fluid + system.particles().map_or(0.0, |seat| seat.wall())
}

/// Sums and worst values over a run.
#[derive(Default)]
pub struct Totals {
    /// By name.
    pub named: Vec<Diagnostic>,
}

impl Totals {
    /// Add an accepted step.
    pub fn add(&mut self, report: &StepReport, cost: &StepCost) {
        self.sum("steps", 1.0);
        self.sum("passes", f64::from(report.passes));
        for (name, seconds) in cost.columns() {
            match name.strip_prefix(PHASE_OF_FLUID) {
                Some(phase) => self.sum(&format!("{TOTAL_OF_PHASE}{phase}"), seconds),
                None if name == "wall_step" => self.sum("seconds_wall", seconds),
                None => self.sum(&name, seconds),
            }
        }
        let share = (self.get("wall_exchange") + self.get("wall_coupler"))
            / self.get("seconds_wall").max(f64::MIN_POSITIVE);
        self.update("coupling_share", share, |_, new| new);
        let budget = &report.budget;
        self.worst("volume_defect_max", budget.volume_defect);
        self.worst("momentum_defect_max", budget.momentum_defect);
        self.worst("third_law_defect_max", budget.third_law_defect);
        self.worst("interaction_defect_max", report.interaction_defect);
        self.worst("energy_defect_max", budget.energy_defect);
        self.worst("transfer_loss_max", budget.transfer_loss.abs());
        self.worst("passes_max", f64::from(report.passes));
    }

    /// Add what the fluid engine tells of an accepted step: sums of what meshes have done to what it holds, and
    /// the largest share of one.
    pub fn add_mesh_changes(&mut self, told: &[Diagnostic]) {
        for Diagnostic { name, value } in told.iter().filter(|d| d.name.starts_with(OF_MESH)) {
            match name.ends_with(SHARE) {
                true => self.worst(&format!("{name}_max"), *value),
                false => self.sum(name, *value),
            }
        }
    }

    /// Add a checkpoint that took so long \[s\].
    pub fn add_checkpoint(&mut self, seconds: f64) {
        self.sum("checkpoints", 1.0);
        self.sum("seconds_checkpoints", seconds);
    }

    /// Add a mesh that took so long \[s\].
    pub fn add_mesh(&mut self, seconds: f64) {
        self.sum("meshes", 1.0);
        self.sum("seconds_meshes", seconds);
    }

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

    fn get(&self, name: &str) -> f64 {
        value(&self.named, name).unwrap_or(0.0)
    }
}
