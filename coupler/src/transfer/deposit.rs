//! Deposit a quantity of the grains on the nodes, sample a nodal field at the grains.
//!
//! ```text
//!   W_iα = Σ_p k_p N_α(x_i + y_p)          k_p, y_p: points of the kernel of grain i (T3), Σ k_p = 1
//!   deposit   c_α = ℓ_α⁻¹ Σ_i W_iα x_i     (T1)   lumped mass ℓ
//!   sample    f_i = Σ_α W_iα f_α           (T2)   the adjoint of (T1) in the mass ℓ
//! ```
//!
//! so that Σ_α ℓ_α f_α c_α = Σ_i x_i f_i for any f, x: action = reaction. Σ_α W_iα = 1 conserves the sum
//! of what is deposited: points beyond a wall are mirrored into the mesh. Every grain has a kernel of its
//! own size; there is no length that belongs to all. Spheres in a slab are deposited over its depth: the
//! fluid is solved per metre of depth.

use std::cell::OnceCell;

use space::{Dim, Dimension, Period, Vector};

use crate::error::CouplerError;
use crate::transfer::bell::{Bell, Lattice};
use crate::transfer::locate::Locator;
use crate::transfer::mesh::Mesh;
use crate::transfer::neighbours::Neighbours;
use crate::transfer::path::{Ground, Spot};
use crate::transfer::placement::{Gather, Placement};
use crate::transfer::quantity::Quantity;

/// The transfer between one mesh and any set of grains.
#[derive(Debug)]
pub struct Transfer<const D: usize, const N: usize> {
    locator: Locator<D, N>,
    /// Made when a grain is spread or leaves.
    neighbours: OnceCell<Neighbours<D, N>>,
    node_position: Vec<Vector<D>>,
    nodal_mass: Vec<f64>,
    /// h around each node \[m\].
    cell: Vec<f64>,
    depth: f64,
}

impl<const D: usize, const N: usize> Transfer<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Transfer on a mesh; `depth` \[m\] is that of the slab for spheres in the plane, 1 otherwise.
    pub fn new(mesh: &Mesh<D, N>, depth: f64) -> Transfer<D, N> {
        Transfer {
            locator: Locator::new(mesh),
            neighbours: OnceCell::new(),
            node_position: mesh.node_position.clone(),
            nodal_mass: mesh.nodal_mass.clone(),
            cell: mesh.cell_of_nodes(),
            depth,
        }
    }

    /// Lumped mass ℓ_α of the nodes \[m^D\].
    pub fn nodal_mass(&self) -> &[f64] {
        &self.nodal_mass
    }

    /// Depth of the slab \[m\]; 1 for disks.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Position of a node \[m\].
    pub fn node_position(&self, node: usize) -> &Vector<D> {
        &self.node_position[node]
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodal_mass.len()
    }

    /// Find grains (positions and radii \[m\]) on the mesh.
    pub fn place(&self, positions: &[Vector<D>], radii: &[f64]) -> Result<Placement, CouplerError> {
        let points = positions.iter().enumerate();
        let centres = points.map(|(grain, point)| self.locator.locate(grain, point));
        let centres = centres.collect::<Result<Vec<_>, _>>()?;
        // near ones after each other: the simplices around them are still at hand
        let mut order: Vec<usize> = (0..centres.len()).collect();
        order.sort_by_key(|&grain| centres[grain].simplex);
        let mut placement = Placement::with_capacity(positions.len(), N * positions.len());
        let (mut gather, mut lattice) = (None, Lattice::default());
        for grain in order {
            let centre = &centres[grain];
            let mut cell = 0.0;
            for (&node, &weight) in centre.nodes.iter().zip(&centre.weights) {
                cell += self.cell[node as usize] * weight;
            }
            match Bell::of::<D>(radii[grain], cell) {
                None => placement.set(grain, &centre.nodes, centre.weights),
                Some(bell) => {
                    let gather = gather.get_or_insert_with(|| Gather::new(self.node_count()));
                    let bell = (bell, lattice.of(&bell));
                    gather.spread(grain, bell, centre, self.ground(), &mut placement);
                }
            }
        }
        Ok(placement)
    }

    fn ground(&self) -> Ground<'_, D, N> {
        let made = || Neighbours::new(&self.locator);
        Ground {
            locator: &self.locator,
            neighbours: self.neighbours.get_or_init(made),
        }
    }

    /// Period of the mesh along each axis \[m\].
    pub fn period(&self) -> &Period<D> {
        self.locator.period()
    }

    /// Is a point in no simplex of the mesh?
    pub fn is_outside(&self, point: &Vector<D>) -> bool {
        self.locator.is_outside(point)
    }

    /// The last point inside of the straight path from `start`, where a grain is, by `by` \[m\].
    pub fn last_inside(
        &self,
        grain: usize,
        start: &Vector<D>,
        by: &Vector<D>,
    ) -> Result<Vector<D>, CouplerError> {
        let stencil = self.locator.locate(grain, start)?;
        let from = Spot {
            simplex: stencil.simplex,
            point: self.locator.point(&stencil),
        };
        let end = self.ground().go_to_the_rim(from, by);
        Ok(end.map_or(from.point, |end| end.spot.point))
    }

    /// (T1) of a number or a vector a grain.
    pub fn deposit<Q: Quantity>(
        &self,
        placement: &Placement,
        value_of: impl Fn(usize) -> Q,
    ) -> Vec<Q> {
        let mut nodal = vec![Q::from_components(|_| 0.0); self.node_count()];
        for grain in 0..placement.grain_count() {
            let mut value = value_of(grain);
            value /= self.depth;
            match placement.corners::<N>(grain) {
                Some((nodes, weights)) => add(&mut nodal, value, nodes, weights),
                None => {
                    let (nodes, weights) = placement.entries(grain);
                    add(&mut nodal, value, nodes, weights);
                }
            }
        }
        let masses = nodal.iter_mut().zip(&self.nodal_mass);
        masses.for_each(|(value, &mass)| *value /= mass);
        nodal
    }

    /// (T2) of a nodal field.
    pub fn sample<Q: Quantity>(&self, placement: &Placement, nodal: &[Q]) -> Vec<Q> {
        let at = |grain: usize| match placement.corners::<N>(grain) {
            Some((nodes, weights)) => sum(nodal, nodes, weights),
            None => {
                let (nodes, weights) = placement.entries(grain);
                sum(nodal, nodes, weights)
            }
        };
        (0..placement.grain_count()).map(at).collect()
    }
}

/// Inlined where the length is known, and where it is not.
#[inline(always)]
fn add<Q: Quantity>(nodal: &mut [Q], value: Q, nodes: &[u32], weights: &[f64]) {
    for (&node, &weight) in nodes.iter().zip(weights) {
        nodal[node as usize] += value * weight;
    }
}

#[inline(always)]
fn sum<Q: Quantity>(nodal: &[Q], nodes: &[u32], weights: &[f64]) -> Q {
    let mut sum = nodal[nodes[0] as usize] * weights[0];
    for (&node, &weight) in nodes.iter().zip(weights).skip(1) {
        sum += nodal[node as usize] * weight;
    }
    sum
}
