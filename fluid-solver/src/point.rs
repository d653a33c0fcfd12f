//! Everything the equations need at one quadrature point of one triangle.
//!
//! Unknowns are the nodal superficial velocity u_j and pressure p_j; velocities are the quotient
//! v = u_h/φ_h, so the trial and test function of node j is X_j = N_j/φ and
//!
//! ```text
//!   ∇X_j = (∇N_j − X_j ∇φ)/φ
//!   b_j  = N_j β_j/φ_j,   e_j = N_j c_j/φ_j          nodal products, never β_h v_h        (P1)
//!   D_t v_j = α/Δt X_j + a·∇X_j
//!   S_j,df  = [ρφ D_t v_j + b_j + μ(∇φ·∇N_j/φ − N_j|∇φ|²/φ²)] δ_df
//!           + μ(∂_fN_j ∂_dφ/φ − N_j ∂_dφ ∂_fφ/φ²) + ρφ ∂_f a_d X_j (Newton)               (P2)
//!   F       = ρφ(g + Σ_k η_k v^k) + s + f                                                 (P3)
//! ```
//!
//! S_j,df is component d of the strong momentum operator applied to unknown f of node j; the
//! residual is R = S u + P∇p − F with P = φ + c. Only nodal products keep action equal to
//! reaction, because the coupler samples exactly v_α = u_α/φ_α. The second line of (P2) belongs to
//! the symmetric viscous form alone.

use crate::element::{QUADRATURE, Triangle, interpolate};
use crate::mesh::Mesh;
use crate::stabilization::Scales;
use crate::state::{Flow, Solid};

/// Form of the viscous term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViscousForm {
    /// −∇·(2μφ D(v)): Galilean invariant.
    Symmetric,
    /// −∇·(μφ∇v) − μ v ∇²φ: the paper's three terms as printed.
    PaperLiteral,
}

/// A body force f(x, t) per mixture volume \[N/m³\].
pub type BodyForce = dyn Fn([f64; 2], f64) -> [f64; 2] + Send + Sync;

/// Coefficients of the equations that do not change within an assembly.
pub struct Coefficients<'a> {
    /// ρ \[kg/m³\].
    pub density: f64,
    /// μ \[Pa s\].
    pub dynamic_viscosity: f64,
    /// g \[m/s²\].
    pub gravity: [f64; 2],
    /// Form of the viscous term.
    pub viscous_form: ViscousForm,
    /// Factor θ of the grad-div stabilisation.
    pub grad_div: f64,
    /// α/Δt \[1/s\]; 0 when steady.
    pub rate: f64,
    /// Is the convective term differentiated (Newton)? The convecting velocity must be one flow.
    pub newton: bool,
    /// Extra force and the time it is wanted at \[s\].
    pub body_force: Option<&'a BodyForce>,
    /// Time at the end of the step \[s\].
    pub time: f64,
    /// Flows that convect or carry history.
    pub carriers: &'a [Carrier<'a>],
    /// The solid.
    pub solid: &'a Solid,
}

/// A known flow: how much of it convects, how much of it is history.
#[derive(Debug, Clone, Copy)]
pub struct Carrier<'a> {
    /// The flow.
    pub flow: &'a Flow,
    /// Its weight in the convecting velocity a.
    pub convects: f64,
    /// Its weight η in the time derivative α/Δt v − Σ η_k v^k \[1/s\].
    pub history: f64,
}

/// Most flows that can take part: two earlier steps and the iterate.
const CARRIERS: usize = 3;

/// Values of one triangle.
pub struct Element<'a> {
    terms: &'a Coefficients<'a>,
    /// Geometry.
    pub shape: &'a Triangle,
    corners: &'a [[f64; 2]; 3],
    porosity: [f64; 3],
    entrained: [f64; 3],
    mobility: [f64; 3],
    source: [[f64; 3]; 2],
    flux: [[f64; 3]; 2],
    /// β_j/φ_j
    drag_ratio: [f64; 3],
    /// c_j/φ_j
    entrained_ratio: [f64; 3],
    porosity_gradient: [f64; 2],
    mixture_gradient: [f64; 2],
    mobility_gradient: [f64; 2],
    flux_divergence: f64,
    carriers: [([[f64; 3]; 2], [f64; 3]); CARRIERS],
    tau: f64,
    tau_c: f64,
}

