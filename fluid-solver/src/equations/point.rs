//! Everything the equations need at one quadrature point of one simplex.
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
//! reaction, because the coupler samples exactly v_α = u_α/φ_α; where held grains drag unevenly their
//! integrals are kept and their places within the simplex change (`held`). The second line of (P2) belongs to
//! the symmetric viscous form alone.

use space::simplex::{combine, interpolate};
use space::vector::from_fn;
use space::{Dim, Dimension, Vector, dot, quadrature};

use super::coefficients::ViscousForm;
use super::element::Element;

/// Values at one quadrature point. Index order: node, then component.
pub struct Point<const D: usize, const N: usize> {
    /// Quadrature weight times volume \[m^D\].
    pub weight: f64,
    /// N_i
    pub shape: [f64; N],
    /// ∇N_i
    pub gradient: [Vector<D>; N],
    /// X_i
    pub test: [f64; N],
    /// ∇X_i
    pub test_gradient: [Vector<D>; N],
    /// P∇X_i + X_i∇P, the divergence of P times the test function by component
    pub test_divergence: [Vector<D>; N],
    /// τρφ a·∇X_i + d_i/φ
    pub streamline: [f64; N],
    /// d_j
    pub tilt: [f64; N],
    /// N_j + e_j + d_j: what unknown j contributes to the mixture flux u + c v
    pub flux: [f64; N],
    /// ∇(N_j + e_j)
    pub flux_gradient: [Vector<D>; N],
    /// b_j
    pub drag: [f64; N],
    /// ρφ D_t v_j + b_j
    pub transport: [f64; N],
    /// S_j,df
    pub strong: [[Vector<D>; D]; N],
    /// ρφ ∂_f a_d when Newton, else 0
    pub newton: [Vector<D>; D],
    /// ρφ \[kg/m³\]
    pub inertia: f64,
    /// μφ \[Pa s\]
    pub viscosity: f64,
    /// μ∇φ where the literal form asks for it, else 0
    pub literal: Vector<D>,
    /// Is the viscous form symmetric?
    pub symmetric: bool,
    /// P = φ + c
    pub mixture: f64,
    /// c
    pub entrained: f64,
    /// κ
    pub mobility: f64,
    /// ∇κ
    pub mobility_gradient: Vector<D>,
    /// s \[N/m³\]
    pub source: Vector<D>,
    /// f \[N/m³\]
    pub body: Vector<D>,
    /// ρφ g \[N/m³\]
    pub weight_force: Vector<D>,
    /// ρφ Σ η_k v^k, and the Newton part ρφ a·∇a \[N/m³\]
    pub carried: Vector<D>,
    /// F \[N/m³\]
    pub force: Vector<D>,
    /// j⁰ \[m/s\]
    pub solid_flux: Vector<D>,
    /// ∇·j⁰ \[1/s\]
    pub solid_divergence: f64,
    /// τ
    pub tau: f64,
    /// τ_c
    pub tau_c: f64,
}

impl<const D: usize, const N: usize> Element<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// The quadrature points, in their fixed order.
    pub fn points(&self) -> impl Iterator<Item = Point<D, N>> + '_ {
        quadrature::points::<N>()
            .map(|(shape, weight)| Point::new(self, shape, weight * self.simplex.volume))
    }

    /// All values where the shape functions are `shape`.
    pub fn point(&self, shape: [f64; N], weight: f64) -> Point<D, N> {
        Point::new(self, shape, weight)
    }
}

