//! A fluid on a mesh that follows a size function.
//!
//! ```text
//!   v_new(x) = Σ N_i(x) u_i/φ_i,  φ_new(x) = Σ N_i(x) φ_i,  u_new = φ_new v_new,  p_new(x) = Σ N_i(x) p_i    (Z2)
//! ```
//!
//! with the shape functions of the mesh before at the nodes of the new one: a node that stays keeps its values, and a
//! velocity that is linear is carried over as it is. The new mesh comes from the root and the sizes alone
//! ([`crate::mesh::bisection`]).

use space::{Dim, Dimension};

use crate::config::FluidConfig;
use crate::cost::cpu_seconds;
use crate::error::FluidError;
use crate::mesh::{Bisection, Mesh, Root, Sizes, Zone};
use crate::step::FluidSolver;

/// How large cells are.
#[derive(Debug, Clone)]
pub struct Refinement<const D: usize> {
    /// Where they are small.
    pub zones: Vec<Zone<D>>,
    /// By how much they grow away from there, in metres a metre.
    pub growth: f64,
    /// The largest \[m\]; none: those of the root.
    pub largest: Option<f64>,
}

/// Most simplices of a mesh: a direct factor of more does not fit the memory of any machine at hand.
const SIMPLICES_MAX: usize = 8_000_000;

/// How the mesh of a solver follows.
pub struct Refined<const D: usize, const N: usize>(Bisection<D, N>);

impl<const D: usize, const N: usize> Refined<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Change to a mesh with cells of these sizes, with the accepted state carried over (Z2). An error leaves all as
    /// it is.
    pub fn adapt(
        &mut self,
        solver: &mut FluidSolver<D, N>,
        sizes: &Refinement<D>,
    ) -> Result<(), FluidError> {
        let begin = cpu_seconds();
        let (bisection, mesh) = bisect(self.0.root(), sizes)?;
        let spots = mesh.position.iter().map(|x| self.0.locate(x));
        let spots: Vec<([u32; N], [f64; N])> = spots.collect();
        solver.change_mesh(mesh, &spots, begin)?;
        self.0 = bisection;
        Ok(())
    }
}

fn bisect<const D: usize, const N: usize>(
    root: &Root<D>,
    sizes: &Refinement<D>,
) -> Result<(Bisection<D, N>, Mesh<D, N>), FluidError>
where
    Dim<D>: Dimension<D>,
{
    let largest = sizes.largest.unwrap_or(f64::INFINITY);
    let zones = sizes.zones.clone();
    let sizes = Sizes::new(zones, sizes.growth, largest, root.period());
    Bisection::new(root, &sizes, SIMPLICES_MAX)
}

/// A solver on its first mesh, and how that follows.
pub fn solver<const D: usize, const N: usize>(
    config: FluidConfig<D>,
    root: &Root<D>,
    sizes: &Refinement<D>,
) -> Result<(FluidSolver<D, N>, Refined<D, N>), FluidError>
where
    Dim<D>: Dimension<D>,
{
    let (bisection, mesh) = bisect(root, sizes)?;
    Ok((FluidSolver::new(config, mesh)?, Refined(bisection)))
}
