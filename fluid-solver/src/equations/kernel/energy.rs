//! The terms of the energy identity in groups; `diagnostics::powers` says what they are.
//!
//! With v = u_h/φ, ∇v = (∇u − v sᵀ)/φ and b = Σ_j b_j u_j:
//!
//! ```text
//!   Σ_j S_j u_j = ρφ(α/Δt v + a·∇v) + b + μ(∇v s + s ∇·v)                                        (K6)
//! ```

use space::{Vector, quadrature};

use super::group::Group;
use super::lanes::{LANES, Lanes, dot, interpolate, slope};
use super::porous::Porous;
use crate::equations::coefficients::Coefficients;
use crate::equations::stabilization::Real;

/// Integrals over some simplices; names as in `diagnostics::powers`.
#[derive(Debug, Clone, Copy)]
pub struct Energy {
    /// ½∫ρφ|v|²
    pub kinetic: f64,
    /// Rate of change of momentum times v.
    pub inertia: f64,
    /// Viscous dissipation.
    pub viscous: f64,
    /// Power of gravity.
    pub gravity: f64,
    /// Power of the solid on the fluid.
    pub solid: f64,
    /// Loss to the stabilisation.
    pub stabilisation: f64,
}

/// The solution at the corners of a group.
pub struct Solution<const D: usize, const N: usize> {
    pub(super) velocity: [[Lanes; N]; D],
    pub(super) pressure_slope: [Lanes; D],
}

impl<const D: usize, const N: usize> Solution<D, N> {
    /// Gather it.
    #[inline(always)]
    pub fn gather(
        group: &Group<D, N>,
        velocity: &[Vector<D>],
        pressure: &[f64],
        driving: &Vector<D>,
    ) -> Solution<D, N> {
        let mut at = [[Lanes::ZERO; N]; D];
        let mut p = [Lanes::ZERO; N];
        for i in 0..N {
            for l in 0..LANES {
                let node = group.nodes[l][i];
                p[i].0[l] = pressure[node];
                for d in 0..D {
                    at[d][i].0[l] = velocity[node][d];
                }
            }
        }
        let mut pressure_slope = slope(&p, &group.gradient);
        for d in 0..D {
            pressure_slope[d] = pressure_slope[d] + driving[d];
        }
        Solution {
            velocity: at,
            pressure_slope,
        }
    }
}

/// [`Energy`], lane by lane.
#[derive(Clone, Copy)]
pub struct Rates {
    pub(super) kinetic: Lanes,
    pub(super) inertia: Lanes,
    pub(super) viscous: Lanes,
    pub(super) gravity: Lanes,
    pub(super) solid: Lanes,
    pub(super) stabilisation: Lanes,
}

/// What is the same at all points of a group.
struct Constant<const D: usize> {
    /// ∂_f u_d
    velocity_slope: [[Lanes; D]; D],
    /// Σ d_j u_j
    tilted: [Lanes; D],
    /// ∇·(u + j⁰ + (cv)_h − κ∇p)
    outflow: Lanes,
}

impl<const D: usize> Constant<D> {
    #[inline(always)]
    fn new<const N: usize>(at: &Porous<D, N>, solved: &Solution<D, N>) -> Constant<D> {
        let gradient = &at.group.gradient;
        let leak = dot(&slope(&at.mobility, gradient), &solved.pressure_slope);
        let mut constant = Constant {
            velocity_slope: [[Lanes::ZERO; D]; D],
            tilted: [Lanes::ZERO; D],
            outflow: Lanes::ZERO - leak,
        };
        for d in 0..D {
            let velocity = &solved.velocity[d];
            constant.velocity_slope[d] = slope(velocity, gradient);
            constant.tilted[d] = dot(&at.tilt, velocity);
            constant.outflow += slope(&at.flux[d], gradient)[d];
            for j in 0..N {
                let share = at.entrained_ratio[j] + 1.0;
                constant.outflow += gradient[j][d] * share * velocity[j];
            }
        }
        constant
    }
}

impl Rates {
    /// No simplices.
    pub const NONE: Rates = Rates {
        kinetic: Lanes::ZERO,
        inertia: Lanes::ZERO,
        viscous: Lanes::ZERO,
        gravity: Lanes::ZERO,
        solid: Lanes::ZERO,
        stabilisation: Lanes::ZERO,
    };

    /// Those of a group.
    #[inline(always)]
    pub fn of<const D: usize, const N: usize>(
        terms: &Coefficients<'_, D>,
        at: &Porous<D, N>,
        solved: &Solution<D, N>,
    ) -> Rates {
        let constant = Constant::new(at, solved);
        let mut rates = Rates::NONE;
        for (shape, weight) in quadrature::points::<N>() {
            rates.add_point(terms, at, solved, &constant, &shape, weight);
        }
        rates
    }

