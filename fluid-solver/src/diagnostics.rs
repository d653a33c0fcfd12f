//! Numbers of a candidate: the energy identity, forces on boundaries, pressure drop.
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
//!   boundary       Σ x_i (Kx − r)_i over given unknowns − ∮ p Q_n + ∮ μφ v·(∇v)ᵀn (open)
//! ```
//!
//! φ v·∇p of the momentum and u·∇p of continuity cancel at every quadrature point. `boundary` is
//! the power of walls, inflow and outer pressure on the fluid; it is taken from the reactions, the
//! other terms from the fields: their balance `energy_defect` checks the whole assembly.

use rayon::prelude::*;

use crate::assembly::turn_back;
use crate::boundary::{Condition, Constraints};
use crate::element::EDGE_QUADRATURE;
use crate::mesh::Mesh;
use crate::momentum::dot;
use crate::point::{Coefficients, Element, Point, ViscousForm};

/// Triangles of a partial sum.
const PIECE: usize = 1024;

/// Names and values, in a fixed order.
pub type Numbers = Vec<(String, f64)>;

/// Numbers from names that are known at compile time.
pub(crate) fn named<const N: usize>(numbers: [(&str, f64); N]) -> Numbers {
    numbers
        .map(|(name, value)| (name.to_owned(), value))
        .to_vec()
}

/// A solution with what is needed to judge it.
pub struct Solved<'a> {
    /// The equations solved.
    pub terms: &'a Coefficients<'a>,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Its conditions.
    pub constraints: &'a Constraints,
    /// Superficial velocity \[m/s\].
    pub velocity: &'a [[f64; 2]],
    /// Pressure \[Pa\].
    pub pressure: &'a [f64],
    /// Unknowns as solved for.
    pub unknowns: &'a [f64],
    /// K x − r.
    pub reaction: &'a [f64],
    /// ∮ N_i Q_n by node \[m²/s\].
    pub flux: &'a [f64],
}

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

