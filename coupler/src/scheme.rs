//! One coupling step: the staggered scheme of Constant, Dubois, Lambrechts and Legat with the
//! solid's response and, where contacts demand it, further passes.
//!
//! ```text
//!   S1  place grains at xⁿ + ½Δt vⁿ; porosity, γ, response z + λ D q          (response.rs)
//!   S0  where grains touch: a contact solve with the old fluid fields predicts z and who is held
//!       repeat
//!   S2    fluid: w, G, p at tⁿ⁺¹ under φ, β, s, c, j⁰, κ
//!   S3    q = γ N w − V N G
//!   S4-5  grains: free velocities, contacts → v̄
//!   S6    r = v̄ − (z + λ D q): accept when its force is below the tolerance,
//!         else z ← v̄ − λ D q, accelerated, with the matrix kept
//! ```
//!
//! λ = 1 is exact for a grain without contact, so a free cloud takes one pass. λ = 0 for grains
//! that contacts hold to a wall; if that proves wrong they get ½, which contracts for every
//! frictionless contact set (the pass is then a Peaceman–Rachford step on the contact problem).
//!
//! Engines that can do less: where the grains' contacts are not told, λ = ½ for every grain that may
//! touch something (proximity.rs). A fluid without the affine response is given c = κ = 0, so that the
//! deferred correction holds all of both, at the last known w* and G*; passes then go on until these
//! stand still.

use protocol::configure::Scheme;

use crate::anderson::Anderson;
use crate::coupling::{Coupling, GrainState};
use crate::defect::{self, Defect};
use crate::engines::GrainCandidate;
use crate::error::CouplerError;
use crate::response::{self, FluidState, Model, NodalResponse};
use crate::transfer::Placement;

/// Contact state of a grain that touches something.
pub const TOUCHES: f64 = 1.0;
/// Contact state of a grain that is force-connected to a wall or a fixed grain.
pub const HELD: f64 = 2.0;

const ANDERSON_DEPTH: usize = 10;
/// Passes may go on without bringing the defect below this part of its smallest value so far…
const CONTRACTION: f64 = 0.7;
/// … this many times.
const PATIENCE: u32 = 4;
/// A defect that grows by this factor has no patience.
const GROWTH_MAX: f64 = 5.0;
/// A grain's model is wrong when its own defect is above this multiple of the tolerance.
const WRONG: f64 = 10.0;
/// The unbalanced force of a staggered step is carried on only below this defect: above it, the
/// carry amplifies.
const CARRY_MAX: f64 = 1e-2;

/// What a step has computed, before it is committed.
pub struct Outcome {
    /// New nodal fields.
    pub fluid: FluidState,
    /// New grains.
    pub grains: GrainCandidate,
    /// The placement all transfers of the step used.
    pub placement: Placement,
    /// The last model and the fields made from it.
    pub model: Model,
    /// What the fluid was given.
    pub fields: NodalResponse,
    /// q of the last pass \[N\].
    pub force: Vec<f64>,
    /// r = v̄ − v_model \[m/s\].
    pub residual: Vec<f64>,
    /// Size of r as a force.
    pub defect: Defect,
    /// Fluid solves.
    pub passes: u32,
    /// V A N (G* − G): pressure force that a fluid without c was not given \[N\].
    pub lagged: Vec<f64>,
    /// γ r, and what lagged, to hand to the next step \[N\].
    pub carried: Vec<f64>,
}

/// The iterate of the passes.
struct Iteration {
    model: Model,
    fields: NodalResponse,
    known: FluidState,
    sub_steps: u32,
    predicted: bool,
    /// Times λ was raised where the model was wrong.
    raised: u32,
    anderson: Option<Anderson>,
    /// Smallest defect with this matrix, and passes since it was set.
    smallest: f64,
    passes_without_progress: u32,
}

