//! Where held grains drag differently at the corners of a simplex.
//!
//! The mean of the drag over a simplex carries action = reaction; its fluctuation is free. As it stands
//! it is a force on nodes that nothing balances, and makes a flow that grows like β. With bars for means
//! over the N corners, b0 of `stabilization` (S3) and \[x\] for x bounded to 0…1,
//!
//! ```text
//!   d_i = ϑ/N [(β_i + b0) Σ_k φ_k / Σ_k φ_k(β_k + b0) − 1]          Σ φ_i d_i = 0         (H1)
//!   f_j = ϑ [1 − min(1, (β_min + b0)/β_j)]
//!   M_j = N_j + f_j [φ/(Nφ¯) − N_j]                                                       (H2)
//!   ϑ   = [((F1 S − F)/((F1 − F0) S)] · [(β_max − β_min)/b0 − 1]                          (H3)
//!   F   = c¯ + ρα/Δt κ¯,   S = 1 − φ¯
//! ```
//!
//! M_j stands for N_j in b_j, s and the c of P; momentum is tested with d_i/φ beside X_i, and unknown j
//! adds d_j to the flux of mass: a free node of a simplex with held ones gets nothing of their drag,
//! their pressure and their flux. Integrals of b_j, s and c, hydrostatic rest and uniform motion are
//! those of the nodal products (P1).
//!
//! F/S is near 0 where all grains are held; where they follow the fluid it is about λ or more, however
//! short the step is. ϑ = 0 leaves every bit as it is: in suspensions, and where β is uniform or small.

use space::simplex::interpolate;
use space::vector::from_fn;
use space::{Dim, Dimension};

use super::element::{Element, mean};
use super::stabilization::Scales;

/// F/S up to which (H1) and (H2) are there whole.
const FOLLOWS_MIN: f64 = 0.01;
/// F/S from which on they are not there.
const FOLLOWS_MAX: f64 = 0.02;

/// The weights of one simplex.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights<const N: usize> {
    /// d_j
    pub tilt: [f64; N],
    /// f_j
    pub evened: [f64; N],
    /// Nφ¯
    pub porosity_sum: f64,
}

impl<const N: usize> Weights<N> {
    /// Those of nodal products.
    pub fn none(porosity: &[f64; N]) -> Weights<N> {
        Weights {
            tilt: [0.0; N],
            evened: [0.0; N],
            porosity_sum: N as f64 * mean(porosity),
        }
    }

    /// M_j at a point. (H2)
    #[inline]
    pub fn spread(&self, shape: &[f64; N], porosity: f64) -> [f64; N] {
        let even = porosity / self.porosity_sum;
        std::array::from_fn(|j| shape[j] + self.evened[j] * (even - shape[j]))
    }
}

impl<const D: usize, const N: usize> Element<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// ϑ of (H3).
    pub(super) fn held(&self, scales: &Scales) -> f64 {
        let most = self.drag.iter().fold(0.0, |most: f64, &b| most.max(b));
        let uneven = (most - scales.least_drag) / scales.other_than_drag() - 1.0;
        let uneven = uneven.clamp(0.0, 1.0);
        let carried = self.terms.density * self.terms.rate * mean(&self.mobility);
        let follows = (mean(&self.entrained) + carried).abs();
        if uneven == 0.0 || follows == 0.0 {
            return uneven;
        }
        let part = follows / (1.0 - mean(&self.porosity)).max(follows);
        uneven * ((FOLLOWS_MAX - part) / (FOLLOWS_MAX - FOLLOWS_MIN)).clamp(0.0, 1.0) // (H3)
    }

    /// d_j and f_j, and ∇P that belongs to them.
    pub(super) fn weigh(&mut self, scales: &Scales) {
        let other = scales.other_than_drag();
        let kept = scales.least_drag + other;
        let whole = interpolate(&self.porosity, &self.drag.map(|b| b + other));
        let sum = self.weights.porosity_sum;
        for j in 0..N {
            let share = (self.drag[j] + other) * sum / whole;
            self.weights.tilt[j] = scales.held * (share - 1.0) / N as f64; // (H1)
            if self.drag[j] > kept {
                self.weights.evened[j] = scales.held * (1.0 - kept / self.drag[j]);
            }
        }
        let evened = self.weights.evened;
        let even = interpolate(&evened, &self.entrained);
        let own = std::array::from_fn(|j| self.entrained[j] * (1.0 - evened[j]));
        let own = self.simplex.gradient_of(&own);
        let slope = self.porosity_gradient;
        self.mixture_gradient = from_fn(|d| slope[d] * (1.0 + even / sum) + own[d]);
    }
}
