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

use space::{Dim, Dimension, Vector, hypot};

use crate::coupled::response::Model;
use crate::scale::{present, relative};
use crate::state::Grains;
use crate::transfer::quantity::nodal_norm;
use crate::transfer::{Placement, Transfer};

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
    /// |Σ γ r| over the grains' total weight in the fluid, of grains that weigh nothing there over the sum of
    /// their f.
    pub momentum: f64,
    /// |e_i|/f_i of each grain.
    pub of_grains: Vec<f64>,
}

/// What a pass is measured with.
#[derive(Debug, Clone, Copy)]
pub struct Scales<const D: usize> {
    /// ρ of the fluid \[kg/m³\]
    pub density: f64,
    /// g \[m/s²\]
    pub gravity: Vector<D>,
    /// Δt \[s\]
    pub dt: f64,
}

/// Forces of one grain.
struct GrainForces<const D: usize> {
    /// m g − ρ V g
    weight: Vector<D>,
    /// e of (F1)
    error: Vector<D>,
    /// f of (F2)
    scale: f64,
}

impl<const D: usize> Scales<D> {
    fn of_grain(
        &self,
        i: usize,
        mass: f64,
        model: &Model<D>,
        force: &Vector<D>,
        residual: &Vector<D>,
        mean_velocity: &Vector<D>,
    ) -> GrainForces<D> {
        let displaced = self.density * model.volume[i];
        let stiffness = model.drag[i] + (mass + displaced) / self.dt;
        let weight = self.gravity * (mass - displaced);
        let hydrodynamic = force - mean_velocity * model.drag[i] + self.gravity * displaced;
        let round_off = ROUND_OFF * mass * hypot(&self.gravity)
            + SLIP_ROUND_OFF * stiffness * hypot(mean_velocity);
        GrainForces {
            weight,
            error: residual * stiffness, // (F1)
            scale: hypot(&weight) + hypot(&hydrodynamic) + round_off, // (F2)
        }
    }
}

/// d of a pass, with q, r and v̄ of every grain.
pub fn measure<const D: usize, const N: usize>(
    scales: &Scales<D>,
    transfer: &Transfer<D, N>,
    placement: &Placement,
    grains: &Grains<D>,
    model: &Model<D>,
    [force, residual, mean_velocity]: [&[Vector<D>]; 3],
) -> Defect
where
    Dim<D>: Dimension<D>,
{
    let of_grain = |i: usize| {
        let mass = grains.mass[i];
        scales.of_grain(i, mass, model, &force[i], &residual[i], &mean_velocity[i])
    };
    let forces: Vec<GrainForces<D>> = (0..grains.count()).map(of_grain).collect();
    let error = transfer.deposit(placement, |i| forces[i].error);
    let scale = transfer.deposit(placement, |i| forces[i].scale);
    let mass = transfer.nodal_mass();
    let scale = nodal_norm(mass, &scale).max(f64::MIN_POSITIVE);
    let weight: Vector<D> = forces.iter().map(|own| own.weight).sum();
    let lost: Vector<D> = (0..forces.len()).map(|i| residual[i] * model.drag[i]).sum();
    // an error where there is no scale is the largest there is, and not none
    let of_grain = |own: &GrainForces<D>| hypot(&own.error) / own.scale.max(f64::MIN_POSITIVE);
    let all = forces.iter().map(|own| own.scale).sum();
    Defect {
        relative: nodal_norm(mass, &error) / scale, // (F3)
        scale,
        momentum: relative(hypot(&lost), present(hypot(&weight), all)),
        of_grains: forces.iter().map(of_grain).collect(),
    }
}
