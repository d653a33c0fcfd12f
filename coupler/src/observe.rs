//! Numbers of one accepted step, as they stand in `steps.csv`.

use protocol::message::Diagnostic;
use protocol::monitor::columns;
use space::{Dim, Dimension, Vector, hypot};

use crate::cost::StepCost;
use crate::report::StepReport;
use crate::seats::request::value;
use crate::simulation::Simulation;
use crate::state::{Grains, Removed};

/// The axis along which heights are told, positive upward, and the one along which widths are.
const UP: usize = 1;
const ACROSS: usize = 0;
/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Name and value of every column, in order.
pub fn columns<const D: usize, const N: usize>(
    simulation: &Simulation<D, N>,
    report: &StepReport,
    cost: &StepCost,
) -> Vec<Diagnostic>
where
    Dim<D>: Dimension<D>,
{
    let mut row = Row::default();
    row.add(columns::STEP, simulation.state.step as f64);
    row.add(columns::TIME, simulation.state.time);
    row.add("dt", report.dt);
    row.add(columns::FAILED_TRIES, f64::from(report.failed));
    row.add(columns::PASSES, f64::from(report.passes));
    row.add(columns::SUB_STEPS, f64::from(report.sub_steps));
    for (name, seconds) in cost.columns() {
        row.add(&name, seconds);
    }
    let budget = &report.budget;
    row.add("volume_defect", budget.volume_defect);
    row.add("momentum_defect", budget.momentum_defect);
    row.add("third_law_defect", budget.third_law_defect);
    row.add("interaction_defect", report.interaction_defect);
    row.add("energy_defect", budget.energy_defect);
    row.add("transfer_loss", budget.transfer_loss);
    row.add_contacts(simulation);
    row.add_grains(simulation, report);
    row.add_fluid(simulation);
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

    fn add_contacts<const D: usize, const N: usize>(&mut self, simulation: &Simulation<D, N>)
    where
        Dim<D>: Dimension<D>,
    {
        let Some(seat) = simulation.system.particles() else {
            return;
        };
        self.add(columns::CONTACTS, seat.touching().unwrap_or(0) as f64);
        for name in [
            columns::CONTACT_RESIDUAL,
            columns::CONTACT_SINKING,
            columns::PENETRATION_MAX,
        ] {
            self.add(name, value(seat.diagnostics(), name).unwrap_or(0.0));
        }
        for name in columns::COUNTERS {
            if let Some(number) = value(seat.diagnostics(), name) {
                self.add(name, number);
            }
        }
    }

    fn add_grains<const D: usize, const N: usize>(
        &mut self,
        simulation: &Simulation<D, N>,
        report: &StepReport,
    ) where
        Dim<D>: Dimension<D>,
    {
        if simulation.system.particles().is_none() {
            return;
        }
        let grains = &simulation.state.grains;
        for (axis, name) in AXES.iter().enumerate().take(D) {
            self.add(
                &format!("centre_{name}"),
                mean(&along(&grains.position, axis)),
            );
        }
        let (mut x, mut y) = (along(&grains.position, ACROSS), along(&grains.position, UP));
        // Grains move with the velocity of the step's end, so their places are half a step ahead of it:
        // the middle of the last path belongs to the time of the row, to second order.
        let path = mean(&along(&grains.mean_velocity, UP));
        self.add("centre_y_mid", mean(&y) - 0.5 * report.dt * path);
        let mut rise = along(&grains.velocity, UP);
        self.add("fall_speed", -mean(&rise));
        rise.sort_by(f64::total_cmp);
        self.add("fall_speed_median", -quantile(&rise, 0.5));
        self.add_mechanics(grains, &simulation.gravity);
        if simulation.has_exits() {
            self.add_removed(grains.count(), &simulation.state.removed);
        }
        x.sort_by(f64::total_cmp);
        y.sort_by(f64::total_cmp);
        self.add("front", quantile(&y, 0.0));
        self.add("rear", quantile(&y, 1.0));
        self.add("width", quantile(&x, 1.0) - quantile(&x, 0.0));
        self.add("width98", quantile(&x, 0.99) - quantile(&x, 0.01));
    }

    /// Of the grains that move: Σ m v \[kg m/s\], Σ ½ m v² and Σ m (½ v² − g·x) \[J\], disks per metre.
    fn add_mechanics<const D: usize>(&mut self, grains: &Grains<D>, gravity: &Vector<D>) {
        let (mut momentum, mut kinetic, mut potential) = (Vector::<D>::zeros(), 0.0, 0.0);
        for i in (0..grains.count()).filter(|&i| !grains.fixed[i]) {
            for axis in 0..D {
                let speed = grains.velocity[i][axis];
                momentum[axis] += grains.mass[i] * speed;
                kinetic += 0.5 * grains.mass[i] * speed * speed;
                potential -= grains.mass[i] * gravity[axis] * grains.position[i][axis];
            }
        }
        for (name, momentum) in AXES.iter().zip(&momentum) {
            self.add(&format!("momentum_{name}"), *momentum);
        }
        self.add("kinetic_energy", kinetic);
        self.add("mechanical_energy", kinetic + potential);
    }

    /// Grains that are left, and what has left with the others so far.
    fn add_removed<const D: usize>(&mut self, left: usize, removed: &Removed<D>) {
        self.add(columns::GRAINS, left as f64);
        self.add(columns::REMOVED_GRAINS, removed.grains as f64);
        self.add("removed_volume", removed.volume);
        self.add("removed_mass", removed.mass);
        for (name, momentum) in AXES.iter().zip(&removed.momentum) {
            self.add(&format!("removed_momentum_{name}"), *momentum);
        }
        self.add("removed_energy", removed.energy);
    }

    fn add_fluid<const D: usize, const N: usize>(&mut self, simulation: &Simulation<D, N>)
    where
        Dim<D>: Dimension<D>,
    {
        let Some(seat) = simulation.system.fluid() else {
            return;
        };
        let state = &simulation.state;
        if simulation.follows() {
            self.add(columns::NODES, seat.mesh.node_position.len() as f64);
            self.add(columns::EPOCH, seat.epoch() as f64);
        }
        self.add("fluid_speed_max", speed_max(&state.flow.velocity));
        if let Some(reynolds) = seat.report.reynolds {
            self.add("reynolds", reynolds);
        }
        if let Some(convects) = seat.report.convects {
            self.add(columns::CONVECTION, f64::from(convects));
        }
        for diagnostic in seat.diagnostics.iter().filter(|d| is_column(&d.name)) {
            self.add(&diagnostic.name, diagnostic.value);
        }
        if simulation.system.particles().is_some() {
            let smallest = state.porosity.iter().copied().fold(f64::INFINITY, f64::min);
            self.add(columns::POROSITY_MIN, smallest);
        }
    }
}

