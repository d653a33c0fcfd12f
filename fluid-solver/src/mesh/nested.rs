//! Coarser meshes under a mesh.
//!
//! Cells 2, 4, 8 … times as large as asked for, from the same root; once that is hardly coarser any more, roots whose
//! cells are twice as large. Kuhn's simplices of 2n cells divide those of n, so that meshes are nested where numbers of
//! cells are even; elsewhere the nodes of one are found in the next all the same.

use space::{Dim, Dimension};

use super::bisection::{Bisection, Forest, Spot};
use super::simplices::Mesh;
use super::sizes::Sizes;
use crate::error::FluidError;

/// A mesh of so few nodes is coarse enough.
const ENOUGH: usize = 900;
/// A mesh with more than this share of the nodes of the finer one is hardly coarser.
const HARDLY: f64 = 0.75;

/// A coarser mesh.
pub struct Coarser<const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: Mesh<D, N>,
    /// The nodes of the next finer one, in this one.
    pub spots: Vec<Spot<N>>,
}

/// Coarser meshes under one of these sizes with so many nodes, the finest first.
pub fn coarser<F: Forest<D, N> + Clone, const D: usize, const N: usize>(
    finest: &Bisection<F, D, N>,
    sizes: &Sizes<D>,
    mut node_count: usize,
    simplices_max: usize,
) -> Result<Vec<Coarser<D, N>>, FluidError>
where
    Dim<D>: Dimension<D>,
{
    let mut levels = Vec::new();
    let mut own: Option<Bisection<F, D, N>> = None;
    let mut factor = 1.0;
    let mut root = finest.root().clone();
    let mut of_root = false;
    while node_count > ENOUGH {
        factor *= 2.0;
        let finer = own.as_ref().unwrap_or(finest);
        if !of_root {
            let (next, mesh) = Bisection::new(&root, &sizes.times(factor), simplices_max)?;
            if mesh.node_count() as f64 <= HARDLY * node_count as f64 {
                let spots = next.spots_of(finer);
                node_count = mesh.node_count();
                levels.push(Coarser { mesh, spots });
                own = Some(next);
                continue;
            }
            of_root = true;
        }
        let Some(larger) = root.coarser() else { break };
        root = larger;
        let any = Sizes::new(Vec::new(), 0.0, f64::INFINITY, root.period());
        let (next, mesh) = Bisection::new(&root, &any, simplices_max)?;
        let spots = next.spots_by_place(finer);
        node_count = mesh.node_count();
        levels.push(Coarser { mesh, spots });
        own = Some(next);
    }
    Ok(levels)
}
