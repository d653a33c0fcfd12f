//! Balances of one accepted step: volume, momentum, energy. All from what was exchanged.
//!
//! ```text
//!   volume     Σ ℓ(1−φ) = Σ V                                                                (B1)
//!   momentum   Σ (q − γ v̄) + Σ ℓ [(1−φ−c) G + s − β w] = Σ γ (rⁿ − rⁿ⁺¹)                       (B2)
//!   energy     grains   Ṫ_p = P_g + P_int + P_c        P_int = Σ (q − γ v̄)·v̄                  (B3)
//!              fluid    Ṫ_f + P_μ + P_stab = P_gf + P_b + P_sol
//!              both     P_int + P_nod + Σ γ |N w − v̄|² = 0
//!              P_nod = Σ ℓ [w·s − β|w|² − c w·G + (c w + j⁰ − κ G)·G]
//! ```
//!
//! P_nod is P_sol with nodal products; the difference is what the transfer between nodes and the
//! fluid's quadrature costs, of second order in the cell size. It is reported, not hidden.
//!
//! A mesh that follows changes what the fluid holds between two steps, (Z3) of the engine: over a run its volume,
//! momentum and T_f are balanced with Σ ΔV, Σ ΔM and Σ ΔT of all meshes (`mesh_volume`, `mesh_momentum_x`, `_y`,
//! `mesh_energy`), per metre of depth. (B1) knows nothing of ΔV, as φ is deposited anew.
//!
//! Ṫ is m Δv/Δt·v̄: with backward Euler it holds the change of kinetic energy and what the time
//! scheme dissipates. P_sol is the power of the solid's terms as the fluid applied them.

use space::{Dim, Dimension, Vector, hypot};

use crate::coupled::outcome::Outcome;
use crate::error::CouplerError;
use crate::immersion::Immersion;
use crate::scale::{present, relative};
use crate::state::Grains;

/// Balances of a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Budget {
    /// |(B1)| over the grains' volume.
    pub volume_defect: f64,
    /// |(B2)| over the grains' weight in the fluid, of grains that weigh nothing there over the forces on
    /// them: what the third law lacks, carried force included.
    pub third_law_defect: f64,
    /// |Σ γ r| over the grains' weight in the fluid: momentum handed to the next step.
    pub momentum_defect: f64,
    /// |(B3), third line| over the power of gravity, of drag, or what there is.
    pub energy_defect: f64,
    /// P_nod − P_sol over the power of gravity.
    pub transfer_loss: f64,
    /// Power of gravity on the grains in the fluid \[W\] (disk: W per metre).
    pub gravity_power: f64,
    /// Power lost in drag \[W\].
    pub drag_dissipation: f64,
    /// Power lost in contacts \[W\].
    pub contact_dissipation: f64,
}

/// Largest defect of what is exact but for round-off: volume, and action against reaction.
const EXACT: f64 = 1e-6;

impl Budget {
    /// The defects that must vanish but for round-off, or an error that names the one that does not.
    pub fn check(&self, step: u64) -> Result<(), CouplerError> {
        let exact = [
            ("volume_defect", self.volume_defect),
            ("third_law_defect", self.third_law_defect),
        ];
        let broken = |defect: f64| defect.is_nan() || defect > EXACT;
        match exact.into_iter().find(|(_, defect)| broken(*defect)) {
            None => Ok(()),
            Some((what, defect)) => Err(CouplerError::Unbalanced {
                step,
                what,
                defect,
                bound: EXACT,
            }),
        }
    }
}

/// Balances of a coupled step about to be accepted; `solid_power` is P_sol, per metre of depth.
pub fn of_coupled_step<const D: usize, const N: usize>(
    immersion: &Immersion<D, N>,
    grains: &Grains<D>,
    outcome: &Outcome<D, N>,
    solid_power: f64,
    dt: f64,
) -> Budget
where
    Dim<D>: Dimension<D>,
{
    let transfer = &immersion.transfer;
    let (depth, mass) = (transfer.depth(), transfer.nodal_mass());
    let step = Step {
        immersion,
        grains,
        outcome,
        dt,
    };
    let powers = step.powers();
    let nodal = depth * step.nodal_power();
    let scale = present(
        powers.gravity.abs().max(powers.drag),
        powers.interaction.abs() + nodal.abs(),
    );
    let weight = present(step.weight(), step.force_sizes());
    let third_law = step.force_on_fluid(mass) * depth + step.force_on_grains();
    Budget {
        volume_defect: volume_defect(depth, mass, &outcome.response.porosity, &grains.volume),
        third_law_defect: relative(hypot(&third_law), weight),
        momentum_defect: outcome.pass.defect.momentum,
        energy_defect: relative((powers.interaction + nodal + powers.drag).abs(), scale),
        transfer_loss: relative(nodal - depth * solid_power, scale),
        gravity_power: powers.gravity,
        drag_dissipation: powers.drag,
        contact_dissipation: -powers.contact,
    }
}

