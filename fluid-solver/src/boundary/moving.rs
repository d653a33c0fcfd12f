//! Walls that move: along themselves only.

use space::{Vector, dot, hypot};

use super::condition::Condition;
use crate::error::{FluidError, place};
use crate::mesh::facet::BoundaryFacet;
use crate::mesh::simplices::Mesh;

/// Part of its speed at which a wall may leave its plane: round-off of the mesh.
const ASIDE: f64 = 1e-6;

/// No wall moves across itself; an error names the boundary and the place.
pub(super) fn check<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    conditions: &[Condition<D>],
) -> Result<(), FluidError> {
    let crosses = |facet: &&BoundaryFacet<D>| match &conditions[facet.boundary] {
        Condition::MovingWall(velocity) => !is_along(velocity, &facet.normal),
        _ => false,
    };
    let Some(facet) = mesh.facets.iter().find(crosses) else {
        return Ok(());
    };
    let at = mesh.position[facet.node[0]];
    Err(FluidError::Boundary {
        name: mesh.boundary_names[facet.boundary].clone(),
        why: format!(
            "a no-slip wall may only move along itself; at {} its velocity points across it: turn the \
             velocity, or write inflow",
            place(&at)
        ),
    })
}

fn is_along<const D: usize>(velocity: &Vector<D>, normal: &Vector<D>) -> bool {
    dot(velocity, normal).abs() <= ASIDE * hypot(velocity)
}
