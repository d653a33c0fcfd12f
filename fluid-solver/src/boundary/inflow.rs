//! Profiles of given velocities.

use std::cmp::Ordering;

use space::{Vector, dot};

use super::condition::Condition;
use super::node::NodeVelocity;
use crate::error::FluidError;
use crate::mesh::facet::BoundaryFacet;
use crate::mesh::simplices::Mesh;

/// Extent across a flat side, of the longest along it.
const FLAT: f64 = 1e-9;

/// Shape of the velocity given along a boundary.
#[derive(Debug, Clone, Copy)]
pub(super) enum Profile<const D: usize> {
    /// As the condition says.
    Plain,
    /// 4 t (1 − t) times that, t from end to end.
    Parabola {
        /// One end \[m\].
        start: Vector<D>,
        /// From there to the other \[m\].
        along: Vector<D>,
        /// |along|² \[m²\].
        squared: f64,
    },
    /// The product of 4 t (1 − t) along each axis of a rectangle of space, t from side to side.
    Paraboloid {
        /// Its lower corner \[m\].
        lower: Vector<D>,
        /// From there to the upper one \[m\]; 0 across it.
        extent: Vector<D>,
    },
}

impl<const D: usize> Profile<D> {
    /// The factor at a point of the boundary.
    pub(super) fn factor(&self, at: &Vector<D>) -> f64 {
        match self {
            Profile::Plain => 1.0,
            Profile::Parabola {
                start,
                along,
                squared,
            } => {
                let t = dot(&(at - start), along) / squared;
                4.0 * t * (1.0 - t)
            }
            Profile::Paraboloid { lower, extent } => {
                let along = (0..D).filter(|&axis| extent[axis] > 0.0);
                let factor = along.map(|axis| {
                    let t = (at[axis] - lower[axis]) / extent[axis];
                    4.0 * t * (1.0 - t)
                });
                factor.product()
            }
        }
    }
}

/// The profile of every boundary.
pub(super) fn profiles<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    conditions: &[Condition<D>],
) -> Result<Vec<Profile<D>>, FluidError> {
    let profile = |(boundary, condition): (usize, &Condition<D>)| match condition {
        Condition::Parabolic(_) if D > 2 => rectangle(mesh, boundary),
        Condition::Parabolic(_) => {
            let [start, end] = ends(mesh, boundary)?;
            let along = end - start;
            Ok(Profile::Parabola {
                start,
                along,
                squared: dot(&along, &along),
            })
        }
        _ => Ok(Profile::Plain),
    };
    conditions.iter().enumerate().map(profile).collect()
}

/// The profile of a boundary of space, which must be a flat rectangle along the axes.
fn rectangle<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    boundary: usize,
) -> Result<Profile<D>, FluidError> {
    let facets = mesh.facets.iter().filter(|f| f.boundary == boundary);
    let (mut lower, mut upper) = (Vector::<D>::repeat(f64::MAX), Vector::<D>::repeat(f64::MIN));
    let mut size = 0.0;
    for facet in facets {
        size += facet.size;
        for corner in facet.corner.map(|k| mesh.corners[facet.simplex][k]) {
            (lower, upper) = (lower.inf(&corner), upper.sup(&corner));
        }
    }
    let mut extent = upper - lower;
    let longest = extent.max();
    extent
        .iter_mut()
        .for_each(|x| *x = if *x > FLAT * longest { *x } else { 0.0 });
    let area: f64 = extent.iter().filter(|x| **x > 0.0).product();
    let flat = extent.iter().filter(|x| **x > 0.0).count() + 1 == D;
    match flat && (size - area).abs() <= 1e-6 * area {
        true => Ok(Profile::Paraboloid { lower, extent }),
        false => Err(FluidError::Boundary {
            name: mesh.boundary_names[boundary].clone(),
            why: "a parabolic inflow of space needs a flat rectangle along the axes".to_owned(),
        }),
    }
}

/// Write the factors of profiles to the nodes whose velocity they give.
pub(super) fn find_factors<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    profiles: &[Profile<D>],
    of_node: &mut [NodeVelocity<D>],
) {
    for (velocity, at) in of_node.iter_mut().zip(&mesh.position) {
        if let NodeVelocity::Given(boundary, factor) = velocity {
            *factor = profiles[*boundary].factor(at);
        }
    }
}

/// A node and where a facet has it: across a period the same node is in two places.
type Place<const D: usize> = (usize, Vector<D>);

fn order<const D: usize>(a: &Place<D>, b: &Place<D>) -> Ordering {
    let by_node = a.0.cmp(&b.0);
    let components = a.1.iter().zip(b.1.iter());
    components.fold(by_node, |order, (a, b)| order.then(a.total_cmp(b)))
}

/// The two ends of a line: the places that belong to one facet only.
fn ends<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    boundary: usize,
) -> Result<[Vector<D>; 2], FluidError> {
    let facets = mesh.facets.iter().filter(|f| f.boundary == boundary);
    let places = |facet: &BoundaryFacet<D>| -> Vec<Place<D>> {
        let corners = &mesh.corners[facet.simplex];
        let pairs = facet.node.iter().zip(&facet.corner);
        pairs.map(|(&node, &k)| (node, corners[k])).collect()
    };
    let mut places: Vec<Place<D>> = facets.flat_map(places).collect();
    places.sort_unstable_by(order);
    let alone = places.chunk_by(|a, b| a == b).filter(|g| g.len() == 1);
    let ends: Vec<Vector<D>> = alone.map(|group| group[0].1).collect();
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
