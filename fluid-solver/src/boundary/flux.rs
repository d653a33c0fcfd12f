//! What flows across boundaries whose velocity is given.
//!
//! ```text
//!   Q_i = Σ_facets ∫ N_i u·n          u the profile of the facet's own boundary            (Q1)
//! ```
//!
//! The profile and not the nodal velocities: at a node that two boundaries share the stronger one holds
//! (a wall: u = 0), and the interpolant of such nodes would lose up to half a cell of the inflow, 1/(2n)
//! of it at each end of n cells. Continuity takes (Q1) as its boundary term (`equations::continuity`,
//! (C3)); because Σ N_i = 1 what enters is what was asked for, on every mesh and beside every neighbour,
//! and what leaves is the same to round-off. The velocity of a corner is not touched: fluid passes it
//! within the cell.
//!
//! A parabola is integrated exactly; a function is what its values at the nodes say.

use space::simplex::combine;
use space::{Dim, Dimension, Vector, dot, hypot, quadrature};

use super::condition::Condition;
use super::constraints::Constraints;
use super::inflow::Profile;
use crate::error::FluidError;
use crate::mesh::facet::BoundaryFacet;
use crate::mesh::simplices::Mesh;

/// Largest share of what crosses the boundary of a closed domain that may be left over.
const LEFT_OVER_MAX: f64 = 0.01;

/// What flows out across the facets whose velocity is given \[m^D/s\].
#[derive(Debug, Clone)]
pub struct BoundaryFlux {
    /// ∮ N_i Q_n of each node.
    pub of_node: Vec<f64>,
    /// ∮ Q_n of each of `Constraints::flux_facets`.
    pub of_facet: Vec<f64>,
}

/// ∫ N_i u·n of the corners of a facet, their sum, and ∫|u|.
struct Crossing<const D: usize> {
    of_corner: [f64; D],
    net: f64,
    gross: f64,
}

/// What crosses the facets of a part of the mesh, and their size.
#[derive(Debug, Clone, Copy, Default)]
struct Total {
    net: f64,
    gross: f64,
    size: f64,
}

impl<const D: usize> Constraints<D>
where
    Dim<D>: Dimension<D>,
{
    /// The flux of the given velocities at a time, (Q1). In a closed part of the mesh what a function leaves over
    /// is spread evenly over these facets; more than a hundredth of what crosses them is an error.
    pub fn boundary_flux<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        time: f64,
    ) -> Result<BoundaryFlux, FluidError> {
        let mut flux = BoundaryFlux {
            of_node: vec![0.0; mesh.node_count()],
            of_facet: Vec::with_capacity(self.flux_facets.len()),
        };
        let mut totals = vec![Total::default(); self.closed_parts.len()];
        for facet in &self.flux_facets {
            let crossing = self.crossing(mesh, facet, time);
            for (&node, value) in facet.node.iter().zip(crossing.of_corner) {
                flux.of_node[node] += value;
            }
            flux.of_facet.push(crossing.net);
            let total = &mut totals[self.part_of(facet)];
            total.net += crossing.net;
            total.gross += crossing.gross;
            total.size += facet.size;
        }
        let parts = totals.iter().zip(&self.closed_parts).enumerate();
        for (part, (total, _)) in parts.filter(|(_, (total, closed))| **closed && total.net != 0.0)
        {
            if total.net.abs() > LEFT_OVER_MAX * total.gross {
                return Err(FluidError::Unbalanced {
                    net: -total.net,
                    relative: total.net.abs() / total.gross,
                });
            }
            self.spread(part, total.net / total.size, &mut flux);
        }
        Ok(flux)
    }

    /// Take this much off every square metre of the facets of a part.
    fn spread(&self, part: usize, density: f64, flux: &mut BoundaryFlux) {
        let facets = self.flux_facets.iter().zip(&mut flux.of_facet);
        for (facet, net) in facets.filter(|(facet, _)| self.part_of(facet) == part) {
            *net -= facet.size * density;
            for node in facet.node {
                flux.of_node[node] -= facet.size / D as f64 * density;
            }
        }
    }

    fn crossing<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        facet: &BoundaryFacet<D>,
        time: f64,
    ) -> Crossing<D> {
        let corners = facet.corner.map(|k| mesh.corners[facet.simplex][k]);
        let condition = self.condition(facet.boundary);
        match &self.profiles[facet.boundary] {
            Profile::Plain => linear(facet, &corners.map(|x| condition.velocity(&x, time))),
            curved => integrated(facet, &corners, condition, curved),
        }
    }
}

/// Of a velocity that is linear between these of the corners.
fn linear<const D: usize>(facet: &BoundaryFacet<D>, velocity: &[Vector<D>; D]) -> Crossing<D> {
    let normal = velocity.map(|u| dot(&u, &facet.normal));
    let share = facet.size / (D * (D + 1)) as f64;
    Crossing {
        of_corner: std::array::from_fn(|i| share * doubled_at(i, &normal)),
        net: facet.size / D as f64 * sum(&normal),
        gross: facet.size / D as f64 * sum(&velocity.map(|u| hypot(&u))),
    }
}

/// Of a profile on a facet with these corners.
fn integrated<const D: usize>(
    facet: &BoundaryFacet<D>,
    corners: &[Vector<D>; D],
    condition: &Condition<D>,
    profile: &Profile<D>,
) -> Crossing<D>
where
    Dim<D>: Dimension<D>,
{
    let mut crossing = Crossing {
        of_corner: [0.0; D],
        net: 0.0,
        gross: 0.0,
    };
    for (shape, weight) in quadrature::points::<D>() {
        let at = combine(&shape, corners);
        let velocity = condition.velocity(&at, 0.0) * profile.factor(&at);
        let normal = weight * facet.size * dot(&velocity, &facet.normal);
        for (value, n) in crossing.of_corner.iter_mut().zip(shape) {
            *value += n * normal;
        }
        crossing.net += normal;
        crossing.gross += weight * facet.size * hypot(&velocity);
    }
    crossing
}

/// Σ (1 + δ_ik) value_k
fn doubled_at<const D: usize>(i: usize, value: &[f64; D]) -> f64 {
    let weighted = |k: usize| if k == i { 2.0 * value[k] } else { value[k] };
    (1..D).fold(weighted(0), |sum, k| sum + weighted(k))
}

fn sum<const D: usize>(value: &[f64; D]) -> f64 {
    (1..D).fold(value[0], |sum, k| sum + value[k])
}