impl Coupling {
    /// A step of length dt with fluid and grains under the scene's scheme; nothing is committed.
    pub(crate) fn coupled_step(&mut self, dt: f64) -> Result<Outcome, CouplerError> {
        match self.scene.scheme {
            Scheme::Staggered => self.passes(dt, f64::INFINITY, 1),
            Scheme::Iterated {
                tolerance,
                passes_max,
            } => self.passes(dt, tolerance, passes_max),
            Scheme::SemiImplicit => self.semi_implicit_step(dt),
            Scheme::Explicit => self.explicit_step(dt),
        }
    }

    /// S1 to S6: passes until the defect is at most `tolerance`.
    fn passes(
        &mut self,
        dt: f64,
        tolerance: f64,
        passes_max: u32,
    ) -> Result<Outcome, CouplerError> {
        let placement = self.place(dt)?;
        let porosity = self.porosity(&placement)?;
        let mut iteration = self.begin(&placement, porosity, dt)?;
        let mut pass = 1;
        loop {
            let mut outcome = self.pass(&mut iteration, &placement, dt, pass)?;
            let change = self.correction_change(&iteration, &placement, &outcome);
            let converged = outcome.defect.relative <= tolerance && change <= tolerance;
            self.log_pass(&iteration, &outcome, change);
            if converged {
                outcome.carried = carried_force(&outcome);
                return Ok(outcome);
            }
            if pass == passes_max {
                let (held, touching) = count_contacts(&outcome.grains.contact);
                return Err(CouplerError::NotConverged {
                    step: self.step + 1,
                    defect: outcome.defect.relative.max(change),
                    tolerance,
                    passes: pass,
                    held,
                    touching,
                    grains: self.grains.count(),
                });
            }
            self.next_iterate(&mut iteration, &placement, &outcome, dt, tolerance);
            pass += 1;
        }
    }

    /// The first model: from a contact solve with the old fluid fields where grains touch (S0).
    fn begin(
        &mut self,
        placement: &Placement,
        porosity: Vec<f64>,
        dt: f64,
    ) -> Result<Iteration, CouplerError> {
        let known = self.fluid_state.clone();
        let drag = self.drag_coefficients(placement, &porosity, Some(dt));
        let mut model = self.free_model(drag, dt, 1);
        let mut sub_steps = 0;
        // at the start nobody knows yet who touches
        let touching = self.grains.contact.iter().any(|&state| state >= TOUCHES);
        let predicted = touching || self.step == 0;
        if predicted {
            let force = self.grain_force(placement, &known, &model);
            let request = self.request(0, dt);
            let candidate = self.move_grains(&request, &model.drag, &force, 0)?;
            model = self.free_model(model.drag, dt, candidate.sub_steps);
            // where nothing touches, the new flow and not the old one decides how far grains move
            if candidate.contact.iter().any(|&state| state >= TOUCHES) {
                sub_steps = candidate.sub_steps;
            }
            self.choose_lambda(&mut model, &candidate.contact);
            explain(&mut model, &candidate, &force);
        } else {
            self.choose_lambda(&mut model, &[]);
        }
        let fields = self.matrix_fields(placement, &porosity, &model);
        Ok(Iteration {
            model,
            fields,
            known,
            sub_steps,
            predicted,
            raised: 0,
            anderson: None,
            smallest: f64::INFINITY,
            passes_without_progress: 0,
        })
    }

