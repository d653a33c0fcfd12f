//! The sums (K1) over the quadrature points of a group with grains.

use space::quadrature;

use super::lanes::{Lanes, dot, interpolate};
use super::porous::Porous;
use crate::equations::coefficients::Coefficients;
use crate::equations::stabilization::Real;

/// (K1)
pub struct Sums<const D: usize, const N: usize> {
    /// D_ij
    pub transport: [[Lanes; N]; N],
    /// A_ij, where i ≤ j
    pub viscous: [[Lanes; N]; N],
    /// W_ij
    pub streamline: [[Lanes; N]; N],
    /// U_i
    pub push: [Lanes; N],
    /// Λ_j
    pub pushed_transport: [Lanes; N],
    /// Π_i
    pub divergence: [Lanes; N],
    /// Ξ_i
    pub test: [Lanes; N],
    /// Σ
    pub square: Lanes,
    /// Σ_q w(X_i + st_i) F_d
    pub right: [[Lanes; D]; N],
    /// Σ_q wP F_d
    pub force: [Lanes; D],
}

impl<const D: usize, const N: usize> Sums<D, N> {
    /// Those of a group; what only the matrix needs stays 0 unless that is wanted.
    #[inline(always)]
    pub fn new<const MATRIX: bool>(terms: &Coefficients<'_, D>, at: &Porous<D, N>) -> Sums<D, N> {
        let mut sums = Sums::none();
        for (shape, weight) in quadrature::points::<N>() {
            sums.add_point::<MATRIX>(terms, at, &shape, weight);
        }
        sums
    }

    #[inline(always)]
    fn none() -> Sums<D, N> {
        let (zero, zeros) = ([Lanes::ZERO; N], [[Lanes::ZERO; N]; N]);
        Sums {
            transport: zeros,
            viscous: zeros,
            streamline: zeros,
            push: zero,
            pushed_transport: zero,
            divergence: zero,
            test: zero,
            square: Lanes::ZERO,
            right: [[Lanes::ZERO; D]; N],
            force: [Lanes::ZERO; D],
        }
    }

    /// (K1) at one quadrature point.
    #[inline(always)]
    fn add_point<const MATRIX: bool>(
        &mut self,
        terms: &Coefficients<'_, D>,
        at: &Porous<D, N>,
        shape: &[f64; N],
        weight: f64,
    ) {
        let porosity = interpolate(shape, &at.porosity);
        let spread = at.spread(shape, porosity);
        let (w, inverse) = (at.group.volume * weight, porosity.recip());
        let mixture = porosity + dot(&spread, &at.entrained);
        let [a, history] = at.carried(terms, shape);
        let along = dot(&a, &at.slope);
        let upwind = at.tau * terms.density;
        let (pushed, pushed_inverse) = (w * mixture, w * mixture * inverse);
        let mut test = [Lanes::ZERO; N];
        let mut convection = [Lanes::ZERO; N];
        let mut streamline = [Lanes::ZERO; N];
        let mut weighted = [Lanes::ZERO; N];
        for i in 0..N {
            test[i] = inverse * shape[i];
            convection[i] = dot(&a, &at.group.gradient[i]) - test[i] * along;
            streamline[i] = w * (upwind * convection[i] + at.tilt[i] * inverse);
            weighted[i] = w * test[i] + streamline[i];
            self.test[i] += w * test[i];
            self.divergence[i] += pushed_inverse * test[i];
        }
        for d in 0..D {
            let inertia = porosity * terms.density * (history[d] + terms.gravity[d]);
            let force = inertia + dot(&spread, &at.source[d]);
            self.force[d] += pushed * force;
            for i in 0..N {
                self.right[i][d] += weighted[i] * force;
            }
        }
        if !MATRIX {
            return;
        }
        self.square += pushed * mixture;
        let mass = terms.density * terms.rate;
        for j in 0..N {
            let drag = spread[j] * at.drag_ratio[j];
            let transport = convection[j] * terms.density + drag + mass * shape[j];
            let trial = test[j] * inverse;
            self.pushed_transport[j] += pushed * transport;
            self.push[j] += weighted[j] * mixture;
            for i in 0..N {
                self.transport[i][j] += weighted[i] * transport;
                self.streamline[i][j] += streamline[i] * trial;
                if i <= j {
                    self.viscous[i][j] += w * test[i] * trial;
                }
            }
        }
    }
}
