//! A fluid on a mesh that follows a size function.
//!
//! ```text
//!   v_new(x) = Σ N_i(x) u_i/φ_i,  φ_new(x) = Σ N_i(x) φ_i,  u_new = φ_new v_new,  p_new(x) = Σ N_i(x) p_i    (Z2)
//! ```
//!
//! with the shape functions of the mesh before at the nodes of the new one: a node that stays keeps its values, and a
//! velocity that is linear is carried over as it is. What that does to volume, momentum and energy is measured every
//! time ((Z3) in [`crate::diagnostics::content`]). The new mesh comes from the root and the sizes alone
//! ([`crate::mesh::bisection`]).

use space::{Dim, Dimension};

use crate::config::FluidConfig;
use crate::cost::cpu_seconds;
use crate::error::FluidError;
use crate::linear::method;
use crate::mesh::nested::{self, Coarser};
use crate::mesh::{Bisection, Forest, LongestEdge, Mesh, Root, Sizes, Zone};
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
pub enum Refined<const D: usize, const N: usize>
where
    Dim<D>: Dimension<D>,
{
    /// From a box of cells.
    Cells(Bisection<Root<D>, D, N>),
    /// From a mesh.
    Mesh(Bisection<LongestEdge<D, N>, D, N>),
}

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
        match self {
            Refined::Cells(before) => follow(before, solver, sizes),
            Refined::Mesh(before) => follow(before, solver, sizes),
        }
    }
}

fn follow<F: Forest<D, N> + Clone, const D: usize, const N: usize>(
    before: &mut Bisection<F, D, N>,
    solver: &mut FluidSolver<D, N>,
    sizes: &Refinement<D>,
) -> Result<(), FluidError>
where
    Dim<D>: Dimension<D>,
{
    let begin = cpu_seconds();
    let (bisection, mesh, coarser) = bisect(before.root(), sizes)?;
    solver.change_mesh(mesh, &coarser, &before.spots_of(&bisection), begin)?;
    *before = bisection;
    Ok(())
}

/// A mesh, how points are found in it, and coarser meshes.
type Bisected<F, const D: usize, const N: usize> =
    (Bisection<F, D, N>, Mesh<D, N>, Vec<Coarser<D, N>>);

fn bisect<F: Forest<D, N> + Clone, const D: usize, const N: usize>(
    root: &F,
    sizes: &Refinement<D>,
) -> Result<Bisected<F, D, N>, FluidError>
where
    Dim<D>: Dimension<D>,
{
    let largest = sizes.largest.unwrap_or(f64::INFINITY);
    let zones = sizes.zones.clone();
    let sizes = Sizes::new(zones, sizes.growth, largest, root.period());
    let (bisection, mesh) = Bisection::new(root, &sizes, SIMPLICES_MAX)?;
    let nodes = mesh.node_count();
    let coarser = match method::is_direct::<D>(nodes) {
        true => Vec::new(),
        false => nested::coarser(&bisection, &sizes, nodes, SIMPLICES_MAX)?,
    };
    Ok((bisection, mesh, coarser))
}

/// A solver on a box of cells, none of them divided.
pub fn solver_on_cells<const D: usize, const N: usize>(
    config: FluidConfig<D>,
    root: &Root<D>,
) -> Result<FluidSolver<D, N>, FluidError>
where
    Dim<D>: Dimension<D>,
{
    let as_they_are = Refinement {
        zones: Vec::new(),
        growth: 1.0,
        largest: None,
    };
    let (_, mesh, coarser) = bisect(root, &as_they_are)?;
    FluidSolver::with_coarser(config, mesh, &coarser)
}

/// A solver on its first mesh, refined from a box of cells, and how that follows.
pub fn solver<const D: usize, const N: usize>(
    config: FluidConfig<D>,
    root: &Root<D>,
    sizes: &Refinement<D>,
) -> Result<(FluidSolver<D, N>, Refined<D, N>), FluidError>
where
    Dim<D>: Dimension<D>,
{
    let (bisection, mesh, coarser) = bisect(root, sizes)?;
    let solver = following(config, mesh, &coarser)?;
    Ok((solver, Refined::Cells(bisection)))
}

/// The same, refined from a mesh without joined sides.
pub fn solver_on_mesh<const D: usize, const N: usize>(
    config: FluidConfig<D>,
    root: &Mesh<D, N>,
    sizes: &Refinement<D>,
) -> Result<(FluidSolver<D, N>, Refined<D, N>), FluidError>
where
    Dim<D>: Dimension<D>,
{
    let (bisection, mesh, coarser) = bisect(&LongestEdge::new(root)?, sizes)?;
    let solver = following(config, mesh, &coarser)?;
    Ok((solver, Refined::Mesh(bisection)))
}

fn following<const D: usize, const N: usize>(
    config: FluidConfig<D>,
    mesh: Mesh<D, N>,
    coarser: &[Coarser<D, N>],
) -> Result<FluidSolver<D, N>, FluidError>
where
    Dim<D>: Dimension<D>,
{
    let mut solver = FluidSolver::with_coarser(config, mesh, coarser)?;
    solver.tell_of_meshes();
    Ok(solver)
}