    /// S2 to S5 and the residual of S6.
    fn pass(
        &mut self,
        iteration: &mut Iteration,
        placement: &Placement,
        dt: f64,
        pass: u32,
    ) -> Result<Outcome, CouplerError> {
        let request = self.request(pass, dt);
        self.set_sources(iteration, placement);
        let fluid = self.solve_fluid(&request, Some(&iteration.fields))?;
        let force = self.grain_force(placement, &fluid, &iteration.model);
        let grains =
            self.move_grains(&request, &iteration.model.drag, &force, iteration.sub_steps)?;
        let modelled = iteration.model.velocity(&force);
        let residual: Vec<f64> = grains
            .mean_velocity
            .iter()
            .zip(&modelled)
            .map(|(v, m)| v - m)
            .collect();
        let defect = defect::measure(
            self,
            placement,
            &iteration.model,
            &force,
            &residual,
            &grains,
            dt,
        );
        Ok(Outcome {
            grains,
            placement: placement.clone(),
            model: iteration.model.clone(),
            fields: iteration.fields.clone(),
            force,
            residual,
            defect,
            passes: pass,
            lagged: self.lagged_force(iteration, placement, &fluid),
            carried: Vec::new(),
            fluid,
        })
    }

    fn lagged_force(
        &self,
        iteration: &Iteration,
        placement: &Placement,
        fluid: &FluidState,
    ) -> Vec<f64> {
        let (old, new) = (&iteration.known.pressure_gradient, &fluid.pressure_gradient);
        if self.takes_affine_response() {
            return vec![0.0; 2 * self.grains.count()];
        }
        let change: Vec<f64> = old.iter().zip(new).map(|(old, new)| old - new).collect();
        let mut force = self.transfer().sample_vector(placement, &change);
        for (k, value) in force.iter_mut().enumerate() {
            *value *= iteration.model.volume[k / 2] * iteration.model.follow(k / 2);
        }
        force
    }

    fn log_pass(&self, iteration: &Iteration, outcome: &Outcome, change: f64) {
        let (held, touching) = count_contacts(&outcome.grains.contact);
        let count = |value: f64| {
            iteration
                .model
                .lambda
                .iter()
                .filter(|&&lambda| lambda == value)
                .count()
        };
        tracing::debug!(
            step = self.step + 1,
            pass = outcome.passes,
            defect = outcome.defect.relative,
            change,
            held,
            touching,
            lambda_zero = count(0.0),
            lambda_half = count(0.5),
            sub_steps = outcome.grains.sub_steps,
            "pass"
        );
    }

    /// Change z (and, when it proved wrong, λ) for another pass.
    fn next_iterate(
        &self,
        iteration: &mut Iteration,
        placement: &Placement,
        outcome: &Outcome,
        dt: f64,
        tolerance: f64,
    ) {
        if outcome.defect.relative <= CONTRACTION * iteration.smallest {
            iteration.smallest = outcome.defect.relative;
            iteration.passes_without_progress = 0;
        } else {
            iteration.passes_without_progress += 1;
        }
        let contact = &outcome.grains.contact;
        let sub_steps_changed = iteration.sub_steps != outcome.grains.sub_steps;
        let new_lambda = if !iteration.predicted {
            // the first pass had no prediction: it is the prediction of the next
            iteration.predicted = true;
            self.choose_lambda(&mut iteration.model, contact);
            true
        } else if self.does_not_contract(iteration, outcome) {
            iteration.raised += 1;
            let wrong = |grain: usize| match iteration.raised {
                1 | 2 => outcome.defect.of_grains[grain] > WRONG * tolerance,
                _ => true,
            };
            let first = iteration.raised == 1;
            self.change_lambda(&mut iteration.model, |lambda, grain| {
                let (touches, held) = (contact[grain] >= TOUCHES, contact[grain] >= HELD);
                let suspect = lambda < 0.5 || (!first && touches);
                // let go by the wall it may move as one with those it touches
                let better = if first && !held { 1.0 } else { 0.5 };
                (suspect && wrong(grain)).then_some(better)
            })
        } else {
            false
        };
        if sub_steps_changed {
            iteration.sub_steps = outcome.grains.sub_steps;
            let lambda = std::mem::take(&mut iteration.model.lambda);
            iteration.model = self.free_model(
                std::mem::take(&mut iteration.model.drag),
                dt,
                iteration.sub_steps,
            );
            iteration.model.lambda = lambda;
        }
        if new_lambda || sub_steps_changed {
            explain(&mut iteration.model, &outcome.grains, &outcome.force);
            iteration.known = outcome.fluid.clone();
            iteration.anderson = None;
            iteration.passes_without_progress = 0;
            iteration.smallest = f64::INFINITY;
            let porosity = std::mem::take(&mut iteration.fields.porosity);
            iteration.fields = self.matrix_fields(placement, &porosity, &iteration.model);
        } else {
            self.accelerate(iteration, outcome, dt);
        }
    }