impl<const D: usize, const N: usize> Point<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// The values of an element where the shape functions are `shape`.
    #[inline]
    fn new(element: &Element<'_, D, N>, shape: [f64; N], weight: f64) -> Point<D, N> {
        let terms = element.terms;
        let porosity = interpolate(&shape, &element.porosity);
        let spread = element.weights.spread(&shape, porosity);
        let entrained = interpolate(&spread, &element.entrained);
        let inverse = 1.0 / porosity;
        let inertia = terms.density * porosity;
        let symmetric = terms.viscous_form == ViscousForm::Symmetric;
        let a = element.carried(&shape, |carrier| carrier.convects);
        let history = element.carried(&shape, |carrier| carrier.history);
        let mut point = Point {
            weight,
            shape,
            gradient: element.simplex.gradient,
            test: shape.map(|n| n * inverse),
            test_gradient: [Vector::zeros(); N],
            test_divergence: [Vector::zeros(); N],
            streamline: [0.0; N],
            tilt: element.weights.tilt,
            flux: [0.0; N],
            flux_gradient: [Vector::zeros(); N],
            drag: [0.0; N],
            transport: [0.0; N],
            strong: [[Vector::zeros(); D]; N],
            newton: [Vector::zeros(); D],
            inertia,
            viscosity: terms.dynamic_viscosity * porosity,
            literal: if symmetric {
                Vector::zeros()
            } else {
                element
                    .porosity_gradient
                    .map(|g| terms.dynamic_viscosity * g)
            },
            symmetric,
            mixture: porosity + entrained,
            entrained,
            mobility: interpolate(&shape, &element.mobility),
            mobility_gradient: element.mobility_gradient,
            source: from_fn(|d| interpolate(&spread, &element.source[d])),
            body: body_force(element, &shape),
            weight_force: terms.gravity.map(|g| inertia * g),
            carried: history.map(|v| inertia * v),
            force: Vector::zeros(),
            solid_flux: from_fn(|d| interpolate(&shape, &element.flux[d])),
            solid_divergence: element.flux_divergence,
            tau: element.tau,
            tau_c: element.tau_c,
        };
        if terms.newton {
            point.differentiate(element, &a);
        }
        for d in 0..D {
            point.force[d] =
                point.weight_force[d] + point.carried[d] + point.source[d] + point.body[d]; // (P3)
        }
        point.fill_nodes(element, inverse, &spread, &a);
        point
    }

    /// The convective term of Newton's iteration.
    fn differentiate(&mut self, element: &Element<'_, D, N>, a: &Vector<D>) {
        let gradient = element.convecting_gradient(&self.shape, a);
        self.newton = gradient.map(|row| row.map(|g| self.inertia * g));
        for d in 0..D {
            self.carried[d] += dot(&self.newton[d], a);
        }
    }

    /// What belongs to a node: test functions, (P1), (P2).
    #[inline(always)]
    fn fill_nodes(
        &mut self,
        element: &Element<'_, D, N>,
        inverse: f64,
        spread: &[f64; N],
        a: &Vector<D>,
    ) {
        let (terms, viscosity) = (element.terms, element.terms.dynamic_viscosity);
        let (slope, slope_p) = (element.porosity_gradient, element.mixture_gradient);
        let steep = dot(&slope, &slope);
        for j in 0..N {
            let (g, shape, test) = (self.gradient[j], self.shape[j], self.test[j]);
            let share = 1.0 + element.entrained_ratio[j];
            for d in 0..D {
                self.test_gradient[j][d] = (g[d] - test * slope[d]) * inverse;
                self.test_divergence[j][d] =
                    self.mixture * self.test_gradient[j][d] + test * slope_p[d];
                self.flux_gradient[j][d] = g[d] * share;
            }
            self.flux[j] = shape * share + self.tilt[j];
            self.drag[j] = spread[j] * element.drag_ratio[j]; // (P1)
            let along = dot(a, &self.test_gradient[j]);
            self.streamline[j] = self.tau * self.inertia * along + self.tilt[j] * inverse;
            self.transport[j] = self.inertia * (terms.rate * test + along) + self.drag[j];
            let turn = dot(&slope, &g) * inverse;
            let bend = viscosity * (turn - shape * steep * inverse * inverse);
            for d in 0..D {
                for f in 0..D {
                    let cross = viscosity * slope[d] * inverse * (g[f] - test * slope[f]);
                    self.strong[j][d][f] =
                        self.newton[d][f] * test + if self.symmetric { cross } else { 0.0 }; // (P2)
                }
                self.strong[j][d][d] += self.transport[j] + bend;
            }
        }
    }
}

fn body_force<const D: usize, const N: usize>(
    element: &Element<'_, D, N>,
    shape: &[f64; N],
) -> Vector<D> {
    let terms = element.terms;
    terms.body_force.map_or(Vector::zeros(), |force| {
        force(combine(shape, element.corners), terms.time)
    })
}
