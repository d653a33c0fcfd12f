//! How the systems on a mesh are solved: directly in the plane and on small meshes in space, else by iteration.

use space::{Dim, Dimension};

use super::hierarchy::{Conditions, Hierarchy};
use super::iterative::{Iterative, Starts};
use super::solver::{LinearSolver, Solution};
use super::system::System;
use crate::error::FluidError;
use crate::mesh::Spot;

/// Most nodes in space of which a direct factor is the cheaper way.
const DIRECT_NODES: usize = 3000;

/// Are systems on a mesh of so many nodes factorised?
pub fn is_direct<const D: usize>(node_count: usize) -> bool {
    D < 3 || node_count <= DIRECT_NODES
}

/// The solver of the systems on a mesh.
pub enum Method<const D: usize, const N: usize> {
    /// A factor.
    Direct(Box<LinearSolver<N>>),
    /// Iteration.
    Iterative(Box<Iterative<N>>),
}

impl<const D: usize, const N: usize> Method<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// On a mesh and coarser ones, as [`Hierarchy::new`] takes them.
    pub fn new(
        system: &System<N>,
        finest: &Conditions<'_, D, N>,
        coarser: &[(Conditions<'_, D, N>, &[Spot<N>])],
    ) -> Result<Method<D, N>, FluidError> {
        let position = &finest.mesh.position;
        let fixed = finest.constraints.fixed.clone();
        if is_direct::<D>(position.len()) {
            let solver = LinearSolver::new(&system.pattern, fixed)?;
            return Ok(Method::Direct(Box::new(solver)));
        }
        let hierarchy = Hierarchy::new(&system.pattern, finest, coarser);
        let floating = finest.constraints.floating();
        let solver = Iterative::new(hierarchy, fixed, floating);
        Ok(Method::Iterative(Box::new(solver)))
    }

    /// Does it begin somewhere?
    pub fn begins(&self) -> bool {
        match self {
            Method::Direct(solver) => solver.begins(),
            Method::Iterative(_) => true,
        }
    }

    /// Take the matrix of a system; `missing` tells k of (G1) in [`super::multigrid`] where it is wanted.
    pub fn factorise(
        &mut self,
        system: &System<N>,
        missing: impl FnOnce(&Hierarchy<N>) -> Vec<Vec<f64>>,
    ) {
        match self {
            Method::Direct(solver) => solver.factorise(system),
            Method::Iterative(solver) => {
                let missing = missing(solver.hierarchy());
                solver.factorise(system, &missing);
            }
        }
    }

    /// Solve with the last matrix; `given` holds the fixed unknowns.
    pub fn solve(
        &mut self,
        system: &System<N>,
        given: &[f64],
        starts: Option<&Starts>,
    ) -> Result<Solution, FluidError> {
        match self {
            Method::Direct(solver) => {
                solver.solve(system, given, starts.map(|starts| &starts.last[..]))
            }
            Method::Iterative(solver) => solver.solve(system, given, starts),
        }
    }

    /// ‖S(r − Kx)‖ / ‖S|K||x|‖ over the free unknowns.
    pub fn residual(&self, system: &System<N>, x: &[f64]) -> f64 {
        match self {
            Method::Direct(solver) => solver.residual(system, x),
            Method::Iterative(solver) => solver.relative_residual(system, x),
        }
    }
}