/// Numbers of the fluid engine that stand in `steps.csv` as they are: inflow and outflow \[m²/s\],
/// pressure drop \[Pa\], mean pressure gradient where it steers the flow \[Pa/m\], forces on walls and bodies
/// \[N/m\]; where the mesh follows, what it has done to volume \[m²\], momentum \[kg/s\] and kinetic energy
/// \[J/m\] of the fluid.
fn is_column(name: &str) -> bool {
    matches!(name, "inflow" | "outflow" | "pressure_drop")
        || name.starts_with("mean_pressure_gradient_")
        || matches!(name, "mesh_volume" | "mesh_energy")
        || name
            .strip_prefix("mesh_momentum_")
            .is_some_and(|axis| AXES.contains(&axis))
        || AXES.iter().any(|axis| {
            let force = name.strip_prefix("force_");
            let along = force.and_then(|rest| rest.strip_prefix(axis));
            along.is_some_and(|rest| rest.starts_with('_'))
        })
}

/// Largest speed of a velocity field.
pub fn speed_max<const D: usize>(velocity: &[Vector<D>]) -> f64 {
    velocity.iter().map(hypot).fold(0.0, f64::max)
}

/// One component of all vectors.
fn along<const D: usize>(vectors: &[Vector<D>], axis: usize) -> Vec<f64> {
    vectors.iter().map(|vector| vector[axis]).collect()
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