    /// The first pass with held grains (λ = 0 is right or wrong at once), then any lack of progress.
    fn does_not_contract(&self, iteration: &Iteration, outcome: &Outcome) -> bool {
        let movable_held =
            |(grain, &lambda): (usize, &f64)| lambda == 0.0 && !self.grains.fixed[grain];
        let held = iteration.model.lambda.iter().enumerate().any(movable_held);
        let first = iteration.raised == 0 && held;
        let grows = outcome.defect.relative > GROWTH_MAX * iteration.smallest;
        iteration.raised < 3 && (first || grows || iteration.passes_without_progress >= PATIENCE)
    }

    /// (z, w*, G*) ← Anderson of (v̄ − λ D q, w, G).
    fn accelerate(&self, iteration: &mut Iteration, outcome: &Outcome, dt: f64) {
        let parts = |model: &Model, known: &FluidState| -> Vec<f64> {
            [
                &model.free_velocity[..],
                &known.velocity,
                &known.pressure_gradient,
            ]
            .concat()
        };
        let x = parts(&iteration.model, &iteration.known);
        let mut image_model = iteration.model.clone();
        explain(&mut image_model, &outcome.grains, &outcome.force);
        let image = parts(&image_model, &outcome.fluid);
        let weights = || {
            self.anderson_weights(
                iteration.fields.drag.as_slice(),
                &iteration.fields.porosity,
                &iteration.model,
                dt,
            )
        };
        let mut anderson = iteration
            .anderson
            .take()
            .unwrap_or_else(|| Anderson::new(ANDERSON_DEPTH, weights()));
        let next = anderson.next(&x, &image);
        let (z, rest) = next.split_at(iteration.model.free_velocity.len());
        let (velocity, gradient) = rest.split_at(iteration.known.velocity.len());
        iteration.model.free_velocity.copy_from_slice(z);
        iteration.known.velocity.copy_from_slice(velocity);
        iteration.known.pressure_gradient.copy_from_slice(gradient);
        iteration.anderson = Some(anderson);
    }

    /// Weights that turn z, w* and G* into square roots of powers: √(γ + m/Δt), √(βℓ), (1−φ)√(ℓ/β).
    fn anderson_weights(
        &self,
        nodal_drag: &[f64],
        porosity: &[f64],
        model: &Model,
        dt: f64,
    ) -> Vec<f64> {
        let mass = self.transfer().nodal_mass();
        let largest = nodal_drag
            .iter()
            .fold(f64::MIN_POSITIVE, |max, &beta| max.max(beta));
        let drag = |node: usize| nodal_drag[node].max(1e-6 * largest);
        let grains = (0..self.grains.count())
            .flat_map(|i| [(model.drag[i] + self.grains.mass[i] / dt).sqrt(); 2]);
        let velocities = (0..mass.len()).flat_map(|a| [(drag(a) * mass[a]).sqrt(); 2]);
        let gradients = (0..mass.len())
            .flat_map(|a| [(1.0 - porosity[a]).abs() * (mass[a] / drag(a)).sqrt(); 2]);
        grains.chain(velocities).chain(gradients).collect()
    }

