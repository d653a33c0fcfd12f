//! Pressures of open boundaries.

use std::collections::BTreeMap;

use space::{Vector, dot};

use super::condition::Condition;
use crate::mesh::simplices::Mesh;

/// Pressure of the nodes of open boundaries \[Pa\]; the boundary named first wins at a shared node.
pub(super) fn pressures<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    conditions: &[Condition<D>],
    density: f64,
    gravity: &Vector<D>,
) -> Vec<(usize, f64)> {
    let mut of_node: BTreeMap<usize, f64> = BTreeMap::new();
    for (boundary, condition) in conditions.iter().enumerate() {
        let Condition::Open(top) = condition else {
            continue;
        };
        let nodes = || {
            let facets = mesh.facets.iter().filter(|f| f.boundary == boundary);
            facets.flat_map(|facet| facet.node)
        };
        let depth = |node: usize| dot(gravity, &mesh.position[node]);
        let highest = nodes().map(depth).fold(f64::INFINITY, f64::min);
        for node in nodes() {
            of_node
                .entry(node)
                .or_insert(top + density * (depth(node) - highest));
        }
    }
    of_node.into_iter().collect()
}
