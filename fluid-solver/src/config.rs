//! What a fluid solver is told once.

use std::collections::BTreeMap;
use std::sync::Arc;

use space::Vector;

use crate::boundary::condition::Condition;
use crate::equations::coefficients::{BodyForce, ViscousForm};
use crate::error::FluidError;

/// Time scheme.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeScheme {
    /// First order.
    BackwardEuler,
    /// Second order; the first step is backward Euler.
    Bdf2,
    /// No time derivative.
    Steady,
}

/// How the convection is solved within a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Nonlinear {
    /// Convecting velocity extrapolated from accepted steps: one linear solve. A steady flow with
    /// convection has nothing to extrapolate and is iterated to a relative residual of 1e-8.
    Picard,
    /// Newton, after a few Picard iterations.
    Newton {
        /// Relative residual at which it stops.
        tolerance: f64,
        /// Iterations allowed.
        iterations_max: usize,
    },
}

/// What a fluid solver needs to know besides its mesh.
#[derive(Clone)]
pub struct FluidConfig<const D: usize> {
    /// ρ \[kg/m³\].
    pub density: f64,
    /// μ \[Pa s\].
    pub dynamic_viscosity: f64,
    /// g \[m/s²\].
    pub gravity: Vector<D>,
    /// Conditions by boundary name; "all" for those not named.
    pub boundaries: BTreeMap<String, Condition<D>>,
    /// Mean flux of the mixture along periodic axes \[m/s\], steered by a uniform pressure gradient; none: as
    /// the forces have it.
    pub mean_flow: Option<Vector<D>>,
    /// Is ρφ v·∇v there?
    pub convection: bool,
    /// Re of (R1) in `equations::creeping` below which a step is solved without convection, until a step
    /// reaches it; none: convection is always there.
    pub creeping_below: Option<f64>,
    /// Time scheme.
    pub time_scheme: TimeScheme,
    /// Nonlinear solve.
    pub nonlinear: Nonlinear,
    /// Form of the viscous term.
    pub viscous_form: ViscousForm,
    /// Factor of the grad-div stabilisation.
    pub grad_div: f64,
    /// Uniform initial superficial velocity \[m/s\].
    pub initial_velocity: Vector<D>,
    /// Threads of assembly and factorisation; the numbers do not depend on it.
    pub threads: usize,
    /// Extra force per mixture volume \[N/m³\], for manufactured solutions.
    pub body_force: Option<Arc<BodyForce<D>>>,
}

impl<const D: usize> FluidConfig<D> {
    /// Fluid at rest without gravity; backward Euler, Picard, symmetric viscous form.
    pub fn new(density: f64, dynamic_viscosity: f64) -> FluidConfig<D> {
        FluidConfig {
            density,
            dynamic_viscosity,
            gravity: Vector::zeros(),
            boundaries: BTreeMap::new(),
            mean_flow: None,
            convection: true,
            creeping_below: None,
            time_scheme: TimeScheme::BackwardEuler,
            nonlinear: Nonlinear::Picard,
            viscous_form: ViscousForm::Symmetric,
            grad_div: 1.0,
            initial_velocity: Vector::zeros(),
            threads: 1,
            body_force: None,
        }
    }

    /// The same with a condition on a boundary.
    pub fn with(mut self, boundary: &str, condition: Condition<D>) -> FluidConfig<D> {
        self.boundaries.insert(boundary.into(), condition);
        self
    }

    /// Refuse parameters that are out of range.
    pub(crate) fn validate(&self) -> Result<(), FluidError> {
        let positive = [
            ("density", self.density),
            ("dynamic_viscosity", self.dynamic_viscosity),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(FluidError::Parameter {
                    name,
                    value,
                    why: "must be positive and finite",
                });
            }
        }
        if !(self.grad_div >= 0.0 && self.grad_div.is_finite()) {
            let (name, value) = ("grad_div", self.grad_div);
            return Err(FluidError::Parameter {
                name,
                value,
                why: "must be zero or positive",
            });
        }
        Ok(())
    }
}