/// |(B1)| over Σ V.
fn volume_defect(depth: f64, mass: &[f64], porosity: &[f64], volume: &[f64]) -> f64 {
    let solid: f64 = volume.iter().sum();
    let nodes = mass.iter().zip(porosity);
    let deposited = depth * nodes.map(|(l, phi)| l * (1.0 - phi)).sum::<f64>();
    relative((deposited - solid).abs(), solid)
}

/// Powers of the grains \[W\].
#[derive(Debug, Clone, Copy, Default)]
struct Powers {
    /// P_int of (B3).
    interaction: f64,
    /// Σ γ |N w − v̄|².
    drag: f64,
    /// P_c of (B3).
    contact: f64,
    /// Σ (m − ρV) g·v̄.
    gravity: f64,
}

/// A step that is measured.
struct Step<'a, const D: usize, const N: usize> {
    immersion: &'a Immersion<D, N>,
    /// Before the step.
    grains: &'a Grains<D>,
    outcome: &'a Outcome<D, N>,
    dt: f64,
}

impl<const D: usize, const N: usize> Step<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Σ ℓ [(1−φ−c) G + s − β w] of (B2), per metre of depth.
    fn force_on_fluid(&self, mass: &[f64]) -> Vector<D> {
        let (response, flow) = (&self.outcome.response, &self.outcome.pass.flow);
        let at = |a: usize| {
            let share = 1.0 - response.porosity[a] - response.entrained_fraction[a];
            let pressure = flow.pressure_gradient[a] * share;
            (pressure + response.drag_source[a] - flow.velocity[a] * response.drag[a]) * mass[a]
        };
        (0..mass.len()).map(at).sum()
    }

    /// Σ (q − γ v̄) of (B2), with what this step owes and the last one owed.
    fn force_on_grains(&self) -> Vector<D> {
        let (outcome, pass) = (self.outcome, &self.outcome.pass);
        let drag = &outcome.model.drag;
        let of = |i: usize| {
            let owed =
                pass.residual[i] * drag[i] + outcome.lagged[i] - self.grains.carried_force[i];
            pass.force[i] - pass.grains.mean_velocity[i] * drag[i] + owed
        };
        (0..self.grains.count()).map(of).sum()
    }

    /// Σ |m − ρV| |g|.
    fn weight(&self) -> f64 {
        let (density, gravity) = (self.immersion.fluid.density, hypot(&self.immersion.gravity));
        let bodies = self.grains.mass.iter().zip(&self.grains.volume);
        bodies
            .map(|(mass, volume)| (mass - density * volume).abs() * gravity)
            .sum()
    }

    /// Σ |q − γ v̄| + Σ m (|g| + |v̄|/Δt): every force that there is.
    fn force_sizes(&self) -> f64 {
        let (outcome, pass) = (self.outcome, &self.outcome.pass);
        let gravity = hypot(&self.immersion.gravity);
        let of = |i: usize| {
            let velocity = &pass.grains.mean_velocity[i];
            let on_grain = pass.force[i] - velocity * outcome.model.drag[i];
            hypot(&on_grain) + self.grains.mass[i] * (gravity + hypot(velocity) / self.dt)
        };
        (0..self.grains.count()).map(of).sum()
    }

    fn powers(&self) -> Powers {
        let (grains, outcome, pass) = (self.grains, self.outcome, &self.outcome.pass);
        let (density, gravity) = (self.immersion.fluid.density, &self.immersion.gravity);
        let transfer = &self.immersion.transfer;
        let fluid = transfer.sample(&outcome.placement, &pass.flow.velocity);
        let mut powers = Powers::default();
        for i in 0..grains.count() {
            let (mass, drag) = (grains.mass[i], outcome.model.drag[i]);
            let mean = pass.grains.mean_velocity[i];
            let on_grain = pass.force[i] - mean * drag;
            let inertia = (pass.grains.velocity[i] - grains.velocity[i]) * mass / self.dt;
            let contact = inertia - gravity * mass - on_grain;
            let weight = gravity * (mass - density * grains.volume[i]);
            for axis in 0..D {
                powers.interaction += on_grain[axis] * mean[axis];
                powers.drag += drag * (fluid[i][axis] - mean[axis]).powi(2);
                powers.contact += contact[axis] * mean[axis];
                powers.gravity += weight[axis] * mean[axis];
            }
        }
        powers
    }

    /// P_nod of (B3), per metre of depth.
    fn nodal_power(&self) -> f64 {
        let (response, flow) = (&self.outcome.response, &self.outcome.pass.flow);
        let mut power = 0.0;
        for (a, mass) in self.immersion.transfer.nodal_mass().iter().enumerate() {
            let (drag, c) = (response.drag[a], response.entrained_fraction[a]);
            for axis in 0..D {
                let (w, gradient) = (flow.velocity[a][axis], flow.pressure_gradient[a][axis]);
                let entrained = c * w;
                let flux = entrained + response.solid_flux[a][axis]
                    - response.solid_mobility[a] * gradient;
                let on_fluid =
                    w * (response.drag_source[a][axis] - drag * w) - entrained * gradient;
                power += mass * (on_fluid + flux * gradient);
            }
        }
        power
    }
}