/// Values at one quadrature point. Index order: node, then component.
pub struct Point {
    /// Quadrature weight times area \[m²\].
    pub weight: f64,
    /// N_i
    pub shape: [f64; 3],
    /// ∇N_i
    pub gradient: [[f64; 2]; 3],
    /// X_i
    pub test: [f64; 3],
    /// ∇X_i
    pub test_gradient: [[f64; 2]; 3],
    /// P∇X_i + X_i∇P, the divergence of P times the test function by component
    pub test_divergence: [[f64; 2]; 3],
    /// τρφ a·∇X_i
    pub streamline: [f64; 3],
    /// N_j + e_j: what unknown j contributes to the mixture flux u + c v
    pub flux: [f64; 3],
    /// ∇(N_j + e_j)
    pub flux_gradient: [[f64; 2]; 3],
    /// b_j
    pub drag: [f64; 3],
    /// ρφ D_t v_j + b_j
    pub transport: [f64; 3],
    /// S_j,df
    pub strong: [[[f64; 2]; 2]; 3],
    /// ρφ ∂_f a_d when Newton, else 0
    pub newton: [[f64; 2]; 2],
    /// ρφ \[kg/m³\]
    pub inertia: f64,
    /// μφ \[Pa s\]
    pub viscosity: f64,
    /// μ∇φ where the literal form asks for it, else 0
    pub literal: [f64; 2],
    /// Is the viscous form symmetric?
    pub symmetric: bool,
    /// P = φ + c
    pub mixture: f64,
    /// c
    pub entrained: f64,
    /// κ
    pub mobility: f64,
    /// ∇κ
    pub mobility_gradient: [f64; 2],
    /// s \[N/m³\]
    pub source: [f64; 2],
    /// f \[N/m³\]
    pub body: [f64; 2],
    /// ρφ g \[N/m³\]
    pub weight_force: [f64; 2],
    /// ρφ Σ η_k v^k, and the Newton part ρφ a·∇a \[N/m³\]
    pub carried: [f64; 2],
    /// F \[N/m³\]
    pub force: [f64; 2],
    /// j⁰ \[m/s\]
    pub solid_flux: [f64; 2],
    /// ∇·j⁰ \[1/s\]
    pub solid_divergence: f64,
    /// τ
    pub tau: f64,
    /// τ_c
    pub tau_c: f64,
}

impl<'a> Element<'a> {
    /// Gather the values of triangle `t`.
    pub fn gather(terms: &'a Coefficients<'a>, mesh: &'a Mesh, t: usize) -> Element<'a> {
        let nodes = mesh.triangles[t];
        let shape = &mesh.geometry[t];
        let solid = &terms.solid.matrix;
        let scalar = |values: &[f64]| nodes.map(|n| values[n]);
        let vector = |values: &[[f64; 2]]| [0, 1].map(|d| nodes.map(|n| values[n][d]));
        let porosity = scalar(&solid.porosity);
        let entrained = scalar(&solid.entrained_fraction);
        let drag = scalar(&solid.drag);
        let mobility = scalar(&solid.solid_mobility);
        let flux = vector(&terms.solid.solid_flux);
        let mut carriers = [([[0.0; 3]; 2], [1.0; 3]); CARRIERS];
        for (slot, carrier) in carriers.iter_mut().zip(terms.carriers) {
            let flow = carrier.flow;
            *slot = (vector(&flow.superficial_velocity), scalar(&flow.porosity));
        }
        let porosity_gradient = shape.gradient_of(&porosity);
        let entrained_gradient = shape.gradient_of(&entrained);
        let mut element = Element {
            terms,
            shape,
            corners: &mesh.corners[t],
            porosity,
            entrained,
            mobility,
            source: vector(&terms.solid.drag_source),
            flux,
            drag_ratio: [0, 1, 2].map(|k| drag[k] / porosity[k]),
            entrained_ratio: [0, 1, 2].map(|k| entrained[k] / porosity[k]),
            porosity_gradient,
            mixture_gradient: [0, 1].map(|d| porosity_gradient[d] + entrained_gradient[d]),
            mobility_gradient: shape.gradient_of(&mobility),
            flux_divergence: shape.gradient_of(&flux[0])[0] + shape.gradient_of(&flux[1])[1],
            carriers,
            tau: 0.0,
            tau_c: 0.0,
        };
        element.stabilise(mean(&drag));
        element
    }

    /// τ and τ_c from element means.
    fn stabilise(&mut self, drag: f64) {
        let terms = self.terms;
        let centre = [1.0 / 3.0; 3];
        let speed = {
            let a = self.carried(&centre, |carrier| carrier.convects);
            a[0].hypot(a[1])
        };
        let porosity = mean(&self.porosity);
        let scales = Scales {
            rate: terms.rate,
            inertia: terms.density * porosity,
            viscosity: terms.dynamic_viscosity * porosity,
            drag,
            speed,
            mixture: porosity + mean(&self.entrained),
            size: self.shape.size(),
        };
        self.tau = scales.momentum();
        self.tau_c = terms.grad_div * scales.continuity();
    }

    /// Σ weight_k v^k where the shape functions are `shape`.
    #[inline]
    fn carried(&self, shape: &[f64; 3], weight: impl Fn(&Carrier<'_>) -> f64) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (carrier, (velocity, porosity)) in self.terms.carriers.iter().zip(&self.carriers) {
            let factor = weight(carrier);
            if factor != 0.0 {
                let factor = factor / interpolate(shape, porosity);
                for d in 0..2 {
                    sum[d] += factor * interpolate(shape, &velocity[d]);
                }
            }
        }
        sum
    }

    /// ∂_f a_d of the one convecting flow.
    fn convecting_gradient(&self, shape: &[f64; 3], a: [f64; 2]) -> [[f64; 2]; 2] {
        let convecting = self
            .terms
            .carriers
            .iter()
            .position(|carrier| carrier.convects != 0.0);
        let Some(slot) = convecting else {
            return [[0.0; 2]; 2];
        };
        let (velocity, porosity) = &self.carriers[slot];
        let value = interpolate(shape, porosity);
        let slope = self.shape.gradient_of(porosity);
        [0, 1].map(|d| {
            let gradient = self.shape.gradient_of(&velocity[d]);
            [0, 1].map(|f| (gradient[f] - a[d] * slope[f]) / value)
        })
    }

    /// The quadrature points, in their fixed order.
    pub fn points(&self) -> impl Iterator<Item = Point> + '_ {
        QUADRATURE
            .iter()
            .map(|(shape, weight)| self.point(*shape, weight * self.shape.area))
    }

