//! What a fluid engine tells of its mesh with `Ready`: received, and looked at.

use crate::language::engine::{FacetDescription, MeshDescription};
use crate::language::error::Error;
use crate::language::field::{BOUNDARY, Field, MESH};
use crate::language::header::Stage;
use crate::language::message::{MeshBoundary, Ready, ToCoupler};
use crate::transport::channel::{Channel, Wait};
use crate::transport::exchange::{Counts, Moment};

use super::check::{check_mesh, corners, count, facet_boundaries, same_dimension, unexpected};

/// The mesh of an engine that is ready, in the dimension that it was asked for, and its counts.
pub(super) fn ready(
    ready: Ready,
    dimension_asked: usize,
    channel: &mut dyn Channel,
    wait: Wait<'_>,
) -> Result<(Counts, MeshDescription), Error> {
    let who = channel.peer().to_owned();
    let Ready::Mesh {
        epoch,
        dimension,
        nodes,
        simplices,
        period,
        facets,
        boundaries,
    } = ready
    else {
        let ready = ToCoupler::Ready(ready);
        return Err(unexpected(&who, wait.step, &ready, "Ready with a mesh"));
    };
    same_dimension(&who, dimension_asked, dimension)?;
    let counts = Counts {
        epoch,
        dimension: dimension_asked,
        nodes: count(&who, "nodes", nodes)?,
        simplices: count(&who, "simplices", simplices)?,
        facets: count(&who, "facets", facets)?,
        grains: 0,
    };
    let mut mesh = mesh(&counts, channel, period, wait)?;
    mesh.facets = facets_of(&counts, channel, boundaries, wait)?;
    Ok((counts, mesh))
}

/// The mesh, without its boundary.
fn mesh(
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
fn facets_of(
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
