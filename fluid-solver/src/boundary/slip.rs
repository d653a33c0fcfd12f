//! Unit normals of nodes on slip walls.

use space::{Vector, dot, hypot};

use super::condition::Condition;
use super::node::NodeVelocity;
use crate::mesh::facet::BoundaryFacet;
use crate::mesh::simplices::Mesh;

/// Cosine of the angle between two walls from which on they meet at a sharp edge …
const SHARP: f64 = 0.8;
/// … and its sine.
const APART: f64 = 0.6;
/// A component of a normal that is smaller is round-off: the wall keeps its axis.
const STRAIGHT: f64 = 1e-12;

/// What the facets at a node say.
#[derive(Clone)]
struct Corner<const D: usize> {
    /// Σ size · normal
    sum: Vector<D>,
    sharp: bool,
    /// Orthonormal, as many as there are sharply different normals; the normal seen first is the first of them.
    span: [Vector<D>; D],
    rank: usize,
}

impl<const D: usize> Corner<D> {
    /// What remains of a vector outside the span.
    fn outside(&self, vector: &Vector<D>) -> Vector<D> {
        let known = self.span[..self.rank].iter();
        known.fold(*vector, |rest, own| rest - own * dot(own, &rest))
    }

    fn see(&mut self, facet: &BoundaryFacet<D>) {
        self.sharp |= self.rank > 0 && dot(&self.span[0], &facet.normal) < SHARP;
        for d in 0..D {
            self.sum[d] += facet.size * facet.normal[d];
        }
        let rest = self.outside(&facet.normal);
        if self.rank < D && hypot(&rest) > APART {
            self.span[self.rank] = direction(&rest);
            self.rank += 1;
        }
    }

    /// Two walls of space leave the direction of their edge, three nothing; nor do two sides of the plane.
    fn velocity(&self) -> NodeVelocity<D> {
        match self.sharp {
            false => NodeVelocity::Normal(direction(&self.sum)),
            true if self.rank > 1 && self.rank + 1 == D => {
                let axes =
                    (0..D).map(|d| self.outside(&space::vector::from_fn(|k| f64::from(k == d))));
                let longest = axes.max_by(|a, b| hypot(a).total_cmp(&hypot(b)));
                NodeVelocity::Along(direction(&longest.unwrap_or(self.sum)))
            }
            true => NodeVelocity::Zero,
        }
    }
}

/// Unit normals of slip nodes that nothing stronger holds; at sharp edges the direction that is left, and nothing at
/// corners.
pub(super) fn find_normals<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    conditions: &[Condition<D>],
    of_node: &mut [NodeVelocity<D>],
) {
    let nothing = Corner {
        sum: Vector::zeros(),
        sharp: false,
        span: [Vector::zeros(); D],
        rank: 0,
    };
    let mut corners = vec![nothing; mesh.node_count()];
    let slip = |facet: &&BoundaryFacet<D>| matches!(conditions[facet.boundary], Condition::Slip);
    for facet in mesh.facets.iter().filter(slip) {
        for node in facet.node {
            corners[node].see(facet);
        }
    }
    for (velocity, corner) in of_node.iter_mut().zip(&corners) {
        if corner.rank > 0 && *velocity == NodeVelocity::Free {
            *velocity = corner.velocity();
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
