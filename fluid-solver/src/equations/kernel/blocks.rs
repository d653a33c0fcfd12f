//! The blocks of a group with grains, from its sums.

use super::group::{GroupMatrix, GroupRight};
use super::lanes::{Lanes, dot, slope, sum};
use super::porous::Porous;
use super::sums::Sums;
use crate::equations::coefficients::Coefficients;

impl<const D: usize, const N: usize> Sums<D, N> {
    /// Θ_id, and Π.
    #[inline(always)]
    fn test_divergence(&self, at: &Porous<D, N>) -> ([[Lanes; D]; N], Lanes) {
        let divergence = dot(&at.porosity, &self.divergence);
        let mut theta = [[Lanes::ZERO; D]; N];
        for i in 0..N {
            for d in 0..D {
                theta[i][d] = at.group.gradient[i][d] * divergence
                    - at.slope[d] * self.divergence[i]
                    + self.test[i] * at.mixture_slope[d];
            }
        }
        (theta, divergence)
    }

    /// (K3).
    #[inline(always)]
    pub fn right(&self, at: &Porous<D, N>, right: &mut GroupRight<N>) {
        let (theta, _) = self.test_divergence(at);
        let gradient = &at.group.gradient;
        let first = at.group.volume * (1.0 / N as f64);
        let mut outflow = Lanes::ZERO;
        let mut carried = [Lanes::ZERO; D];
        for d in 0..D {
            outflow += slope(&at.flux[d], gradient)[d];
            carried[d] = sum(&at.flux[d]) * first + at.tau * self.force[d];
        }
        let squeeze = at.tau_c * outflow;
        for i in 0..N {
            for d in 0..D {
                right[i][d] = self.right[i][d] - theta[i][d] * squeeze;
            }
            right[i][D] = dot(&gradient[i], &carried);
        }
    }

    /// A_ij, A_i and A_0, and W_ij and V_i, all times μ.
    #[inline(always)]
    fn viscous(&self, at: &Porous<D, N>, viscosity: f64) -> Viscous<N> {
        let mut viscous = Viscous {
            pairs: [[Lanes::ZERO; N]; N],
            first: [Lanes::ZERO; N],
            whole: Lanes::ZERO,
            streamline: [[Lanes::ZERO; N]; N],
            upwind: [Lanes::ZERO; N],
        };
        for i in 0..N {
            for j in 0..N {
                viscous.pairs[i][j] = self.viscous[i.min(j)][i.max(j)] * viscosity;
                viscous.streamline[i][j] = self.streamline[i][j] * viscosity;
            }
            viscous.first[i] = dot(&at.porosity, &viscous.pairs[i]);
            viscous.upwind[i] = dot(&at.porosity, &viscous.streamline[i]);
        }
        viscous.whole = dot(&at.porosity, &viscous.first);
        viscous
    }

    /// (K2).
    #[inline(always)]
    pub fn matrix(
        &self,
        terms: &Coefficients<'_, D>,
        at: &Porous<D, N>,
        matrix: &mut GroupMatrix<N>,
    ) {
        let (theta, divergence) = self.test_divergence(at);
        let viscous = self.viscous(at, terms.dynamic_viscosity);
        let (gradient, s) = (&at.group.gradient, &at.slope);
        let (steep, mobility_slope) = (dot(s, s), slope(&at.mobility, gradient));
        let first = at.group.volume * (1.0 / N as f64);
        let spread = at.tau * self.square + sum(&at.mobility) * first;
        let relaxed = at.tau * terms.dynamic_viscosity;
        let mut turn = [Lanes::ZERO; N];
        for j in 0..N {
            turn[j] = dot(s, &gradient[j]);
        }
        for j in 0..N {
            let g = &gradient[j];
            let share = at.entrained_ratio[j] + 1.0;
            let leak = dot(&mobility_slope, g) * at.tau_c;
            let bend = divergence * turn[j] - self.divergence[j] * steep;
            let flux = at.tau * self.pushed_transport[j] + relaxed * bend
                - (share * first + at.tilt[j] * at.group.volume);
            let mut cross = [Lanes::ZERO; D];
            let mut squeeze = [Lanes::ZERO; D];
            for f in 0..D {
                cross[f] = (g[f] * divergence - s[f] * self.divergence[j]) * relaxed;
                squeeze[f] = g[f] * share * at.tau_c;
            }
            for i in 0..N {
                let (test, pair) = (&gradient[i], viscous.pairs[i][j]);
                let (upwind, streamline) = (viscous.upwind[i], viscous.streamline[i][j]);
                let gg = dot(test, g);
                let same = self.transport[i][j] + upwind * turn[j] - streamline * steep
                    + viscous.whole * gg
                    - viscous.first[i] * turn[j]
                    - viscous.first[j] * turn[i]
                    + pair * steep;
                let block = &mut matrix[i][j];
                for f in 0..D {
                    let along = viscous.whole * test[f] - viscous.first[i] * s[f];
                    let down = pair * s[f] - viscous.first[j] * test[f] + upwind * g[f]
                        - streamline * s[f];
                    for d in 0..D {
                        let entry = along * g[d] + down * s[d] + theta[i][d] * squeeze[f];
                        block[f][d] = if d == f { entry + same } else { entry };
                    }
                    block[f][D] = test[f] * flux + turn[i] * cross[f];
                    block[D][f] = self.push[i] * g[f] - theta[i][f] * leak;
                }
                block[D][D] = spread * gg;
            }
        }
    }
}

/// Viscous sums, times μ.
struct Viscous<const N: usize> {
    /// A_ij
    pairs: [[Lanes; N]; N],
    /// A_i
    first: [Lanes; N],
    /// A_0
    whole: Lanes,
    /// W_ij
    streamline: [[Lanes; N]; N],
    /// V_i
    upwind: [Lanes; N],
}
