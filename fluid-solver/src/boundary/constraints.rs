//! What is known about the unknowns of every node.
//!
//! Where boundaries with different conditions meet, the node takes the strongest: no-slip, then
//! given velocity (the boundary named first in the mesh), then slip. Where slip walls meet whose normals
//! differ by more than 37° a corner of the plane holds all components, an edge of space all but that along it, and a
//! corner of three walls all; on a gentler bend the size-weighted normal is used. What crosses a boundary does not depend on
//! who holds its corners (`flux`). Pressure at an open boundary is given strongly,
//! p = p₀ + ρ g·(x − x_top). In a part of the mesh without an open boundary the first node has p = 0.

use space::{Dim, Dimension, Vector};

use super::condition::Condition;
use super::floating::Floating;
use super::frame::Frame;
use super::inflow::{self, Profile};
use super::node::NodeVelocity;
use super::{moving, open, slip};
use crate::error::FluidError;
use crate::mesh::facet::BoundaryFacet;
use crate::mesh::simplices::Mesh;

/// Conditions on the unknowns of a mesh.
#[derive(Debug, Clone)]
pub struct Constraints<const D: usize> {
    conditions: Vec<Condition<D>>,
    pub(super) profiles: Vec<Profile<D>>,
    velocity: Vec<NodeVelocity<D>>,
    pressure: Vec<(usize, f64)>,
    /// Is there no open boundary?
    pub closed: bool,
    /// The part of the mesh that each node belongs to.
    part: Vec<usize>,
    /// Parts without an open boundary: their first nodes have p = 0.
    pub(super) closed_parts: Vec<bool>,
    /// Is the unknown given? The components of u and p, node by node.
    pub fixed: Vec<bool>,
    /// Frames of nodes whose velocity unknowns do not follow the axes, by node.
    pub frames: Vec<Option<Frame<D>>>,
    /// Facets across which the given velocity carries fluid.
    pub flux_facets: Vec<BoundaryFacet<D>>,
    /// Facets of open boundaries.
    pub open_facets: Vec<BoundaryFacet<D>>,
}

impl<const D: usize> Constraints<D> {
    /// Unknowns of a node.
    const UNKNOWNS: usize = D + 1;

    /// Resolve the conditions, one a boundary of the mesh.
    pub fn new<const N: usize>(
        mesh: &Mesh<D, N>,
        conditions: Vec<Condition<D>>,
        density: f64,
        gravity: &Vector<D>,
    ) -> Result<Constraints<D>, FluidError>
    where
        Dim<D>: Dimension<D>,
    {
        moving::check(mesh, &conditions)?;
        let mut velocity = strongest(mesh, &conditions)?;
        slip::find_normals(mesh, &conditions, &mut velocity);
        let profiles = inflow::profiles(mesh, &conditions)?;
        inflow::find_factors(mesh, &profiles, &mut velocity);
        let of_kind = |wanted: fn(&Condition<D>) -> bool| -> Vec<BoundaryFacet<D>> {
            let facets = mesh.facets.iter();
            facets
                .filter(|facet| wanted(&conditions[facet.boundary]))
                .copied()
                .collect()
        };
        let open_facets = of_kind(|condition| matches!(condition, Condition::Open(_)));
        let flux_facets = of_kind(Condition::carries_fluid);
        let part = mesh.parts();
        let mut closed_parts = vec![true; part.iter().max().map_or(0, |last| last + 1)];
        for facet in &open_facets {
            closed_parts[part[facet.node[0]]] = false;
        }
        let mut constraints = Constraints {
            closed: open_facets.is_empty(),
            part,
            closed_parts,
            fixed: Vec::new(),
            frames: Vec::new(),
            pressure: open::pressures(mesh, &conditions, density, gravity),
            conditions,
            profiles,
            velocity,
            flux_facets,
            open_facets,
        };
        constraints.mark();
        Ok(constraints)
    }

    /// Fill `fixed` and `frames`.
    fn mark(&mut self)
    where
        Dim<D>: Dimension<D>,
    {
        self.fixed = vec![false; Self::UNKNOWNS * self.velocity.len()];
        self.frames = vec![None; self.velocity.len()];
        for (node, velocity) in self.velocity.iter().enumerate() {
            let fixed = &mut self.fixed[Self::UNKNOWNS * node..][..D];
            match velocity {
                NodeVelocity::Free => {}
                NodeVelocity::Zero | NodeVelocity::Given(..) => fixed.fill(true),
                NodeVelocity::Normal(normal) => match axis_of(normal) {
                    Some(axis) => fixed[axis] = true,
                    None => {
                        fixed[0] = true;
                        self.frames[node] = Some(Frame::of_normal(normal));
                    }
                },
                NodeVelocity::Along(edge) => {
                    fixed.fill(true);
                    fixed[axis_of(edge).unwrap_or(0)] = false;
                    if axis_of(edge).is_none() {
                        self.frames[node] = Some(Frame::of_normal(edge));
                    }
                }
            }
        }
        for &(node, _) in &self.pressure {
            self.fixed[Self::UNKNOWNS * node + D] = true;
        }
        for node in self.pinned() {
            self.fixed[Self::UNKNOWNS * node + D] = true;
        }
    }