    #[inline(always)]
    fn add_point<const D: usize, const N: usize>(
        &mut self,
        terms: &Coefficients<'_, D>,
        at: &Porous<D, N>,
        solved: &Solution<D, N>,
        constant: &Constant<D>,
        shape: &[f64; N],
        weight: f64,
    ) {
        let porosity = interpolate(shape, &at.porosity);
        let spread = at.spread(shape, porosity);
        let (w, inverse) = (at.group.volume * weight, porosity.recip());
        let entrained = dot(&spread, &at.entrained);
        let mixture = porosity + entrained;
        let (inertia, viscosity) = (porosity * terms.density, porosity * terms.dynamic_viscosity);
        let [a, history] = at.carried(terms, shape);
        let grad_p = &solved.pressure_slope;
        let mut v = [Lanes::ZERO; D];
        let mut grad_v = [[Lanes::ZERO; D]; D];
        let mut divergence = Lanes::ZERO;
        for d in 0..D {
            v[d] = interpolate(shape, &solved.velocity[d]) * inverse;
            for f in 0..D {
                grad_v[d][f] = (constant.velocity_slope[d][f] - v[d] * at.slope[f]) * inverse;
            }
            divergence += grad_v[d][d];
        }
        let squeeze = mixture * divergence + dot(&v, &at.mixture_slope);
        let relaxed = at.tau * mixture;
        let (mut tested, mut dissipation) = (Lanes::ZERO, Lanes::ZERO);
        let (mut coupling, mut change) = (Lanes::ZERO, Lanes::ZERO);
        for d in 0..D {
            let u = &solved.velocity[d];
            let along = dot(&a, &grad_v[d]);
            let (mut drag, mut carried) = (Lanes::ZERO, Lanes::ZERO);
            for j in 0..N {
                drag += spread[j] * at.drag_ratio[j] * u[j];
                carried += at.entrained_ratio[j] * u[j] * shape[j];
            }
            let source = dot(&spread, &at.source[d]);
            let rate = inertia * (v[d] * terms.rate + along);
            let bend = dot(&at.slope, &grad_v[d]) + at.slope[d] * divergence;
            let force = inertia * (history[d] + terms.gravity[d]) + source;
            let strong = rate + drag + bend * terms.dynamic_viscosity;
            let residual = mixture * grad_p[d] - force + strong;
            let streamline = at.tau * inertia * along + constant.tilted[d] * inverse;
            tested += streamline * residual + relaxed * grad_p[d] * residual;
            tested += Lanes::ZERO - constant.tilted[d] * grad_p[d];
            change += v[d] * (rate - inertia * history[d]);
            let flux = interpolate(shape, &at.flux[d]);
            coupling += v[d] * (source - drag) + (carried - entrained * v[d] + flux) * grad_p[d];
            for f in 0..D {
                dissipation += grad_v[d][f] * (grad_v[d][f] + grad_v[f][d]);
            }
            self.gravity += w * inertia * v[d] * terms.gravity[d];
        }
        let leak = interpolate(shape, &at.mobility) * dot(grad_p, grad_p);
        self.kinetic += w * inertia * dot(&v, &v) * 0.5;
        self.inertia += w * change;
        self.viscous += w * viscosity * dissipation;
        self.solid += w * (coupling - leak);
        self.stabilisation += w * (tested + at.tau_c * squeeze * constant.outflow);
    }

    /// Add the first `filled` lanes of those of a group.
    #[inline(always)]
    pub fn add(&mut self, group: &Rates, filled: usize) {
        for l in 0..filled {
            self.kinetic.0[l] += group.kinetic.0[l];
            self.inertia.0[l] += group.inertia.0[l];
            self.viscous.0[l] += group.viscous.0[l];
            self.gravity.0[l] += group.gravity.0[l];
            self.solid.0[l] += group.solid.0[l];
            self.stabilisation.0[l] += group.stabilisation.0[l];
        }
    }

    /// The sums over the lanes.
    pub fn energy(&self) -> Energy {
        let sum = |lanes: &Lanes| lanes.0.iter().sum();
        Energy {
            kinetic: sum(&self.kinetic),
            inertia: sum(&self.inertia),
            viscous: sum(&self.viscous),
            gravity: sum(&self.gravity),
            solid: sum(&self.solid),
            stabilisation: sum(&self.stabilisation),
        }
    }
}
