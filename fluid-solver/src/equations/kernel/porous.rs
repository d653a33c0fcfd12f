//! Fluid among grains: the values at the corners of a group, and between them.

use super::group::Group;
use super::lanes::{LANES, Lanes, dot, interpolate, slope, sum};
use super::records::Records;
use crate::equations::coefficients::Coefficients;
use crate::equations::element::CARRIERS;
use crate::equations::held;
use crate::equations::stabilization::{Real, Scales};

/// A vector field at the corners, component by component.
type Components<const D: usize, const N: usize> = [[Lanes; N]; D];

/// What a group with grains is made of.
pub struct Porous<const D: usize, const N: usize> {
    /// Corners and geometry.
    pub group: Group<D, N>,
    /// φ
    pub porosity: [Lanes; N],
    /// c
    pub entrained: [Lanes; N],
    /// e_j/N_j = c_j/φ_j
    pub entrained_ratio: [Lanes; N],
    /// κ
    pub mobility: [Lanes; N],
    drag: [Lanes; N],
    /// β_j/φ_j
    pub drag_ratio: [Lanes; N],
    fixed_drag: [Lanes; N],
    /// s
    pub source: Components<D, N>,
    /// j⁰
    pub flux: Components<D, N>,
    known: [(Components<D, N>, [Lanes; N]); CARRIERS],
    /// s = ∇φ
    pub slope: [Lanes; D],
    /// ∇P
    pub mixture_slope: [Lanes; D],
    /// Are there weights of held grains?
    held: bool,
    /// d_j
    pub tilt: [Lanes; N],
    evened: [Lanes; N],
    /// τ
    pub tau: Lanes,
    /// τ_c
    pub tau_c: Lanes,
}

impl<const D: usize, const N: usize> Porous<D, N> {
    /// Gather a group.
    #[inline(always)]
    pub fn gather(
        terms: &Coefficients<'_, D>,
        records: &Records<D>,
        group: Group<D, N>,
    ) -> Porous<D, N> {
        let zero = [Lanes::ZERO; N];
        let mut porous = Porous {
            group,
            porosity: zero,
            entrained: zero,
            entrained_ratio: zero,
            mobility: zero,
            drag: zero,
            drag_ratio: zero,
            fixed_drag: zero,
            source: [zero; D],
            flux: [zero; D],
            known: [([zero; D], zero); CARRIERS],
            slope: [Lanes::ZERO; D],
            mixture_slope: [Lanes::ZERO; D],
            held: false,
            tilt: zero,
            evened: zero,
            tau: Lanes::ZERO,
            tau_c: Lanes::ZERO,
        };
        porous.load(terms, records);
        porous.slope = slope(&porous.porosity, &porous.group.gradient);
        let entrained = slope(&porous.entrained, &porous.group.gradient);
        for d in 0..D {
            porous.mixture_slope[d] = porous.slope[d] + entrained[d];
        }
        porous.stabilise(terms);
        porous
    }

    #[inline(always)]
    fn load(&mut self, terms: &Coefficients<'_, D>, records: &Records<D>) {
        let flows = terms.carriers.len();
        for i in 0..N {
            for l in 0..LANES {
                let node = self.group.nodes[l][i];
                let grains = &records.grains[node];
                self.porosity[i].0[l] = grains.porosity;
                self.entrained[i].0[l] = grains.entrained;
                self.entrained_ratio[i].0[l] = grains.entrained_ratio;
                self.mobility[i].0[l] = grains.mobility;
                self.drag[i].0[l] = grains.drag;
                self.drag_ratio[i].0[l] = grains.drag_ratio;
                self.fixed_drag[i].0[l] = grains.fixed_drag;
                for d in 0..D {
                    self.source[d][i].0[l] = grains.source[d];
                    self.flux[d][i].0[l] = grains.flux[d];
                }
                let known = &records.known[flows * node..flows * (node + 1)];
                for k in 0..flows {
                    let (velocity, porosity) = &mut self.known[k];
                    porosity[i].0[l] = known[k].porosity;
                    for d in 0..D {
                        velocity[d][i].0[l] = known[k].velocity[d];
                    }
                }
            }
        }
    }