    /// What is given if the pressure of closed parts may be any that differs by a constant.
    pub fn fixed_but_pins(&self) -> Vec<bool> {
        let mut fixed = self.fixed.clone();
        for node in self.pinned() {
            fixed[Self::UNKNOWNS * node + D] = false;
        }
        fixed
    }

    /// Parts whose pressure is known up to a constant.
    pub fn floating(&self) -> Floating {
        let mut number = vec![u32::MAX; self.closed_parts.len()];
        let pinned = self.pinned();
        for (k, &node) in pinned.iter().enumerate() {
            number[self.part[node]] = k as u32;
        }
        Floating {
            pinned,
            part: self.part.iter().map(|&part| number[part]).collect(),
        }
    }

    /// The first node of each part without an open boundary.
    pub fn pinned(&self) -> Vec<usize> {
        let first = |&part: &usize| self.part.iter().position(|&own| own == part);
        let closed = (0..self.closed_parts.len()).filter(|&part| self.closed_parts[part]);
        closed.filter_map(|part| first(&part)).collect()
    }

    /// The part of the mesh that a facet belongs to.
    pub(super) fn part_of(&self, facet: &BoundaryFacet<D>) -> usize {
        self.part[facet.node[0]]
    }

    /// The given unknowns at a time; zero where an unknown is free.
    pub fn values<const N: usize>(&self, mesh: &Mesh<D, N>, time: f64) -> Vec<f64> {
        let mut values = vec![0.0; self.fixed.len()];
        for (node, velocity) in self.velocity.iter().enumerate() {
            if let NodeVelocity::Given(boundary, factor) = *velocity {
                let u = self.conditions[boundary].velocity(&mesh.position[node], time);
                for d in 0..D {
                    values[N * node + d] = factor * u[d];
                }
            }
        }
        for &(node, value) in &self.pressure {
            values[N * node + D] = value;
        }
        values
    }

    /// Velocity that the boundary gives at the middle of a facet when a run begins \[m/s\]; zero where it
    /// gives none.
    pub fn given_velocity<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        facet: &BoundaryFacet<D>,
    ) -> Vector<D> {
        let corners = facet.corner.map(|k| mesh.corners[facet.simplex][k]);
        let middle = corners[1..].iter().fold(corners[0], |sum, x| sum + x) / D as f64;
        let velocity = self.conditions[facet.boundary].velocity(&middle, 0.0);
        velocity * self.profiles[facet.boundary].factor(&middle)
    }

    /// Condition of a boundary.
    pub fn condition(&self, boundary: usize) -> &Condition<D> {
        &self.conditions[boundary]
    }
}

/// The strongest condition at each node; slip is not seen yet.
fn strongest<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    conditions: &[Condition<D>],
) -> Result<Vec<NodeVelocity<D>>, FluidError> {
    let mut of_node = vec![NodeVelocity::Free; mesh.node_count()];
    for facet in &mesh.facets {
        for node in facet.node {
            of_node[node] = match (&conditions[facet.boundary], of_node[node]) {
                (Condition::NoSlip, _) | (_, NodeVelocity::Zero) => NodeVelocity::Zero,
                (Condition::Periodic, _) => return Err(unjoined(mesh, facet.boundary)),
                (Condition::Slip | Condition::Open(_), known) => known,
                (_, NodeVelocity::Given(k, s)) if k <= facet.boundary => NodeVelocity::Given(k, s),
                _ => NodeVelocity::Given(facet.boundary, 1.0),
            };
        }
    }
    Ok(of_node)
}

fn unjoined<const D: usize, const N: usize>(mesh: &Mesh<D, N>, boundary: usize) -> FluidError {
    FluidError::Boundary {
        name: mesh.boundary_names[boundary].clone(),
        why: "periodic needs a rectangle and the same condition on the opposite side".into(),
    }
}

/// The axis that a direction follows.
fn axis_of<const D: usize>(normal: &Vector<D>) -> Option<usize> {
    let mut axes = (0..D).filter(|&d| normal[d] != 0.0);
    axes.next().filter(|_| axes.next().is_none())
}
