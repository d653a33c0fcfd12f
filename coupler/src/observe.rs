//! Numbers of one accepted step, as they stand in `steps.csv`.

use protocol::messages::Diagnostic;

use crate::coupling::{Coupling, StepReport};
use crate::engines::value;

/// Times of one step \[s\].
#[derive(Debug, Clone, Copy, Default)]
pub struct StepCost {
    /// Wall time of the step.
    pub wall: f64,
    /// CPU time of the fluid engine.
    pub cpu_fluid: f64,
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

/// Name and value of every column, in order.
pub fn columns(coupling: &Coupling, report: &StepReport, cost: &StepCost) -> Vec<Diagnostic> {
    let mut row = Row::default();
    row.add("step", coupling.step as f64);
    row.add("time", coupling.time);
    row.add("dt", report.dt);
    row.add("passes", f64::from(report.passes));
    row.add("sub_steps", f64::from(report.sub_steps));
    row.add("wall", cost.wall);
    row.add("cpu_fluid", cost.cpu_fluid);
    row.add("cpu_particles", cost.cpu_particles);
    row.add("cpu_coupler", cost.cpu_coupler);
    row.add("wall_fluid", cost.wall_fluid);
    row.add("wall_particles", cost.wall_particles);
    row.add("wall_exchange", cost.wall_exchange);
    row.add("wall_coupler", cost.wall_coupler);
    row.add("volume_defect", report.budget.volume_defect);
    row.add("momentum_defect", report.budget.momentum_defect);
    row.add("third_law_defect", report.budget.third_law_defect);
    row.add("interaction_defect", report.interaction_defect);
    row.add("energy_defect", report.budget.energy_defect);
    row.add("transfer_loss", report.budget.transfer_loss);
    add_grains(&mut row, coupling, report);
    add_fluid(&mut row, coupling);
    row.0
}

#[derive(Default)]
struct Row(Vec<Diagnostic>);

impl Row {
    fn add(&mut self, name: &str, value: f64) {
        self.0.push(Diagnostic {
            name: name.to_owned(),
            value,
        });
    }
}

/// Numbers of the particle engine that stand in `steps.csv` where it counts them.
const COUNTERS: [&str; 4] = [
    "contact_candidates",
    "contact_searches",
    "contact_sweeps",
    "wall_looks",
];

fn add_grains(row: &mut Row, coupling: &Coupling, report: &StepReport) {
    let Some(seat) = &coupling.particles else {
        return;
    };
    for name in ["contacts", "contact_residual", "penetration_max"] {
        row.add(name, value(&seat.diagnostics, name).unwrap_or(0.0));
    }
    for name in COUNTERS {
        if let Some(number) = value(&seat.diagnostics, name) {
            row.add(name, number);
        }
    }
    let grains = &coupling.grains;
    let axis = |values: &[f64], axis: usize| -> Vec<f64> {
        values.iter().skip(axis).step_by(2).copied().collect()
    };
    let (mut x, mut y) = (axis(&grains.position, 0), axis(&grains.position, 1));
    row.add("centre_x", mean(&x));
    row.add("centre_y", mean(&y));
    // Grains move with the velocity of the step's end, so their places are half a step ahead of it:
    // the middle of the last path belongs to the time of the row, to second order.
    let path = mean(&axis(&grains.mean_velocity, 1));
    row.add("centre_y_mid", mean(&y) - 0.5 * report.dt * path);
    let mut rise = axis(&grains.velocity, 1);
    row.add("fall_speed", -mean(&rise));
    rise.sort_by(f64::total_cmp);
    row.add("fall_speed_median", -quantile(&rise, 0.5));
    for (name, value) in mechanics(coupling) {
        row.add(name, value);
    }
    x.sort_by(f64::total_cmp);
    y.sort_by(f64::total_cmp);
    row.add("front", quantile(&y, 0.0));
    row.add("rear", quantile(&y, 1.0));
    row.add("width", quantile(&x, 1.0) - quantile(&x, 0.0));
    row.add("width98", quantile(&x, 0.99) - quantile(&x, 0.01));
}

/// Of the grains that move: Σ m v \[kg m/s\], Σ ½ m v² and Σ m (½ v² − g·x) \[J\], disks per metre.
fn mechanics(coupling: &Coupling) -> [(&'static str, f64); 4] {
    let (grains, gravity) = (&coupling.grains, coupling.scene().gravity);
    let (mut momentum, mut kinetic, mut potential) = ([0.0; 2], 0.0, 0.0);
    for i in (0..grains.count()).filter(|&i| !grains.fixed[i]) {
        let at = |values: &[f64], axis: usize| values[2 * i + axis];
        for axis in 0..2 {
            let speed = at(&grains.velocity, axis);
            momentum[axis] += grains.mass[i] * speed;
            kinetic += 0.5 * grains.mass[i] * speed * speed;
            potential -= grains.mass[i] * gravity[axis] * at(&grains.position, axis);
        }
    }
    [
        ("momentum_x", momentum[0]),
        ("momentum_y", momentum[1]),
        ("kinetic_energy", kinetic),
        ("mechanical_energy", kinetic + potential),
    ]
}

fn add_fluid(row: &mut Row, coupling: &Coupling) {
    let Some(seat) = &coupling.fluid else { return };
    row.add("fluid_speed_max", speed_max(&coupling.fluid_state.velocity));
    for diagnostic in seat.diagnostics.iter().filter(|d| is_column(&d.name)) {
        row.add(&diagnostic.name, diagnostic.value);
    }
    if coupling.particles.is_some() {
        row.add(
            "porosity_min",
            coupling
                .porosity
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min),
        );
    }
}

/// Numbers of the fluid engine that stand in `steps.csv` as they are: Reynolds number of the flow, is
/// convection there (1, 0), inflow \[m²/s\], pressure drop
/// \[Pa\], forces on walls and bodies \[N/m\].
fn is_column(name: &str) -> bool {
    matches!(name, "inflow" | "pressure_drop" | "reynolds" | "convection")
        || name.starts_with("force_x_")
        || name.starts_with("force_y_")
}

/// Largest speed of an interleaved velocity field.
pub fn speed_max(velocity: &[f64]) -> f64 {
    velocity
        .chunks_exact(2)
        .map(|v| v[0].hypot(v[1]))
        .fold(0.0, f64::max)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Quantile of sorted values, by linear interpolation.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return 0.0;
    };
    let place = share * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}
