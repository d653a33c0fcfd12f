//! Clear fluid: φ = 1 and no grains at any corner of a group.
//!
//! All integrands are polynomials of degree 2 at most, so sums over corners are exact:
//!
//! ```text
//!   ∫N_i = V/N,   ∫N_iN_j = V/(N(N+1)) (1 + δ_ij),   m_i = ∫N_i a,   Q = ∫a aᵀ
//!
//!   u_d,u_f  δ_df [ρ(α/Δt ∫N_iN_j + m_i·g_j) + τρ²(α/Δt m_j·g_i + g_i·Q g_j) + μV g_i·g_j]
//!            + μV g_if g_jd + τ_c V g_id g_jf                                                  (K4)
//!   u_d,p    (V/N + τρ ∫a·g_i) g_jd
//!   p,u_f    τρ(α/Δt V/N + ∫a·g_j) g_if − V/N g_if
//!   p,p      τV g_i·g_j
//!   right    ∫N_i F_d + τρ g_i·∫a F_d,   τ g_i·∫F                                              (K5)
//! ```
//!
//! The integral of the product of two linear fields x, y is V/(N(N+1)) (Σx_i y_i + Σx_i Σy_i); the terms of the energy
//! identity are such products.

use super::energy::{Rates, Solution};
use super::group::{Group, GroupMatrix, GroupRight};
use super::lanes::{LANES, Lanes, dot, slope, sum};
use super::records::Records;
use crate::equations::coefficients::Coefficients;
use crate::equations::stabilization::{Real, Scales};

/// What a group in clear fluid is made of.
pub struct ClearFluid<const D: usize, const N: usize> {
    group: Group<D, N>,
    /// a at the corners
    convecting: [[Lanes; D]; N],
    /// Σ η_k v^k at the corners
    history: [[Lanes; D]; N],
    /// Σ_i a
    convecting_sum: [Lanes; D],
    /// Σ_i of the history
    history_sum: [Lanes; D],
    tau: Lanes,
    tau_c: Lanes,
}

impl<const D: usize, const N: usize> ClearFluid<D, N> {
    /// Gather a group.
    #[inline(always)]
    pub fn gather(
        terms: &Coefficients<'_, D>,
        records: &Records<D>,
        group: Group<D, N>,
    ) -> ClearFluid<D, N> {
        let mut clear = ClearFluid {
            group,
            convecting: [[Lanes::ZERO; D]; N],
            history: [[Lanes::ZERO; D]; N],
            convecting_sum: [Lanes::ZERO; D],
            history_sum: [Lanes::ZERO; D],
            tau: Lanes::ZERO,
            tau_c: Lanes::ZERO,
        };
        for i in 0..N {
            for l in 0..LANES {
                let record = &records.clear[clear.group.nodes[l][i]];
                for d in 0..D {
                    clear.convecting[i][d].0[l] = record.convecting[d];
                    clear.history[i][d].0[l] = record.history[d];
                }
            }
            for d in 0..D {
                clear.convecting_sum[d] += clear.convecting[i][d];
                clear.history_sum[d] += clear.history[i][d];
            }
        }
        let sum = &clear.convecting_sum;
        let scales = Scales {
            rate: terms.rate,
            inertia: Lanes([terms.density; LANES]),
            viscosity: Lanes([terms.dynamic_viscosity; LANES]),
            drag: Lanes::ZERO,
            relieved: Lanes::ZERO,
            speed: dot(sum, sum).sqrt() * (1.0 / N as f64),
            mixture: Lanes([1.0; LANES]),
            size: clear.group.size,
        };
        clear.tau = scales.momentum();
        clear.tau_c = scales.continuity() * terms.grad_div;
        clear
    }

    /// V/N and V/(N(N+1)).
    #[inline(always)]
    fn shares(&self) -> (Lanes, Lanes) {
        let volume = self.group.volume;
        let (first, second) = (1.0 / N as f64, 1.0 / (N * (N + 1)) as f64);
        (volume * first, volume * second)
    }

    /// (K5).
    #[inline(always)]
    pub fn right(&self, terms: &Coefficients<'_, D>, right: &mut GroupRight<N>) {
        let (first, second) = self.shares();
        let (a, h) = (&self.convecting_sum, &self.history_sum);
        let upwind = self.tau * terms.density;
        // ∫F/ρ and τρ ∫a_e F_d
        let mut force = [Lanes::ZERO; D];
        let mut along = [[Lanes::ZERO; D]; D];
        for d in 0..D {
            force[d] = first * (h[d] + N as f64 * terms.gravity[d]);
            for e in 0..D {
                let mut products = a[e] * h[d];
                for i in 0..N {
                    products += self.convecting[i][e] * self.history[i][d];
                }
                let weight = first * a[e] * terms.gravity[d];
                along[d][e] = (second * products + weight) * upwind * terms.density;
            }
        }
        for i in 0..N {
            let gradient = &self.group.gradient[i];
            for d in 0..D {
                let history = second * (self.history[i][d] + h[d]);
                let own = (history + first * terms.gravity[d]) * terms.density;
                right[i][d] = own + dot(gradient, &along[d]);
            }
            right[i][D] = dot(gradient, &force) * upwind;
        }
    }

