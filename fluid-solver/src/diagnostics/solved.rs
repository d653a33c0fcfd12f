//! A solution with what is needed to judge it.

use space::Vector;

use crate::boundary::constraints::Constraints;
use crate::equations::coefficients::Coefficients;
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
    /// ∮ N_i Q_n by node \[m^D/s\].
    pub flux: &'a [f64],
}
