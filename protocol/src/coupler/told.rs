//! What a fluid engine tells of its mesh with `Ready`: received, and looked at.

use crate::language::engine::{FacetDescription, MeshDescription};
use crate::language::error::Error;
use crate::language::field::{BOUNDARY, Field, MESH};
use crate::language::header::Stage;
use crate::language::message::MeshBoundary;
use crate::transport::channel::{Channel, Wait};
use crate::transport::exchange::{Counts, Moment};

use super::check::{check_mesh, corners, facet_boundaries};

/// The mesh, without its boundary.
pub(super) fn mesh(
    counts: &Counts,
    channel: &mut dyn Channel,
    period: Vec<Option<f64>>,
    wait: Wait<'_>,
) -> Result<MeshDescription, Error> {
    let [node_position, corner_numbers, simplex_position, nodal_mass] =
        fields(counts, channel, MESH, wait)?;
    let who = channel.peer();
    let mesh = MeshDescription {
        dimension: counts.dimension,
        node_position,
        simplex_nodes: corners(who, counts, &corner_numbers)?,
        simplex_position,
        nodal_mass,
        period,
        facets: FacetDescription::default(),
    };
    check_mesh(who, &mesh)?;
    Ok(mesh)
}

/// Its boundary; without facets where the engine does not tell it.
pub(super) fn facets(
    counts: &Counts,
    channel: &mut dyn Channel,
    boundaries: Vec<MeshBoundary>,
    wait: Wait<'_>,
) -> Result<FacetDescription, Error> {
    if counts.facets == 0 {
        return Ok(FacetDescription::default());
    }
    let [position, numbers, velocity] = fields(counts, channel, BOUNDARY, wait)?;
    Ok(FacetDescription {
        boundary: facet_boundaries(channel.peer(), boundaries.len(), &numbers)?,
        boundaries,
        position,
        velocity,
    })
}

fn fields<const COUNT: usize>(
    counts: &Counts,
    channel: &mut dyn Channel,
    fields: [Field; COUNT],
    wait: Wait<'_>,
) -> Result<[Vec<f64>; COUNT], Error> {
    let mut received = [const { Vec::new() }; COUNT];
    for (field, values) in fields.into_iter().zip(&mut received) {
        let moment = Moment::at(Stage::Ready);
        *values = counts.receive_copy(channel, field, moment, wait)?;
    }
    Ok(received)
}
