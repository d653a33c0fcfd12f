//! A coupled step that is accepted.

use space::{Dim, Dimension, Vector};

use crate::budget;
use crate::coupled::outcome::Outcome;
use crate::coupled::step::Coupled;
use crate::error::CouplerError;
use crate::report::StepReport;
use crate::state::{Contact, State, require_finite};

impl<const D: usize, const N: usize> Coupled<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Advance the accepted state by dt \[s\]; an error leaves it as it is.
    pub fn advance(&mut self, state: &mut State<D>, dt: f64) -> Result<StepReport, CouplerError> {
        let outcome = self.step(state, dt)?;
        let (pass, step) = (&outcome.pass, state.step + 1);
        require_finite(&pass.grains.position, step, "a grain's position")?;
        require_finite(&pass.flow.velocity, step, "the fluid's velocity")?;
        let solid_power = self.engines.fluid.report.solid_power.unwrap_or(f64::NAN);
        let (immersion, grains) = (&self.immersion, &state.grains);
        let report = StepReport {
            dt,
            passes: outcome.passes,
            sub_steps: pass.grains.sub_steps,
            interaction_defect: pass.defect.relative,
            budget: budget::of_coupled_step(immersion, grains, &outcome, solid_power, dt),
            ..StepReport::default()
        };
        report.budget.check(step)?;
        state.grains.contact_force = self.contact_force(state, &outcome, dt);
        state.grains.carried_force = outcome.carried_force;
        state.grains.accept(outcome.pass.grains);
        state.flow = outcome.pass.flow;
        state.porosity = outcome.response.porosity;
        Ok(report)
    }

    /// F_c = m (vⁿ⁺¹ − vⁿ)/Δt − (m g + q − γ v̄) where a grain touches, else 0.
    fn contact_force(&self, state: &State<D>, outcome: &Outcome<D, N>, dt: f64) -> Vec<Vector<D>> {
        let (grains, pass) = (&state.grains, &outcome.pass);
        let force = |i: usize| {
            if pass.grains.contact[i] < Contact::Touches || grains.fixed[i] {
                return Vector::zeros();
            }
            let mass = grains.mass[i];
            let inertia = (pass.grains.velocity[i] - grains.velocity[i]) * mass / dt;
            let drag = pass.grains.mean_velocity[i] * outcome.model.drag[i];
            inertia - self.immersion.gravity * mass - pass.force[i] + drag
        };
        (0..grains.count()).map(force).collect()
    }
}
