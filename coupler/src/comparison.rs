//! Schemes of other codes, to be compared with: one pass, nothing tested, nothing carried on.
//!
//! ```text
//!   semi-implicit   fluid   β = T(γ), s = T(γ vⁿ), j⁰ = T(V vⁿ), c = κ = 0
//!                   grains  γ and q = γ N w − V N G, drag implicit                        (C1)
//!   explicit        fluid   β = 0, s = −T(γ (N wⁿ − vⁿ)), j⁰ = T(V vⁿ), c = κ = 0
//!                   grains  the force γ (N wⁿ − vⁿ) − V N G, no drag coefficient          (C2)
//! ```
//!
//! (C1) is the affine model of `response.rs` with λ = 0 and z = vⁿ. Its lagged solid flux amplifies
//! by 1/φ² − 1 a step in stiff free motion and by the added mass, (1−φ)ρ/(φρ_p), at any step: it
//! diverges below φ = 0.707 where stiff, and wherever grains are light for their porosity. The fluid
//! feels γ vⁿ and the grains γ vⁿ⁺¹: the difference is reported as `momentum_defect` and lost. (C2) conserves momentum and diverges once Δt (1/τ_p + 1/τ_f) > 2, with
//! τ_p = m/γ and τ_f = φρ/β. Both lack the deferred correction.

use crate::coupling::Coupling;
use crate::defect;
use crate::error::CouplerError;
use crate::response::{self, Model};
use crate::scheme::Outcome;
use crate::transfer::Placement;

impl Coupling {
    /// A step of (C1); nothing is committed.
    pub(crate) fn semi_implicit_step(&mut self, dt: f64) -> Result<Outcome, CouplerError> {
        let placement = self.place(dt)?;
        let porosity = self.porosity(&placement)?;
        let drag = self.drag_coefficients(&placement, &porosity, Some(dt));
        let none = vec![0.0; 2 * self.grains.count()];
        self.lagged_step(placement, &porosity, drag, &none, dt)
    }

    /// A step of (C2); nothing is committed.
    pub(crate) fn explicit_step(&mut self, dt: f64) -> Result<Outcome, CouplerError> {
        let placement = self.place(dt)?;
        let porosity = self.porosity(&placement)?;
        let drag = self.drag_coefficients(&placement, &porosity, None);
        let fluid = self
            .transfer()
            .sample_vector(&placement, &self.fluid_state.velocity);
        let force: Vec<f64> = (0..fluid.len())
            .map(|k| drag[k / 2] * (fluid[k] - self.grains.velocity[k]))
            .collect();
        let no_drag = vec![0.0; self.grains.count()];
        self.lagged_step(placement, &porosity, no_drag, &force, dt)
    }

    /// One pass with λ = 0 and z = vⁿ; `given` is a force on the grains known beforehand \[N\], its
    /// reaction on the fluid included.
    fn lagged_step(
        &mut self,
        placement: Placement,
        porosity: &[f64],
        drag: Vec<f64>,
        given: &[f64],
        dt: f64,
    ) -> Result<Outcome, CouplerError> {
        let request = self.request(1, dt);
        let model = self.lagged_model(drag, dt);
        let mut fields = response::matrix_fields(self.transfer(), &placement, porosity, &model);
        let no_correction = {
            let zero = vec![0.0; 2 * self.transfer().node_count()];
            (zero.clone(), zero)
        };
        let reaction: Vec<f64> = given.iter().map(|force| -force).collect();
        response::set_sources(
            self.transfer(),
            &placement,
            &mut fields,
            &model,
            &no_correction,
            &reaction,
        );
        let fluid = self.solve_fluid(&request, Some(&fields))?;
        let mut force = self.grain_force(&placement, &fluid, &model);
        force.iter_mut().zip(given).for_each(|(q, own)| *q += own);
        let grains = self.move_grains(&request, &model.drag, &force, 0)?;
        let residual: Vec<f64> = grains
            .mean_velocity
            .iter()
            .zip(&model.free_velocity)
            .map(|(v, old)| v - old)
            .collect();
        let defect = defect::measure(self, &placement, &model, &force, &residual, &grains, dt);
        let zero = vec![0.0; force.len()];
        Ok(Outcome {
            fluid,
            grains,
            placement,
            model,
            fields,
            force,
            residual,
            defect,
            passes: 1,
            lagged: zero.clone(),
            carried: zero,
        })
    }

    fn lagged_model(&self, drag: Vec<f64>, dt: f64) -> Model {
        let mut model = self.free_model(drag, dt, 1);
        model.lambda.fill(0.0);
        model.free_velocity.copy_from_slice(&self.grains.velocity);
        model
    }
}