    /// τ and τ_c from means over the corners; the weights of held grains.
    #[inline(always)]
    fn stabilise(&mut self, terms: &Coefficients<'_, D>) {
        let share = 1.0 / N as f64;
        let porosity = sum(&self.porosity) * share;
        let entrained = sum(&self.entrained) * share;
        let mut convecting = [Lanes::ZERO; D];
        for k in 0..terms.carriers.len() {
            let (velocity, porosity) = &self.known[k];
            let factor = sum(porosity).recip() * terms.carriers[k].convects;
            for d in 0..D {
                convecting[d] += factor * sum(&velocity[d]);
            }
        }
        let mut scales = Scales {
            rate: terms.rate,
            inertia: porosity * terms.density,
            viscosity: porosity * terms.dynamic_viscosity,
            drag: sum(&self.drag) * share,
            relieved: Lanes::ZERO,
            speed: dot(&convecting, &convecting).sqrt(),
            mixture: porosity + entrained,
            size: self.group.size,
        };
        let carried = sum(&self.mobility) * (share * terms.density * terms.rate);
        self.weigh(&mut scales, entrained + carried);
        self.tau = scales.momentum();
        self.tau_c = scales.continuity() * terms.grad_div;
    }

    /// The weights of held grains in the lanes that have any, and the ∇P that belongs to them.
    #[inline(always)]
    fn weigh(&mut self, scales: &mut Scales<Lanes>, follows: Lanes) {
        let other = scales.other_than_drag();
        let (drag, fixed) = (range(&self.drag), range(&self.fixed_drag));
        for l in 0..LANES {
            if drag.0[l] > other.0[l] || fixed.0[l] > other.0[l] {
                self.weigh_lane(scales, follows.0[l].abs(), l);
            }
        }
        if !self.held {
            return;
        }
        let mut even = Lanes::ZERO;
        let mut own = [Lanes::ZERO; N];
        for j in 0..N {
            let evened = self.evened[j] * self.entrained[j];
            even += evened;
            own[j] = self.entrained[j] - evened;
        }
        let own = slope(&own, &self.group.gradient);
        let share = even / sum(&self.porosity) + 1.0;
        for d in 0..D {
            self.mixture_slope[d] = self.slope[d] * share + own[d];
        }
    }

    #[inline(never)]
    fn weigh_lane(&mut self, scales: &mut Scales<Lanes>, follows: f64, l: usize) {
        let lane = |values: &[Lanes; N]| values.map(|value| value.0[l]);
        let (drag, fixed) = (lane(&self.drag), lane(&self.fixed_drag));
        let own = scales.map(|value| value.0[l]);
        let Some((weights, relieved)) =
            held::weights(&own, follows, &drag, &fixed, &lane(&self.porosity))
        else {
            return;
        };
        self.held = true;
        scales.relieved.0[l] = relieved;
        for j in 0..N {
            self.tilt[j].0[l] = weights.tilt[j];
            self.evened[j].0[l] = weights.evened[j];
        }
    }

    /// a and Σ η_k v^k at a point.
    #[inline(always)]
    pub fn carried(&self, terms: &Coefficients<'_, D>, shape: &[f64; N]) -> [[Lanes; D]; 2] {
        let mut sums = [[Lanes::ZERO; D]; 2];
        for k in 0..terms.carriers.len() {
            let (velocity, porosity) = &self.known[k];
            let inverse = interpolate(shape, porosity).recip();
            for d in 0..D {
                let v = interpolate(shape, &velocity[d]) * inverse;
                sums[0][d] += v * terms.carriers[k].convects;
                sums[1][d] += v * terms.carriers[k].history;
            }
        }
        sums
    }

    /// M_j (H2).
    #[inline(always)]
    pub fn spread(&self, shape: &[f64; N], porosity: Lanes) -> [Lanes; N] {
        let mut spread = [Lanes::ZERO; N];
        for j in 0..N {
            spread[j] = Lanes([shape[j]; LANES]);
        }
        if self.held {
            let even = porosity / sum(&self.porosity);
            for j in 0..N {
                spread[j] = spread[j] + self.evened[j] * (even - spread[j]);
            }
        }
        spread
    }
}

/// The largest less the smallest.
#[inline(always)]
fn range<const N: usize>(values: &[Lanes; N]) -> Lanes {
    let (mut most, mut least) = (values[0], values[0]);
    for k in 1..N {
        most = most.max(values[k]);
        least = least.min(values[k]);
    }
    most - least
}