    /// All values where the shape functions are `shape`.
    #[inline]
    pub fn point(&self, shape: [f64; 3], weight: f64) -> Point {
        let terms = self.terms;
        let gradient = self.shape.gradient;
        let porosity = interpolate(&shape, &self.porosity);
        let entrained = interpolate(&shape, &self.entrained);
        let (mixture, inverse) = (porosity + entrained, 1.0 / porosity);
        let (slope, slope_p) = (self.porosity_gradient, self.mixture_gradient);
        let inertia = terms.density * porosity;
        let viscosity = terms.dynamic_viscosity * porosity;
        let symmetric = terms.viscous_form == ViscousForm::Symmetric;
        let a = self.carried(&shape, |carrier| carrier.convects);

        let test = shape.map(|n| n * inverse);
        let mut point = Point {
            weight,
            shape,
            gradient,
            test,
            test_gradient: [[0.0; 2]; 3],
            test_divergence: [[0.0; 2]; 3],
            streamline: [0.0; 3],
            flux: [0.0; 3],
            flux_gradient: [[0.0; 2]; 3],
            drag: [0.0; 3],
            transport: [0.0; 3],
            strong: [[[0.0; 2]; 2]; 3],
            newton: [[0.0; 2]; 2],
            inertia,
            viscosity,
            literal: if symmetric {
                [0.0; 2]
            } else {
                slope.map(|g| terms.dynamic_viscosity * g)
            },
            symmetric,
            mixture,
            entrained,
            mobility: interpolate(&shape, &self.mobility),
            mobility_gradient: self.mobility_gradient,
            source: [0, 1].map(|d| interpolate(&shape, &self.source[d])),
            body: self.body_force(&shape),
            weight_force: terms.gravity.map(|g| inertia * g),
            carried: self
                .carried(&shape, |carrier| carrier.history)
                .map(|v| inertia * v),
            force: [0.0; 2],
            solid_flux: [0, 1].map(|d| interpolate(&shape, &self.flux[d])),
            solid_divergence: self.flux_divergence,
            tau: self.tau,
            tau_c: self.tau_c,
        };
        if terms.newton {
            point.newton = self
                .convecting_gradient(&shape, a)
                .map(|row| row.map(|g| inertia * g));
            for d in 0..2 {
                point.carried[d] += point.newton[d][0] * a[0] + point.newton[d][1] * a[1];
            }
        }
        for d in 0..2 {
            point.force[d] =
                point.weight_force[d] + point.carried[d] + point.source[d] + point.body[d]; // (P3)
        }
        let steep = slope[0] * slope[0] + slope[1] * slope[1];
        for j in 0..3 {
            let g = gradient[j];
            for d in 0..2 {
                point.test_gradient[j][d] = (g[d] - test[j] * slope[d]) * inverse;
                point.test_divergence[j][d] =
                    mixture * point.test_gradient[j][d] + test[j] * slope_p[d];
                point.flux_gradient[j][d] = g[d] * (1.0 + self.entrained_ratio[j]);
            }
            point.flux[j] = shape[j] * (1.0 + self.entrained_ratio[j]);
            point.drag[j] = shape[j] * self.drag_ratio[j]; // (P1)
            let along = a[0] * point.test_gradient[j][0] + a[1] * point.test_gradient[j][1];
            point.streamline[j] = self.tau * inertia * along;
            point.transport[j] = inertia * (terms.rate * test[j] + along) + point.drag[j];
            let turn = (slope[0] * g[0] + slope[1] * g[1]) * inverse;
            let bend = terms.dynamic_viscosity * (turn - shape[j] * steep * inverse * inverse);
            for d in 0..2 {
                for f in 0..2 {
                    let cross =
                        terms.dynamic_viscosity * slope[d] * inverse * (g[f] - test[j] * slope[f]);
                    point.strong[j][d][f] =
                        point.newton[d][f] * test[j] + if symmetric { cross } else { 0.0 }; // (P2)
                }
                point.strong[j][d][d] += point.transport[j] + bend;
            }
        }
        point
    }

    fn body_force(&self, shape: &[f64; 3]) -> [f64; 2] {
        self.terms.body_force.map_or([0.0; 2], |force| {
            let x = [0, 1].map(|d| (0..3).map(|k| shape[k] * self.corners[k][d]).sum());
            force(x, self.terms.time)
        })
    }
}

fn mean(value: &[f64; 3]) -> f64 {
    (value[0] + value[1] + value[2]) / 3.0
}
