//! The values of one simplex: what its corners say about flow and solid, and its τ.

use space::simplex::interpolate;
use space::vector::from_fn;
use space::{Dim, Dimension, Simplex, Vector, hypot};

use super::coefficients::{Carrier, Coefficients};
use super::held::{self, Weights};
use super::stabilization::{Scales, mean};
use crate::mesh::simplices::Mesh;

/// Most flows that can take part: two earlier steps and the iterate.
pub(super) const CARRIERS: usize = 3;

/// A vector field at the corners, component by component.
pub(super) type Components<const D: usize, const N: usize> = [[f64; N]; D];

/// Values of one simplex.
pub struct Element<'a, const D: usize, const N: usize> {
    pub(super) terms: &'a Coefficients<'a, D>,
    /// Geometry.
    pub simplex: &'a Simplex<D, N>,
    pub(super) corners: &'a [Vector<D>; N],
    pub(super) porosity: [f64; N],
    pub(super) entrained: [f64; N],
    pub(super) mobility: [f64; N],
    pub(super) drag: [f64; N],
    fixed_drag: [f64; N],
    pub(super) source: Components<D, N>,
    pub(super) flux: Components<D, N>,
    /// β_j/φ_j
    pub(super) drag_ratio: [f64; N],
    /// c_j/φ_j
    pub(super) entrained_ratio: [f64; N],
    pub(super) porosity_gradient: Vector<D>,
    pub(super) mixture_gradient: Vector<D>,
    pub(super) mobility_gradient: Vector<D>,
    pub(super) flux_divergence: f64,
    carriers: [(Components<D, N>, [f64; N]); CARRIERS],
    pub(super) weights: Weights<N>,
    pub(super) tau: f64,
    pub(super) tau_c: f64,
}

impl<'a, const D: usize, const N: usize> Element<'a, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Gather the values of simplex `t`.
    pub fn gather(terms: &'a Coefficients<'a, D>, mesh: &'a Mesh<D, N>, t: usize) -> Self {
        let nodes = mesh.simplices[t];
        let simplex = &mesh.geometry[t];
        let solid = &terms.solid.matrix;
        let scalar = |values: &[f64]| nodes.map(|n| values[n]);
        let vector = |values: &[Vector<D>]| components(&nodes, values);
        let porosity = scalar(&solid.porosity);
        let entrained = scalar(&solid.entrained_fraction);
        let drag = scalar(&solid.drag);
        let mobility = scalar(&solid.solid_mobility);
        let flux = vector(&terms.solid.solid_flux);
        let mut carriers = [([[0.0; N]; D], [1.0; N]); CARRIERS];
        for (slot, carrier) in carriers.iter_mut().zip(terms.carriers) {
            let flow = carrier.flow;
            *slot = (vector(&flow.superficial_velocity), scalar(&flow.porosity));
        }
        let porosity_gradient = simplex.gradient_of(&porosity);
        let entrained_gradient = simplex.gradient_of(&entrained);
        let mut element = Element {
            terms,
            simplex,
            corners: &mesh.corners[t],
            porosity,
            entrained,
            mobility,
            drag,
            fixed_drag: match solid.fixed_drag.is_empty() {
                true => [0.0; N],
                false => nodes.map(|n| solid.fixed_drag[n].min(solid.drag[n]).max(0.0)),
            },
            source: vector(&terms.solid.drag_source),
            flux,
            drag_ratio: std::array::from_fn(|k| drag[k] / porosity[k]),
            entrained_ratio: std::array::from_fn(|k| entrained[k] / porosity[k]),
            porosity_gradient,
            mixture_gradient: from_fn(|d| porosity_gradient[d] + entrained_gradient[d]),
            mobility_gradient: simplex.gradient_of(&mobility),
            flux_divergence: divergence(simplex, &flux),
            carriers,
            weights: Weights::none(&porosity),
            tau: 0.0,
            tau_c: 0.0,
        };
        element.stabilise();
        element
    }

    /// τ and τ_c from element means; the weights of held grains.
    fn stabilise(&mut self) {
        let terms = self.terms;
        let centre = [1.0 / N as f64; N];
        let porosity = mean(&self.porosity);
        let mut scales = Scales {
            rate: terms.rate,
            inertia: terms.density * porosity,
            viscosity: terms.dynamic_viscosity * porosity,
            drag: mean(&self.drag),
            relieved: 0.0,
            speed: hypot(&self.carried(&centre, |carrier| carrier.convects)),
            mixture: porosity + mean(&self.entrained),
            size: self.simplex.size(),
        };
        let carried = terms.density * terms.rate * mean(&self.mobility);
        let follows = (mean(&self.entrained) + carried).abs();
        let held = held::weights(
            &scales,
            follows,
            &self.drag,
            &self.fixed_drag,
            &self.porosity,
        );
        if let Some((weights, relieved)) = held {
            scales.relieved = relieved;
            self.weigh(weights);
        }
        self.tau = scales.momentum();
        self.tau_c = terms.grad_div * scales.continuity();
    }

    /// The weights of held grains, and the ∇P that belongs to them.
    fn weigh(&mut self, weights: Weights<N>) {
        self.weights = weights;
        let evened = self.weights.evened;
        let even = interpolate(&evened, &self.entrained);
        let own = std::array::from_fn(|j| self.entrained[j] * (1.0 - evened[j]));
        let own = self.simplex.gradient_of(&own);
        let (slope, sum) = (self.porosity_gradient, self.weights.porosity_sum);
        self.mixture_gradient = from_fn(|d| slope[d] * (1.0 + even / sum) + own[d]);
    }

    /// Σ weight_k v^k where the shape functions are `shape`.
    #[inline]
    pub(super) fn carried(
        &self,
        shape: &[f64; N],
        weight: impl Fn(&Carrier<'_, D>) -> f64,
    ) -> Vector<D> {
        let mut sum = Vector::zeros();
        for (carrier, (velocity, porosity)) in self.terms.carriers.iter().zip(&self.carriers) {
            let factor = weight(carrier);
            if factor != 0.0 {
                let factor = factor / interpolate(shape, porosity);
                for d in 0..D {
                    sum[d] += factor * interpolate(shape, &velocity[d]);
                }
            }
        }
        sum
    }

    /// ∂_f a_d of the one convecting flow.
    pub(super) fn convecting_gradient(&self, shape: &[f64; N], a: &Vector<D>) -> [Vector<D>; D] {
        let carriers = self.terms.carriers.iter();
        let mut convecting = carriers.zip(&self.carriers);
        let Some((_, (velocity, porosity))) =
            convecting.find(|(carrier, _)| carrier.convects != 0.0)
        else {
            return [Vector::zeros(); D];
        };
        let value = interpolate(shape, porosity);
        let slope = self.simplex.gradient_of(porosity);
        std::array::from_fn(|d| {
            let gradient = self.simplex.gradient_of(&velocity[d]);
            from_fn(|f| (gradient[f] - a[d] * slope[f]) / value)
        })
    }
}

/// The corner values of a vector field, component by component.
#[inline]
pub(crate) fn components<const D: usize, const N: usize>(
    nodes: &[usize; N],
    values: &[Vector<D>],
) -> Components<D, N> {
    std::array::from_fn(|d| nodes.map(|n| values[n][d]))
}

fn divergence<const D: usize, const N: usize>(
    simplex: &Simplex<D, N>,
    field: &Components<D, N>,
) -> f64
where
    Dim<D>: Dimension<D>,
{
    let mut sum = simplex.gradient_of(&field[0])[0];
    for d in 1..D {
        sum += simplex.gradient_of(&field[d])[d];
    }
    sum
}
