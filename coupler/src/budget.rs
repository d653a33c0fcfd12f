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
//! Ṫ is m Δv/Δt·v̄: with backward Euler it holds the change of kinetic energy and what the time
//! scheme dissipates. P_sol is the power of the solid's terms as the fluid applied them.

use crate::coupling::Coupling;
use crate::engines;
use crate::scheme::Outcome;

/// Balances of a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Budget {
    /// |(B1)| over the grains' volume.
    pub volume_defect: f64,
    /// |(B2)| over the grains' weight in the fluid: what the third law lacks, carried force included.
    pub third_law_defect: f64,
    /// |Σ γ r| over the grains' weight in the fluid: momentum handed to the next step.
    pub momentum_defect: f64,
    /// |(B3), third line| over the power of gravity.
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

/// Balances of a coupled step about to be accepted.
pub fn of_coupled_step(coupling: &Coupling, outcome: &Outcome, dt: f64) -> Budget {
    let (grains, transfer) = (&coupling.grains, coupling.transfer());
    let depth = transfer.depth();
    let solid: f64 = grains.volume.iter().sum();
    let deposited: f64 = depth
        * transfer
            .nodal_mass()
            .iter()
            .zip(&outcome.fields.porosity)
            .map(|(l, phi)| l * (1.0 - phi))
            .sum::<f64>();
    let (third_law, weight) = third_law(coupling, outcome);
    let energy = energy(coupling, outcome, dt);
    Budget {
        volume_defect: (deposited - solid).abs() / solid,
        third_law_defect: third_law / weight,
        momentum_defect: outcome.defect.momentum,
        ..energy
    }
}

/// |(B2)| and the grains' weight in the fluid, both \[N\].
fn third_law(coupling: &Coupling, outcome: &Outcome) -> (f64, f64) {
    let (grains, transfer, fields) = (&coupling.grains, coupling.transfer(), &outcome.fields);
    let (density, gravity, depth) = (
        coupling.fluid_density(),
        coupling.scene.gravity,
        transfer.depth(),
    );
    let mass = transfer.nodal_mass();
    let sum = [0, 1].map(|axis| {
        let on_fluid: f64 = (0..mass.len())
            .map(|a| {
                let k = 2 * a + axis;
                let pressure = (1.0 - fields.porosity[a] - fields.entrained_fraction[a])
                    * outcome.fluid.pressure_gradient[k];
                mass[a]
                    * (pressure + fields.drag_source[k]
                        - fields.drag[a] * outcome.fluid.velocity[k])
            })
            .sum();
        let on_grains: f64 = (0..grains.count())
            .map(|i| {
                let k = 2 * i + axis;
                let owed = outcome.model.drag[i] * outcome.residual[k] + outcome.lagged[k]
                    - grains.carried[k];
                outcome.force[k] - outcome.model.drag[i] * outcome.grains.mean_velocity[k] + owed
            })
            .sum();
        depth * on_fluid + on_grains
    });
    let weight: f64 = (0..grains.count())
        .map(|i| (grains.mass[i] - density * grains.volume[i]).abs() * gravity[0].hypot(gravity[1]))
        .sum();
    (sum[0].hypot(sum[1]), weight.max(f64::MIN_POSITIVE))
}

/// The lines of (B3).
fn energy(coupling: &Coupling, outcome: &Outcome, dt: f64) -> Budget {
    let (grains, gravity, density) = (
        &coupling.grains,
        coupling.scene.gravity,
        coupling.fluid_density(),
    );
    let velocity = coupling
        .transfer()
        .sample_vector(&outcome.placement, &outcome.fluid.velocity);
    let (mut interaction, mut dissipation, mut contact, mut weight_power) = (0.0, 0.0, 0.0, 0.0);
    for k in 0..velocity.len() {
        let i = k / 2;
        let (mean, drag) = (outcome.grains.mean_velocity[k], outcome.model.drag[i]);
        let on_grain = outcome.force[k] - drag * mean;
        let inertia = grains.mass[i] * (outcome.grains.velocity[k] - grains.velocity[k]) / dt;
        interaction += on_grain * mean;
        dissipation += drag * (velocity[k] - mean).powi(2);
        contact += (inertia - grains.mass[i] * gravity[k % 2] - on_grain) * mean;
        weight_power += (grains.mass[i] - density * grains.volume[i]) * gravity[k % 2] * mean;
    }
    let diagnostics = coupling
        .fluid
        .as_ref()
        .map_or(&[][..], |seat| &seat.diagnostics);
    let solid = coupling.transfer().depth()
        * engines::value(diagnostics, "solid_power").unwrap_or(f64::NAN);
    let nodal = nodal_power(coupling, outcome);
    let scale = weight_power.abs().max(dissipation).max(f64::MIN_POSITIVE);
    Budget {
        energy_defect: (interaction + nodal + dissipation).abs() / scale,
        transfer_loss: (nodal - solid) / scale,
        gravity_power: weight_power,
        drag_dissipation: dissipation,
        contact_dissipation: -contact,
        ..Budget::default()
    }
}

/// P_nod of (B3).
fn nodal_power(coupling: &Coupling, outcome: &Outcome) -> f64 {
    let (mass, fields) = (coupling.transfer().nodal_mass(), &outcome.fields);
    let power = |k: usize| {
        let (a, w, gradient) = (
            k / 2,
            outcome.fluid.velocity[k],
            outcome.fluid.pressure_gradient[k],
        );
        let entrained = fields.entrained_fraction[a] * w;
        let flux = entrained + fields.solid_flux[k] - fields.solid_mobility[a] * gradient;
        let on_fluid = w * (fields.drag_source[k] - fields.drag[a] * w) - entrained * gradient;
        mass[a] * (on_fluid + flux * gradient)
    };
    coupling.transfer().depth() * (0..outcome.fluid.velocity.len()).map(power).sum::<f64>()
}
