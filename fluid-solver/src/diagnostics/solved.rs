//! A solution with what is needed to judge it.

use space::Vector;

use crate::boundary::constraints::Constraints;
use crate::boundary::flux::BoundaryFlux;
use crate::equations::coefficients::Coefficients;
use crate::equations::drive::Drive;
use crate::mesh::simplices::Mesh;

/// A solution with what is needed to judge it.
pub struct Solved<'a, const D: usize, const N: usize> {
    /// The equations solved.
    pub terms: &'a Coefficients<'a, D>,
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// Its conditions.
    pub constraints: &'a Constraints<D>,
    /// Superficial velocity \[m/s\].
    pub velocity: &'a [Vector<D>],
    /// Pressure \[Pa\].
    pub pressure: &'a [f64],
    /// Unknowns as solved for.
    pub unknowns: &'a [f64],
    /// K x − r.
    pub reaction: &'a [f64],
    /// What the given velocities carry across the boundary \[m^D/s\].
    pub flux: &'a BoundaryFlux,
    /// What the flow is to do on the whole, where that is steered.
    pub drive: Option<Drive<D>>,
    /// The uniform part of ∇p that steers it \[Pa/m\].
    pub driving: Vector<D>,
}
