//! The interaction defect: what the fluid gave minus what the grains took, as a force over a force.
//!
//! ```text
//!   e_i = (γ + m/Δt + ρV/Δt) r_i                     r = v̄ − v_model                        (F1)
//!   f_i = |m g − ρ V g| + |q − γ v̄ + ρ V g|          weight in the fluid, hydrodynamic force  (F2)
//!         + round-off of m |g| and of (γ + m/Δt + ρV/Δt) |v̄|
//!   d   = ‖T(e)‖ / ‖T(f)‖,   ‖x‖² = Σ_α ℓ_α |x_α|²                                           (F3)
//! ```
//!
//! A velocity-relative defect accepts wrong answers in stiff flows (slip is 1e-6 of the speed
//! there); one with the worst grain repeats a step for forces of a collision that cancel within a
//! cell and that the fluid never sees. On the nodes d is what the fluid could have noticed.

use crate::coupling::Coupling;
use crate::engines::GrainCandidate;
use crate::response::Model;
use crate::transfer::Placement;

/// Part of a grain's weight that its forces are known to: neutral grains at rest feel nothing else.
const ROUND_OFF: f64 = 1e-7;
/// Part of a grain's speed that the slip is known to: grains that drift with the fluid, in a box without
/// gravity, feel nothing else. With the tolerance of the passes this is near the last digits, and
/// a thousandth of the slip of the stiffest flow that is driven: it decides nothing there.
const SLIP_ROUND_OFF: f64 = 1e-9;

/// Size of the residual of a pass.
#[derive(Debug, Clone, Default)]
pub struct Defect {
    /// d of (F3).
    pub relative: f64,
    /// ‖T(f)‖, never 0.
    pub scale: f64,
    /// |Σ γ r| over the grains' total weight in the fluid.
    pub momentum: f64,
    /// |e_i|/f_i of each grain.
    pub of_grains: Vec<f64>,
}

/// d of a pass.
pub fn measure(
    coupling: &Coupling,
    placement: &Placement,
    model: &Model,
    force: &[f64],
    residual: &[f64],
    candidate: &GrainCandidate,
    dt: f64,
) -> Defect {
    let (grains, transfer, density) = (
        &coupling.grains,
        coupling.transfer(),
        coupling.fluid_density(),
    );
    let gravity = coupling.scene.gravity;
    let weight =
        |i: usize, axis: usize| (grains.mass[i] - density * model.volume[i]) * gravity[axis];
    let stiffness = |i: usize| model.drag[i] + (grains.mass[i] + density * model.volume[i]) / dt;
    let error_of = |i: usize| [0, 1].map(|axis| stiffness(i) * residual[2 * i + axis]); // (F1)
    let scale_of = |i: usize| {
        let hydrodynamic = [0, 1].map(|axis| {
            let k = 2 * i + axis;
            let buoyancy = density * model.volume[i] * gravity[axis];
            force[k] - model.drag[i] * candidate.mean_velocity[k] + buoyancy
        });
        let speed = candidate.mean_velocity[2 * i].hypot(candidate.mean_velocity[2 * i + 1]);
        let round_off = ROUND_OFF * grains.mass[i] * gravity[0].hypot(gravity[1])
            + SLIP_ROUND_OFF * stiffness(i) * speed;
        weight(i, 0).hypot(weight(i, 1)) + hydrodynamic[0].hypot(hydrodynamic[1]) + round_off // (F2)
    };
    let error = transfer.deposit_vector(placement, error_of);
    let scale = transfer.deposit(placement, scale_of);
    let of_grain = |i: usize| {
        let [x, y] = error_of(i);
        x.hypot(y) / scale_of(i).max(f64::MIN_POSITIVE)
    };
    let mass = transfer.nodal_mass();
    let scale = nodal_norm(mass, &scale).max(f64::MIN_POSITIVE);
    let total = |value: &dyn Fn(usize, usize) -> f64| {
        let sum = [0, 1].map(|axis| (0..grains.count()).map(|i| value(i, axis)).sum::<f64>());
        sum[0].hypot(sum[1])
    };
    let weight_total = total(&|i, axis| weight(i, axis)).max(f64::MIN_POSITIVE);
    Defect {
        relative: nodal_norm(mass, &error) / scale, // (F3)
        scale,
        momentum: total(&|i, axis| model.drag[i] * residual[2 * i + axis]) / weight_total,
        of_grains: (0..grains.count()).map(of_grain).collect(),
    }
}

/// ‖x‖ of a nodal field with one or two components a node.
pub fn nodal_norm(mass: &[f64], field: &[f64]) -> f64 {
    let components = field.len() / mass.len();
    field
        .iter()
        .enumerate()
        .map(|(k, value)| mass[k / components] * value * value)
        .sum::<f64>()
        .sqrt()
}
