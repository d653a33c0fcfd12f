//! From pass to pass: z, λ, and the fluid fields at which the correction is taken.

use space::{Dim, Dimension, Vector, flat};

use crate::coupled::anderson::Anderson;
use crate::coupled::lambda::{Policy, Progress, Shown};
use crate::coupled::outcome::Pass;
use crate::coupled::response::Model;
use crate::coupled::setting::{Deferred, Setting};
use crate::state::{Flow, Response};
use crate::transfer::quantity::nodal_norm;

const ANDERSON_DEPTH: usize = 10;
/// Nodal drag counts as at least this part of its largest value in the weights of the acceleration.
const SMALLEST_DRAG: f64 = 1e-6;

/// What a pass is made with.
#[derive(Debug)]
pub struct Iterate<const D: usize> {
    /// The affine model of the grains.
    pub model: Model<D>,
    /// What the fluid is given.
    pub response: Response<D>,
    /// w* and G* of the deferred correction.
    pub reference: Flow<D>,
    /// Sub-steps asked of the grains; 0: theirs to choose.
    pub sub_steps: u32,
    /// λ over the passes.
    pub progress: Progress,
    anderson: Option<Anderson>,
}

impl<const D: usize> Iterate<D>
where
    Dim<D>: Dimension<D>,
{
    /// The first one; `predicted`: the model comes from a contact solve.
    pub fn new<const N: usize>(
        setting: &Setting<'_, D, N>,
        porosity: Vec<f64>,
        model: Model<D>,
        reference: Flow<D>,
        sub_steps: u32,
        predicted: bool,
    ) -> Iterate<D> {
        Iterate {
            response: setting.matrix_response(porosity, &model),
            model,
            reference,
            sub_steps,
            progress: Progress::new(predicted),
            anderson: None,
        }
    }

    /// s and j⁰ of z, w* and G*, and of what the last step owes.
    pub fn set_sources<const N: usize>(&mut self, setting: &Setting<'_, D, N>) {
        let correction = setting.correction(&self.model, &self.response, &self.reference);
        self.response.set_sources(
            &setting.immersion.transfer,
            setting.placement,
            &self.model,
            &correction,
            &setting.grains.carried_force,
        );
    }

    /// How much the corrected force field moves if the fluid fields of pass number `number` become w*
    /// and G*, relative to the force scale of the grains.
    pub fn correction_change<const N: usize>(
        &self,
        setting: &Setting<'_, D, N>,
        pass: &Pass<D>,
        number: u32,
    ) -> f64 {
        if number == 1 && setting.deferred == Deferred::Lagged {
            return 0.0;
        }
        let before = setting
            .correction(&self.model, &self.response, &self.reference)
            .force;
        let after = setting
            .correction(&self.model, &self.response, &pass.flow)
            .force;
        let change: Vec<Vector<D>> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        nodal_norm(setting.immersion.transfer.nodal_mass(), &change) / pass.defect.scale
    }

    /// Change z (and, where it proved wrong, λ) for another pass.
    pub fn improve<const N: usize>(
        &mut self,
        setting: &Setting<'_, D, N>,
        policy: &Policy,
        pass: &Pass<D>,
        tolerance: f64,
    ) {
        let shown = Shown {
            defect: &pass.defect,
            contact: &pass.grains.contact,
            fixed: &setting.grains.fixed,
            tolerance,
        };
        let new_lambda = self.progress.revise(policy, &mut self.model.lambda, &shown);
        let new_sub_steps = self.sub_steps != pass.grains.sub_steps;
        if new_sub_steps {
            self.sub_steps = pass.grains.sub_steps;
            let lambda = std::mem::take(&mut self.model.lambda);
            let drag = std::mem::take(&mut self.model.drag);
            self.model = setting.free_model(drag, self.sub_steps);
            self.model.lambda = lambda;
        }
        if new_lambda || new_sub_steps {
            self.begin_anew(setting, pass);
        } else {
            self.accelerate(setting, pass);
        }
    }

    /// A new matrix, from this pass on.
    fn begin_anew<const N: usize>(&mut self, setting: &Setting<'_, D, N>, pass: &Pass<D>) {
        self.model.calibrate(&pass.grains, &pass.force);
        self.reference = pass.flow.clone();
        self.anderson = None;
        self.progress.restart();
        let porosity = std::mem::take(&mut self.response.porosity);
        self.response = setting.matrix_response(porosity, &self.model);
    }

    /// (z, w*, G*) ← Anderson of (v̄ − λ D q, w, G).
    fn accelerate<const N: usize>(&mut self, setting: &Setting<'_, D, N>, pass: &Pass<D>) {
        let here = concatenated(&self.model.free_velocity, &self.reference);
        self.model.calibrate(&pass.grains, &pass.force);
        let image = concatenated(&self.model.free_velocity, &pass.flow);
        let mut anderson = match self.anderson.take() {
            Some(anderson) => anderson,
            None => Anderson::new(ANDERSON_DEPTH, self.weights(setting)),
        };
        let next = anderson.next(&here, &image);
        self.anderson = Some(anderson);
        let mut rest = next.as_slice();
        for part in [
            &mut self.model.free_velocity,
            &mut self.reference.velocity,
            &mut self.reference.pressure_gradient,
        ] {
            let (own, others) = rest.split_at(D * part.len());
            flat::numbers_mut(part).copy_from_slice(own);
            rest = others;
        }
    }

    /// Weights that turn z, w* and G* into square roots of powers: √(γ + m/Δt), √(βℓ), (1−φ)√(ℓ/β).
    fn weights<const N: usize>(&self, setting: &Setting<'_, D, N>) -> Vec<f64> {
        let mass = setting.immersion.transfer.nodal_mass();
        let (nodal_drag, porosity) = (&self.response.drag, &self.response.porosity);
        let largest = nodal_drag
            .iter()
            .fold(f64::MIN_POSITIVE, |max, &beta| max.max(beta));
        let drag = |node: usize| nodal_drag[node].max(SMALLEST_DRAG * largest);
        let inertia = |i: usize| setting.grains.mass[i] / setting.dt;
        let grains = (0..setting.grains.count()).map(|i| (self.model.drag[i] + inertia(i)).sqrt());
        let velocities = (0..mass.len()).map(|a| (drag(a) * mass[a]).sqrt());
        let gradients =
            (0..mass.len()).map(|a| (1.0 - porosity[a]).abs() * (mass[a] / drag(a)).sqrt());
        let of_vectors = grains.chain(velocities).chain(gradients);
        of_vectors.flat_map(|weight| [weight; D]).collect()
    }
}

/// z, w and G as one list of numbers.
fn concatenated<const D: usize>(free_velocity: &[Vector<D>], flow: &Flow<D>) -> Vec<f64> {
    [
        flat::numbers(free_velocity),
        flat::numbers(&flow.velocity),
        flat::numbers(&flow.pressure_gradient),
    ]
    .concat()
}
