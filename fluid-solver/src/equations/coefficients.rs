//! What the equations are told: the fluid, the step, the flows that convect, the solid.

use space::Vector;

use crate::solid::Solid;
use crate::state::Flow;

/// Form of the viscous term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViscousForm {
    /// −∇·(2μφ D(v)): Galilean invariant.
    Symmetric,
    /// −∇·(μφ∇v) − μ v ∇²φ: the paper's three terms as printed.
    PaperLiteral,
}

/// A body force f(x, t) per mixture volume \[N/m³\].
pub type BodyForce<const D: usize> = dyn Fn(Vector<D>, f64) -> Vector<D> + Send + Sync;

/// Coefficients of the equations that do not change within an assembly.
pub struct Coefficients<'a, const D: usize> {
    /// ρ \[kg/m³\].
    pub density: f64,
    /// μ \[Pa s\].
    pub dynamic_viscosity: f64,
    /// g \[m/s²\].
    pub gravity: Vector<D>,
    /// Form of the viscous term.
    pub viscous_form: ViscousForm,
    /// Factor θ of the grad-div stabilisation.
    pub grad_div: f64,
    /// α/Δt \[1/s\]; 0 when steady.
    pub rate: f64,
    /// Is the convective term differentiated (Newton)? The convecting velocity must be one flow.
    pub newton: bool,
    /// Extra force and the time it is wanted at \[s\].
    pub body_force: Option<&'a BodyForce<D>>,
    /// Time at the end of the step \[s\].
    pub time: f64,
    /// Flows that convect or carry history.
    pub carriers: &'a [Carrier<'a, D>],
    /// The solid.
    pub solid: &'a Solid<D>,
}

/// A known flow: how much of it convects, how much of it is history.
#[derive(Debug, Clone, Copy)]
pub struct Carrier<'a, const D: usize> {
    /// The flow.
    pub flow: &'a Flow<D>,
    /// Its weight in the convecting velocity a.
    pub convects: f64,
    /// Its weight η in the time derivative α/Δt v − Σ η_k v^k \[1/s\].
    pub history: f64,
}

impl<const D: usize> Coefficients<'_, D> {
    /// The carriers with `flow` convecting in place of the extrapolation.
    pub fn relay<'f>(&self, flow: &'f Flow<D>) -> Vec<Carrier<'f, D>>
    where
        Self: 'f,
    {
        let still = self.carriers.iter().map(|carrier| Carrier {
            convects: 0.0,
            ..*carrier
        });
        let moving = Carrier {
            flow,
            convects: 1.0,
            history: 0.0,
        };
        still
            .filter(|carrier| carrier.history != 0.0)
            .chain(std::iter::once(moving))
            .collect()
    }
}
