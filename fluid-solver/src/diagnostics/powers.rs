//! The energy identity.
//!
//! Testing the discrete momentum equation with v (coefficients u_j, because X_j = N_j/φ) and the
//! discrete continuity equation with p gives, term by term and to round-off,
//!
//! ```text
//!   gravity + solid + source + boundary = inertia + viscous + stabilisation              (E)
//!
//!   inertia        ∫ ρφ v·(∂_t v + a·∇v)                      rate of the discrete time derivative
//!   viscous        ∫ 2μφ |D(v)|²  ≥ 0                         (literal form: μφ|∇v|² + 2μ v·(∇φ·∇)v)
//!   gravity        ∫ φρ g·v
//!   solid          ∫ v·s − v·(βv)_h − c v·∇p + (cv)_h·∇p + j⁰·∇p − κ|∇p|²
//!   source         ∫ v·f
//!   stabilisation  ∫ τρφ(a·∇v)·R + τP∇p·R + τ_c ∇·(P v) ∇·(u + j⁰ + (cv)_h − κ∇p)
//!                  + Σ_i d_i u_i·(R/φ − ∇p)                     (held grains, (H1))
//!   boundary       Σ x_i (Kx − r)_i over given unknowns − ∮ p Q_n + ∮ μφ v·(∇v)ᵀn (open)
//!                  − ∮ ½ρφ (a·n)₋ |v|² (open, where it flows in) − G·U|Ω| (mean flow)
//! ```
//!
//! φ v·∇p of the momentum and u·∇p of continuity cancel at every quadrature point. `boundary` is
//! the power of walls, inflow and outer pressure on the fluid; it is taken from the reactions, the
//! other terms from the fields: their balance `energy_defect` checks the whole assembly.

use std::ops::Range;

use rayon::prelude::*;
use space::simplex::combine;
use space::vector::from_fn;
use space::{Dim, Dimension, Vector, dot, quadrature};

use super::solved::Solved;
use crate::equations::coefficients::ViscousForm;
use crate::equations::element::Element;
use crate::equations::kernel::{Kernel, LANES};
use crate::equations::open;
use crate::equations::point::Point;
use crate::numbers::{Numbers, named};

/// Groups of simplices of a partial sum.
const PIECE: usize = 256;

/// The terms of (E), per metre of depth \[W/m\], and the kinetic energy \[J/m\].
#[derive(Debug, Clone, Copy, Default)]
pub struct Powers {
    /// ½∫ρφ|v|²
    pub kinetic_energy: f64,
    /// Rate of change of momentum times v.
    pub inertia: f64,
    /// Viscous dissipation.
    pub viscous: f64,
    /// Power of gravity.
    pub gravity: f64,
    /// Power of the solid on the fluid.
    pub solid: f64,
    /// Power of the body force.
    pub source: f64,
    /// Loss to the stabilisation.
    pub stabilisation: f64,
    /// Power through the boundary.
    pub boundary: f64,
}

impl Powers {
    /// Left minus right side of (E) \[W/m\].
    pub fn defect(&self) -> f64 {
        self.gravity + self.solid + self.source + self.boundary
            - (self.inertia + self.viscous + self.stabilisation)
    }

    /// Term by term.
    fn plus(&self, other: &Powers) -> Powers {
        Powers {
            kinetic_energy: self.kinetic_energy + other.kinetic_energy,
            inertia: self.inertia + other.inertia,
            viscous: self.viscous + other.viscous,
            gravity: self.gravity + other.gravity,
            solid: self.solid + other.solid,
            source: self.source + other.source,
            stabilisation: self.stabilisation + other.stabilisation,
            boundary: self.boundary + other.boundary,
        }
    }

    /// As diagnostics.
    pub fn numbers(&self) -> Numbers {
        named([
            ("kinetic_energy", self.kinetic_energy),
            ("gravity_power", self.gravity),
            ("viscous_power", self.viscous),
            ("boundary_power", self.boundary),
            ("stabilisation_power", self.stabilisation),
            ("inertia_power", self.inertia),
            ("solid_power", self.solid),
            ("source_power", self.source),
            ("energy_defect", self.defect()),
        ])
    }

    /// Sum of the magnitudes of the terms of (E) \[W/m\].
    pub fn scale(&self) -> f64 {
        let gains = self.gravity.abs() + self.solid.abs() + self.source.abs() + self.boundary.abs();
        gains + self.inertia.abs() + self.viscous.abs() + self.stabilisation.abs()
    }
}

