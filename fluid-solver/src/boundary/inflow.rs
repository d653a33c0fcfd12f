//! Profiles of given velocities.

use space::dot;

use super::condition::Condition;
use super::node::NodeVelocity;
use crate::error::FluidError;
use crate::mesh::simplices::Mesh;

/// 4 t (1 − t) along each parabolic boundary, t from end to end.
pub(super) fn find_factors<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    conditions: &[Condition<D>],
    of_node: &mut [NodeVelocity<D>],
) -> Result<(), FluidError> {
    for (boundary, condition) in conditions.iter().enumerate() {
        if !matches!(condition, Condition::Parabolic(_)) {
            continue;
        }
        let nodes = nodes_of(mesh, boundary);
        let [a, b] = ends(mesh, boundary, &nodes)?;
        let p = mesh.position[a];
        let along = mesh.position[b] - p;
        let squared = dot(&along, &along);
        for &node in &nodes {
            let t = dot(&(mesh.position[node] - p), &along) / squared;
            if let NodeVelocity::Given(k, factor) = &mut of_node[node]
                && *k == boundary
            {
                *factor = 4.0 * t * (1.0 - t);
            }
        }
    }
    Ok(())
}

/// Nodes of a boundary, ascending, each as often as it has facets there.
fn nodes_of<const D: usize, const N: usize>(mesh: &Mesh<D, N>, boundary: usize) -> Vec<usize> {
    let facets = mesh.facets.iter().filter(|f| f.boundary == boundary);
    let mut nodes: Vec<usize> = facets.flat_map(|facet| facet.node).collect();
    nodes.sort_unstable();
    nodes
}

/// The two nodes of a line that belong to one facet only.
fn ends<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    boundary: usize,
    nodes: &[usize],
) -> Result<[usize; 2], FluidError> {
    let alone = nodes.chunk_by(|a, b| a == b).filter(|g| g.len() == 1);
    let ends: Vec<usize> = alone.map(|group| group[0]).collect();
    ends.as_slice()
        .try_into()
        .map_err(|_| FluidError::Boundary {
            name: mesh.boundary_names[boundary].clone(),
            why: format!(
                "a parabolic inflow needs one open line with 2 ends; it has {}",
                ends.len()
            ),
        })
}
