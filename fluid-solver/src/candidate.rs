//! What is asked of the fluid, and what it answers.

use space::Vector;

use crate::diagnostics::powers::Powers;
use crate::numbers::Numbers;
use crate::state::State;

/// Which candidate is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Number of the step.
    pub step: u64,
    /// Pass within the step.
    pub pass: u32,
    /// Length of the step \[s\].
    pub dt: f64,
}

impl Request {
    /// The first pass of a step.
    pub fn first(step: u64, dt: f64) -> Request {
        Request { step, pass: 0, dt }
    }

    /// Is this a further pass of the same step? A repeated pass and a step of another length are not:
    /// they begin again.
    pub(crate) fn follows(&self, other: &Request) -> bool {
        self.step == other.step && self.dt == other.dt && self.pass > other.pass
    }
}

/// What `advance` computed.
#[derive(Debug, Clone)]
pub struct Candidate<const D: usize> {
    /// What was asked for.
    pub request: Request,
    /// The state at the end of the step.
    pub state: State<D>,
    /// v_α = u_α/φ_α \[m/s\].
    pub interstitial_velocity: Vec<Vector<D>>,
    /// ℓ_α⁻¹ ∫N_α ∇p \[Pa/m\].
    pub pressure_gradient: Vec<Vector<D>>,
    /// Terms of the energy identity.
    pub powers: Powers,
    /// Force of the fluid on each boundary \[N, in the plane N/m\], in the order of the mesh's names.
    pub forces: Vec<Vector<D>>,
    /// Re of (R1): how much convection matters.
    pub reynolds: f64,
    /// Was it solved with convection?
    pub convects: bool,
    /// Named numbers, for people.
    pub diagnostics: Numbers,
}

impl<const D: usize> Candidate<D> {
    /// A named number.
    pub fn number(&self, name: &str) -> Option<f64> {
        let mut numbers = self.diagnostics.iter();
        let found = numbers.find(|(known, _)| known == name);
        found.map(|(_, value)| *value)
    }
}