impl Solved<'_> {
    /// All terms of (E).
    pub fn powers(&self) -> Powers {
        let triangles: Vec<usize> = (0..self.mesh.triangles.len()).collect();
        // Partial sums of fixed pieces: the same bits on any number of threads.
        let parts: Vec<Powers> = triangles
            .par_chunks(PIECE)
            .map(|t| self.powers_in(t))
            .collect();
        let mut sum = parts
            .iter()
            .fold(Powers::default(), |sum, part| sum.plus(part));
        sum.boundary = self.boundary_power();
        sum
    }

    /// The terms that are integrals over these triangles.
    fn powers_in(&self, triangles: &[usize]) -> Powers {
        let mut sum = Powers::default();
        for &t in triangles {
            let element = Element::gather(self.terms, self.mesh, t);
            let nodes = self.mesh.triangles[t];
            let u = nodes.map(|n| self.velocity[n]);
            let pressure_gradient = element.shape.gradient_of(&nodes.map(|n| self.pressure[n]));
            for at in element.points() {
                add_powers(&at, &u, pressure_gradient, &mut sum);
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
            .iter()
            .zip(self.pressure)
            .map(|(q, p)| q * p)
            .sum();
        reactions - inflow + self.open_traction_power()
    }

    /// ∮ μφ v·(∇v)ᵀn over open edges.
    fn open_traction_power(&self) -> f64 {
        if self.terms.viscous_form != ViscousForm::Symmetric {
            return 0.0;
        }
        let mut sum = 0.0;
        for edge in &self.constraints.open_edges {
            let element = Element::gather(self.terms, self.mesh, edge.triangle);
            let u = self.mesh.triangles[edge.triangle].map(|n| self.velocity[n]);
            for (position, weight) in EDGE_QUADRATURE {
                let mut shape = [0.0; 3];
                shape[edge.corner[0]] = 1.0 - position;
                shape[edge.corner[1]] = position;
                let at = element.point(shape, weight * edge.length);
                let v = combine(&at.test, &u);
                let slope = gradient(&at.test_gradient, &u);
                for d in 0..2 {
                    let traction = slope[0][d] * edge.normal[0] + slope[1][d] * edge.normal[1];
                    sum += at.weight * at.viscosity * v[d] * traction;
                }
            }
        }
        sum
    }

    /// Force of the fluid on a boundary \[N/m\]: reactions of the momentum rows, weighted by φ_i
    /// because Σ φ_i X_i = 1, and the pressure, which is not integrated by parts.
    pub fn force_on(&self, boundary: usize) -> [f64; 2] {
        let porosity = &self.terms.solid.matrix.porosity;
        let edges = || {
            self.mesh
                .edges
                .iter()
                .filter(|edge| edge.boundary == boundary)
        };
        let mut nodes: Vec<usize> = edges().flat_map(|edge| edge.node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut force = [0.0; 2];
        for n in nodes {
            let turned = [self.reaction[3 * n], self.reaction[3 * n + 1]];
            let reaction = turn_back(self.constraints.frames[n], turned);
            force = [0, 1].map(|d| force[d] - porosity[n] * reaction[d]);
        }
        for edge in edges() {
            let mean = 0.5 * (self.pressure[edge.node[0]] + self.pressure[edge.node[1]]);
            force = [0, 1].map(|d| force[d] + edge.length * mean * edge.normal[d]);
        }
        force
    }

    /// Inflow \[m²/s\] and pressure drop from where it enters to the open boundary \[Pa\].
    pub fn inflow(&self) -> Numbers {
        let (mut inflow, mut pressure, mut length) = (0.0, 0.0, 0.0);
        for edge in &self.constraints.flux_edges {
            let mean = [0, 1]
                .map(|d| 0.5 * (self.velocity[edge.node[0]][d] + self.velocity[edge.node[1]][d]));
            let entering = -edge.length * dot(mean, edge.normal);
            if entering > 0.0 {
                inflow += entering;
                length += edge.length;
                pressure +=
                    0.5 * edge.length * (self.pressure[edge.node[0]] + self.pressure[edge.node[1]]);
            }
        }
        if inflow == 0.0 {
            return Vec::new();
        }
        let (mut outer, mut open) = (0.0, 0.0);
        for edge in &self.constraints.open_edges {
            open += edge.length;
            outer +=
                0.5 * edge.length * (self.pressure[edge.node[0]] + self.pressure[edge.node[1]]);
        }
        let mut numbers = named([("inflow", inflow)]);
        if open > 0.0 {
            numbers.push(("pressure_drop".to_owned(), pressure / length - outer / open));
        }
        numbers
    }

    /// Forces as diagnostics: `force_x_NAME` and `force_y_NAME` of walls and bodies \[N/m\].
    pub fn wall_forces(&self, forces: &[[f64; 2]]) -> Numbers {
        let mut numbers = Numbers::new();
        for (boundary, (name, force)) in self.mesh.boundary_names.iter().zip(forces).enumerate() {
            let wall = matches!(
                self.constraints.condition(boundary),
                Condition::NoSlip | Condition::Slip
            );
            if wall && self.mesh.edges.iter().any(|edge| edge.boundary == boundary) {
                numbers.push((format!("force_x_{name}"), force[0]));
                numbers.push((format!("force_y_{name}"), force[1]));
            }
        }
        numbers
    }
}

/// Add the powers at one quadrature point.
fn add_powers(at: &Point, u: &[[f64; 2]; 3], slope_p: [f64; 2], sum: &mut Powers) {
    let v = combine(&at.test, u);
    let slope = gradient(&at.test_gradient, u);
    let drag = combine(&at.drag, u);
    let transport = combine(&at.transport, u);
    let entrained = combine(&[0, 1, 2].map(|j| at.flux[j] - at.shape[j]), u);
    let streamline = combine(&at.streamline, u);
    let w = at.weight;

    sum.kinetic_energy += 0.5 * w * at.inertia * dot(v, v);
    sum.gravity += w * dot(v, at.weight_force);
    sum.source += w * dot(v, at.body);
    let mut coupling = dot(v, at.source) - dot(v, drag) - at.entrained * dot(v, slope_p);
    coupling += dot(entrained, slope_p) + dot(at.solid_flux, slope_p);
    sum.solid += w * (coupling - at.mobility * dot(slope_p, slope_p));

    let mut residual = [0.0; 2];
    for d in 0..2 {
        sum.inertia += w * v[d] * (transport[d] - drag[d] - at.carried[d]);
        sum.viscous +=
            w * (at.viscosity * dot(slope[d], slope[d]) + 2.0 * v[d] * dot(at.literal, slope[d]));
        if at.symmetric {
            sum.viscous +=
                w * at.viscosity * (slope[d][0] * slope[0][d] + slope[d][1] * slope[1][d]);
        }
        residual[d] = at.mixture * slope_p[d] - at.force[d];
        for (strong, u) in at.strong.iter().zip(u) {
            residual[d] += dot(strong[d], *u);
        }
    }
    let (mut squeeze, mut outflow) = (
        0.0,
        at.solid_divergence - dot(at.mobility_gradient, slope_p),
    );
    for (j, u) in u.iter().enumerate() {
        squeeze += dot(at.test_divergence[j], *u);
        outflow += dot(at.flux_gradient[j], *u);
    }
    let relaxed = at.tau * at.mixture * dot(slope_p, residual);
    sum.stabilisation += w * (dot(streamline, residual) + relaxed + at.tau_c * squeeze * outflow);
}

/// Σ weight_j u_j
fn combine(weight: &[f64; 3], u: &[[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|d| (0..3).map(|j| weight[j] * u[j][d]).sum())
}

/// ∂_f v_d as \[d\]\[f\]
fn gradient(slope: &[[f64; 2]; 3], u: &[[f64; 2]; 3]) -> [[f64; 2]; 2] {
    [0, 1].map(|d| [0, 1].map(|f| (0..3).map(|j| u[j][d] * slope[j][f]).sum()))
}