impl<const D: usize, const N: usize> Solved<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// All terms of (E).
    pub fn powers(&self) -> Powers {
        let kernel = Kernel::new(self.terms, self.mesh);
        let groups = self.mesh.simplices.len().div_ceil(LANES);
        let pieces = (0..groups.div_ceil(PIECE)).into_par_iter();
        // Partial sums of fixed pieces: the same bits on any number of threads.
        let parts: Vec<Powers> = pieces
            .map(|piece| {
                let piece = piece * PIECE..groups.min((piece + 1) * PIECE);
                match &kernel {
                    Some(kernel) => self.powers_of(kernel, piece),
                    None => self.powers_in(piece),
                }
            })
            .collect();
        let mut sum = parts
            .iter()
            .fold(Powers::default(), |sum, part| sum.plus(part));
        sum.boundary = self.boundary_power();
        sum
    }

    /// The terms that are integrals over these groups.
    fn powers_of(&self, kernel: &Kernel<'_, D, N>, groups: Range<usize>) -> Powers {
        let energy = kernel.energy(groups, self.velocity, self.pressure, &self.driving);
        Powers {
            kinetic_energy: energy.kinetic,
            inertia: energy.inertia,
            viscous: energy.viscous,
            gravity: energy.gravity,
            solid: energy.solid,
            source: 0.0,
            stabilisation: energy.stabilisation,
            boundary: 0.0,
        }
    }

    /// The same, simplex by simplex, with all that the equations may have.
    fn powers_in(&self, groups: Range<usize>) -> Powers {
        let mut sum = Powers::default();
        let end = self.mesh.simplices.len().min(groups.end * LANES);
        for t in groups.start * LANES..end {
            let element = Element::gather(self.terms, self.mesh, t);
            let nodes = self.mesh.simplices[t];
            let u = nodes.map(|n| self.velocity[n]);
            let pressure_gradient = element
                .simplex
                .gradient_of(&nodes.map(|n| self.pressure[n]));
            let pressure_gradient = pressure_gradient + self.driving;
            for at in element.points() {
                add_powers(&at, &u, &pressure_gradient, &mut sum);
            }
        }
        sum
    }

    fn boundary_power(&self) -> f64 {
        let given = self
            .constraints
            .fixed
            .iter()
            .zip(self.unknowns)
            .zip(self.reaction);
        let reactions: f64 = given
            .filter(|((fixed, _), _)| **fixed)
            .map(|((_, x), r)| x * r)
            .sum();
        let inflow: f64 = self
            .flux
            .of_node
            .iter()
            .zip(self.pressure)
            .map(|(q, p)| q * p)
            .sum();
        reactions - inflow + self.open_power() - self.driving_power()
    }

    /// G·U|Ω| of what steers the mean flow.
    fn driving_power(&self) -> f64 {
        let size = || -> f64 { self.mesh.geometry.iter().map(|s| s.volume).sum() };
        self.drive
            .map_or(0.0, |drive| dot(&self.driving, &drive.velocity) * size())
    }

    /// ∮ μφ v·(∇v)ᵀn − ½ρφ (a·n)₋ |v|² over open facets.
    fn open_power(&self) -> f64 {
        let mut sum = 0.0;
        for facet in &self.constraints.open_facets {
            let element = Element::gather(self.terms, self.mesh, facet.simplex);
            let u = self.mesh.simplices[facet.simplex].map(|n| self.velocity[n]);
            if open::flows_in(&element, facet) {
                sum -= open::inflow_power(&element, facet, &u);
            }
            if self.terms.viscous_form != ViscousForm::Symmetric {
                continue;
            }
            for (on_facet, weight) in quadrature::points::<D>() {
                let at = element.point(facet.shape(&on_facet), weight * facet.size);
                let v = combine(&at.test, &u);
                let slope = gradient(&at.test_gradient, &u);
                for d in 0..D {
                    let traction = dot(&from_fn(|f| slope[f][d]), &facet.normal);
                    sum += at.weight * at.viscosity * v[d] * traction;
                }
            }
        }
        sum
    }
}

/// Add the powers at one quadrature point.
fn add_powers<const D: usize, const N: usize>(
    at: &Point<D, N>,
    u: &[Vector<D>; N],
    slope_p: &Vector<D>,
    sum: &mut Powers,
) {
    let v = combine(&at.test, u);
    let slope = gradient(&at.test_gradient, u);
    let drag = combine(&at.drag, u);
    let transport = combine(&at.transport, u);
    let entrained = combine(
        &std::array::from_fn(|j| at.flux[j] - at.shape[j] - at.tilt[j]),
        u,
    );
    let streamline = combine(&at.streamline, u);
    let tilted = combine(&at.tilt, u);
    let w = at.weight;

    sum.kinetic_energy += 0.5 * w * at.inertia * dot(&v, &v);
    sum.gravity += w * dot(&v, &at.weight_force);
    sum.source += w * dot(&v, &at.body);
    let mut coupling = dot(&v, &at.source) - dot(&v, &drag) - at.entrained * dot(&v, slope_p);
    coupling += dot(&entrained, slope_p) + dot(&at.solid_flux, slope_p);
    sum.solid += w * (coupling - at.mobility * dot(slope_p, slope_p));

    let mut residual = Vector::<D>::zeros();
    for d in 0..D {
        sum.inertia += w * v[d] * (transport[d] - drag[d] - at.carried[d]);
        sum.viscous += w
            * (at.viscosity * dot(&slope[d], &slope[d]) + 2.0 * v[d] * dot(&at.literal, &slope[d]));
        if at.symmetric {
            sum.viscous += w * at.viscosity * dot(&slope[d], &from_fn(|f| slope[f][d]));
        }
        residual[d] = at.mixture * slope_p[d] - at.force[d];
        for (strong, u) in at.strong.iter().zip(u) {
            residual[d] += dot(&strong[d], u);
        }
    }
    let (mut squeeze, mut outflow) = (
        0.0,
        at.solid_divergence - dot(&at.mobility_gradient, slope_p),
    );
    for (j, u) in u.iter().enumerate() {
        squeeze += dot(&at.test_divergence[j], u);
        outflow += dot(&at.flux_gradient[j], u);
    }
    let relaxed = at.tau * at.mixture * dot(slope_p, &residual);
    let tested = dot(&streamline, &residual) + relaxed - dot(&tilted, slope_p);
    sum.stabilisation += w * (tested + at.tau_c * squeeze * outflow);
}

/// ∂_f v_d as \[d\]\[f\]
fn gradient<const D: usize, const N: usize>(
    slope: &[Vector<D>; N],
    u: &[Vector<D>; N],
) -> [Vector<D>; D] {
    std::array::from_fn(|d| from_fn(|f| (0..N).map(|j| u[j][d] * slope[j][f]).sum()))
}
