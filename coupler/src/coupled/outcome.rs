//! What a step has computed, before it is accepted.

use space::Vector;

use crate::coupled::defect::Defect;
use crate::coupled::response::Model;
use crate::state::{Candidate, Flow, Response};
use crate::transfer::Placement;

/// What one pass gave (S2 to S6).
#[derive(Debug, Clone)]
pub struct Pass<const D: usize> {
    /// New nodal fields.
    pub flow: Flow<D>,
    /// q \[N\].
    pub force: Vec<Vector<D>>,
    /// New grains.
    pub grains: Candidate<D>,
    /// r = v̄ − v_model \[m/s\].
    pub residual: Vec<Vector<D>>,
    /// Size of r as a force.
    pub defect: Defect,
}

/// The last pass of a step, and what it was made with.
#[derive(Debug, Clone)]
pub struct Outcome<const D: usize, const N: usize> {
    /// The last pass.
    pub pass: Pass<D>,
    /// Fluid solves.
    pub passes: u32,
    /// The placement all transfers of the step used.
    pub placement: Placement,
    /// The model of the grains.
    pub model: Model<D>,
    /// What the fluid was given.
    pub response: Response<D>,
    /// Pressure force that a fluid without c was not given (`carry.rs`) \[N\].
    pub lagged: Vec<Vector<D>>,
    /// What the next step owes the fluid (`carry.rs`) \[N\].
    pub carried_force: Vec<Vector<D>>,
}