    /// λ by the contact state of a candidate (none: all free); fixed grains have 0.
    fn choose_lambda(&self, model: &mut Model, contact: &[f64]) {
        let told = self.tells_contacts();
        for (grain, lambda) in model.lambda.iter_mut().enumerate() {
            let is = |state: f64| contact.get(grain).is_some_and(|&own| own >= state);
            *lambda = if is(HELD) || self.grains.fixed[grain] {
                0.0
            } else if is(TOUCHES) && !told {
                0.5
            } else {
                self.options.lambda.unwrap_or(1.0)
            };
        }
    }

    /// A new λ for the grains chosen; says whether any changed.
    fn change_lambda(&self, model: &mut Model, better: impl Fn(f64, usize) -> Option<f64>) -> bool {
        let mut changed = false;
        for (grain, lambda) in model
            .lambda
            .iter_mut()
            .enumerate()
            .filter(|&(i, _)| !self.grains.fixed[i])
        {
            if let Some(value) = better(*lambda, grain) {
                changed |= *lambda != value;
                *lambda = value;
            }
        }
        changed
    }

    fn set_sources(&self, iteration: &mut Iteration, placement: &Placement) {
        let correction = self.correction(iteration, placement, &iteration.known);
        response::set_sources(
            self.transfer(),
            placement,
            &mut iteration.fields,
            &iteration.model,
            &correction,
            &self.grains.carried,
        );
    }

    fn correction(
        &self,
        iteration: &Iteration,
        placement: &Placement,
        known: &FluidState,
    ) -> (Vec<f64>, Vec<f64>) {
        if !self.options.deferred_correction {
            let zero = vec![0.0; 2 * self.transfer().node_count()];
            return (zero.clone(), zero);
        }
        response::deferred_correction(
            self.transfer(),
            placement,
            &iteration.fields,
            &iteration.model,
            known,
        )
    }

    /// How much the corrected force field moves if the pass just done becomes the known state,
    /// relative to the force scale of the grains.
    fn correction_change(
        &self,
        iteration: &Iteration,
        placement: &Placement,
        outcome: &Outcome,
    ) -> f64 {
        if outcome.passes == 1 && self.options.lagged_correction && self.takes_affine_response() {
            return 0.0; // lagged by a step, as for a free cloud
        }
        let before = self.correction(iteration, placement, &iteration.known).0;
        let after = self.correction(iteration, placement, &outcome.fluid).0;
        let change: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        defect::nodal_norm(self.transfer().nodal_mass(), &change) / outcome.defect.scale
    }

    fn matrix_fields(
        &self,
        placement: &Placement,
        porosity: &[f64],
        model: &Model,
    ) -> NodalResponse {
        let mut fields = response::matrix_fields(self.transfer(), placement, porosity, model);
        if !self.takes_affine_response() {
            fields.entrained_fraction.fill(0.0);
            fields.solid_mobility.fill(0.0);
        }
        fields
    }
}

/// z = v̄ − λ D q: the model then reproduces this candidate.
fn explain(model: &mut Model, candidate: &GrainCandidate, force: &[f64]) {
    for (k, force) in force.iter().enumerate() {
        model.free_velocity[k] =
            candidate.mean_velocity[k] - model.lambda[k / 2] * model.mobility[k / 2] * force;
    }
}

fn carried_force(outcome: &Outcome) -> Vec<f64> {
    let share = if outcome.defect.relative <= CARRY_MAX {
        1.0
    } else {
        0.0
    };
    outcome
        .residual
        .iter()
        .enumerate()
        .map(|(k, r)| share * outcome.model.drag[k / 2] * r + outcome.lagged[k])
        .collect()
}

/// Grains held by a wall, and other grains with an active contact.
pub fn count_contacts(contact: &[f64]) -> (usize, usize) {
    let held = contact.iter().filter(|&&state| state >= HELD).count();
    let touching = contact.iter().filter(|&&state| state >= TOUCHES).count() - held;
    (held, touching)
}

impl GrainState {
    /// Number of grains.
    pub fn count(&self) -> usize {
        self.mass.len()
    }
}