    /// (K4).
    #[inline(always)]
    pub fn matrix(&self, terms: &Coefficients<'_, D>, matrix: &mut GroupMatrix<N>) {
        let (first, second) = self.shares();
        let (a, volume) = (&self.convecting_sum, self.group.volume);
        let gradient = &self.group.gradient;
        let mut moment = [[Lanes::ZERO; D]; N];
        let mut square = [[Lanes::ZERO; D]; D];
        for d in 0..D {
            for i in 0..N {
                moment[i][d] = second * (self.convecting[i][d] + a[d]);
            }
            for e in 0..D {
                let mut products = a[d] * a[e];
                for i in 0..N {
                    products += self.convecting[i][d] * self.convecting[i][e];
                }
                square[d][e] = second * products;
            }
        }
        let (diffusion, squeeze) = (volume * terms.dynamic_viscosity, self.tau_c * volume);
        let (upwind, relaxed) = (self.tau * terms.density, self.tau * volume);
        let mass = second * (terms.density * terms.rate);
        for j in 0..N {
            let g = &gradient[j];
            let transport = (dot(a, g) + terms.rate) * upwind;
            let flux = first * transport - first;
            let mut streamline = [Lanes::ZERO; D];
            for d in 0..D {
                let transported = moment[j][d] * terms.rate + dot(&square[d], g);
                streamline[d] = transported * upwind * terms.density;
            }
            for i in 0..N {
                let test = &gradient[i];
                let block = &mut matrix[i][j];
                let gg = dot(test, g);
                let convection = dot(&moment[i], g) * terms.density;
                let mut same = mass + convection + dot(test, &streamline) + diffusion * gg;
                if i == j {
                    same += mass;
                }
                let push = first * (dot(a, test) * upwind + 1.0);
                for f in 0..D {
                    for d in 0..D {
                        let entry = diffusion * test[f] * g[d] + squeeze * test[d] * g[f];
                        block[f][d] = if d == f { entry + same } else { entry };
                    }
                    block[f][D] = test[f] * flux;
                    block[D][f] = push * g[f];
                }
                block[D][D] = relaxed * gg;
            }
        }
    }

    /// The terms of the energy identity.
    #[inline(always)]
    pub fn rates(&self, terms: &Coefficients<'_, D>, solved: &Solution<D, N>) -> Rates {
        let (first, second) = self.shares();
        let (density, volume) = (terms.density, self.group.volume);
        let product = |x: &[Lanes; N], y: &[Lanes; N]| second * (dot(x, y) + sum(x) * sum(y));
        let grad_p = &solved.pressure_slope;
        let grad_v: [[Lanes; D]; D] = (solved.velocity).map(|v| slope(&v, &self.group.gradient));
        let mut rates = Rates::NONE;
        let (mut divergence, mut dissipation) = (Lanes::ZERO, Lanes::ZERO);
        let mut tested = Lanes::ZERO;
        for d in 0..D {
            let v = &solved.velocity[d];
            let (mut change, mut streamline, mut residual) = ([Lanes::ZERO; N], *v, *v);
            for i in 0..N {
                let along = dot(&self.convecting[i], &grad_v[d]) * density;
                let history = self.history[i][d] * density;
                change[i] = v[i] * (terms.rate * density) + along - history;
                streamline[i] = along + grad_p[d];
                residual[i] = change[i] + grad_p[d] - Lanes([density * terms.gravity[d]; LANES]);
            }
            rates.kinetic += product(v, v) * (0.5 * density);
            rates.inertia += product(v, &change);
            rates.gravity += first * sum(v) * (density * terms.gravity[d]);
            tested += product(&streamline, &residual);
            divergence += grad_v[d][d];
            for f in 0..D {
                dissipation += grad_v[d][f] * (grad_v[d][f] + grad_v[f][d]);
            }
        }
        rates.viscous = volume * dissipation * terms.dynamic_viscosity;
        let squeezed = self.tau_c * volume * divergence * divergence;
        rates.stabilisation = self.tau * tested + squeezed;
        rates
    }
}
