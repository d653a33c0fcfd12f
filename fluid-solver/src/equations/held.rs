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
//!   ϑ   = [(F1 S − F)/((F1 − F0) S)] · [(β_max − β_min)/b0 − 1]                           (H3)
//!   F   = c¯ + ρα/Δt κ¯,   S = 1 − φ¯
//! ```
//!
//! M_j stands for N_j in b_j, s and the c of P; momentum is tested with d_i/φ beside X_i, and unknown j
//! adds d_j to the flux of mass: a free node of a simplex with held ones gets nothing of their drag,
//! their pressure and their flux. Integrals of b_j, s and c, hydrostatic rest and uniform motion are
//! those of the nodal products (P1).
//!
//! F/S is near 0 where all grains are held; where they follow the fluid it is about λ or more, however
//! short the step is. There the same weights with the drag β^f of fixed grains for β stand in, by 1 less the
//! last factor of ϑ: what flows between fixed grains changes nothing, and who is fixed does not depend on the
//! pass. ϑ = 0 leaves every bit as it is: in suspensions, and where β is uniform or small.

use space::simplex::interpolate;

use super::stabilization::{Scales, mean};

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

    /// Add d_j and f_j of what of the drag is held so.
    fn add(&mut self, scales: &Scales<f64>, held: &Held<N>, drag: &[f64; N], porosity: &[f64; N]) {
        if held.part == 0.0 {
            return;
        }
        let other = scales.other_than_drag();
        let kept = held.least + other;
        let whole = interpolate(porosity, &held.drag.map(|b| b + other));
        for (j, &own) in held.drag.iter().enumerate() {
            let share = (own + other) * self.porosity_sum / whole;
            self.tilt[j] += held.part * (share - 1.0) / N as f64; // (H1)
            if own > kept {
                self.evened[j] += held.part * (1.0 - kept / own) * (own / drag[j]);
            }
        }
    }

    /// M_j at a point. (H2)
    #[inline]
    pub fn spread(&self, shape: &[f64; N], porosity: f64) -> [f64; N] {
        let even = porosity / self.porosity_sum;
        std::array::from_fn(|j| shape[j] + self.evened[j] * (even - shape[j]))
    }
}

/// The weights of a simplex with this drag and that of fixed grains at its corners, and what of the drag τ_c
/// leaves out (S2); none where nothing is held so. `follows` is F of (H3).
pub(super) fn weights<const N: usize>(
    scales: &Scales<f64>,
    follows: f64,
    drag: &[f64; N],
    fixed: &[f64; N],
    porosity: &[f64; N],
) -> Option<(Weights<N>, f64)> {
    let all = all_held(follows, 1.0 - mean(porosity));
    let held =
        [(all, drag), (1.0 - all, fixed)].map(|(share, drag)| Held::new(scales, share, *drag));
    if held.iter().all(|held| held.part == 0.0) {
        return None;
    }
    let mut weights = Weights::none(porosity);
    for held in &held {
        weights.add(scales, held, drag, porosity);
    }
    Some((weights, held[0].excess(scales) + held[1].excess(scales)))
}

/// Drag at the corners that counts as held.
#[derive(Debug, Clone, Copy)]
struct Held<const N: usize> {
    drag: [f64; N],
    least: f64,
    /// ϑ
    part: f64,
}

impl<const N: usize> Held<N> {
    /// `share` of this drag, as far as it is uneven. (H3)
    fn new(scales: &Scales<f64>, share: f64, drag: [f64; N]) -> Held<N> {
        let least = drag.iter().fold(f64::INFINITY, |least, &b| least.min(b));
        let most = drag.iter().fold(0.0, |most: f64, &b| most.max(b));
        let uneven = match share > 0.0 && most > least {
            true => (most - least) / scales.other_than_drag() - 1.0,
            false => 0.0,
        };
        Held {
            part: share * uneven.clamp(0.0, 1.0),
            drag,
            least,
        }
    }

    /// What of the mean drag τ_c leaves out. (S2)
    fn excess(&self, scales: &Scales<f64>) -> f64 {
        let bound = scales.viscous_bound(self.least);
        self.part * (mean(&self.drag) - bound).max(0.0)
    }
}

/// The share of a simplex whose grains are all held: the first factor of ϑ, with F and S. (H3)
fn all_held(follows: f64, solid: f64) -> f64 {
    if follows == 0.0 {
        return 1.0;
    }
    let part = follows / solid.max(follows);
    ((FOLLOWS_MAX - part) / (FOLLOWS_MAX - FOLLOWS_MIN)).clamp(0.0, 1.0)
}
