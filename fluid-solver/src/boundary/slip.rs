//! Unit normals of nodes on slip walls.

use space::{Vector, dot, hypot};

use super::condition::Condition;
use super::node::NodeVelocity;
use crate::mesh::facet::BoundaryFacet;
use crate::mesh::simplices::Mesh;

/// Cosine of the angle between two walls from which on their corner holds every component.
const SHARP: f64 = 0.8;
/// A component of a normal that is smaller is round-off: the wall keeps its axis.
const STRAIGHT: f64 = 1e-12;

/// What the facets at a node say.
#[derive(Clone)]
struct Corner<const D: usize> {
    /// Σ size · normal
    sum: Vector<D>,
    first: Option<Vector<D>>,
    sharp: bool,
}

/// Unit normals of slip nodes that nothing stronger holds; all components held at sharp corners.
pub(super) fn find_normals<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    conditions: &[Condition<D>],
    of_node: &mut [NodeVelocity<D>],
) {
    let nothing = Corner {
        sum: Vector::zeros(),
        first: None,
        sharp: false,
    };
    let mut corners = vec![nothing; mesh.node_count()];
    let slip = |facet: &&BoundaryFacet<D>| matches!(conditions[facet.boundary], Condition::Slip);
    for facet in mesh.facets.iter().filter(slip) {
        for node in facet.node {
            let corner = &mut corners[node];
            let seen = *corner.first.get_or_insert(facet.normal);
            corner.sharp |= dot(&seen, &facet.normal) < SHARP;
            for d in 0..D {
                corner.sum[d] += facet.size * facet.normal[d];
            }
        }
    }
    for (velocity, corner) in of_node.iter_mut().zip(&corners) {
        if corner.first.is_some() && *velocity == NodeVelocity::Free {
            *velocity = if corner.sharp {
                NodeVelocity::Zero
            } else {
                NodeVelocity::Normal(direction(&corner.sum))
            };
        }
    }
}

fn direction<const D: usize>(sum: &Vector<D>) -> Vector<D> {
    let length = hypot(sum);
    sum.map(|v| {
        if v.abs() < STRAIGHT * length {
            0.0
        } else {
            v / length
        }
    })
}
