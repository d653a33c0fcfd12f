//! A mesh and coarser ones of the same box, as multigrid needs them.

use std::cmp::Ordering;
use std::sync::Arc;

use space::{Dim, Dimension, Vector};

use super::block_rows::Rows;
use super::pattern::Pattern;
use super::transfer::{NO_FRAME, Transfer, Unknowns};
use crate::boundary::Constraints;
use crate::mesh::{Mesh, Spot};

/// A mesh and what holds on it.
#[derive(Clone, Copy)]
pub struct Conditions<'a, const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// What holds.
    pub constraints: &'a Constraints<D>,
}

/// A coarser mesh; nodes in the order of rows.
pub struct CoarseLevel<const N: usize> {
    /// Its unknowns.
    pub unknowns: Unknowns<N>,
    /// To the next finer mesh and back.
    pub transfer: Transfer,
    /// Blocks of its matrix.
    pub rows: Arc<Rows>,
    /// Nodes of its simplices.
    pub simplices: Vec<[u32; N]>,
    /// ∫∇N_i·∇N_j of each \[m^(D−2)\].
    pub stiffness: Vec<[[f32; N]; N]>,
    /// Diameter of the ball of the volume of each \[m\].
    pub sizes: Vec<f32>,
}

/// A mesh and coarser ones, the finest first.
pub struct Hierarchy<const N: usize> {
    /// The node of each row, in lexicographic order of places.
    pub order: Vec<u32>,
    /// Unknowns of the mesh itself, in the order of rows.
    pub unknowns: Unknowns<N>,
    /// Blocks of its matrix.
    pub rows: Arc<Rows>,
    /// Coarser meshes.
    pub levels: Vec<CoarseLevel<N>>,
    /// Rows of the last of all whose pressure makes a solution the only one.
    pub pinned: Vec<u32>,
}

impl<const N: usize> Hierarchy<N> {
    /// Of a mesh with this pattern and of coarser ones, each with the nodes and shape functions at the nodes of the
    /// finer one before.
    pub fn new<const D: usize>(
        pattern: &Pattern<N>,
        finest: &Conditions<'_, D, N>,
        coarser: &[(Conditions<'_, D, N>, &[Spot<N>])],
    ) -> Hierarchy<N>
    where
        Dim<D>: Dimension<D>,
    {
        let order = lexicographic(&finest.mesh.position);
        let rows = Arc::new(rows_of(pattern, &order));
        let mut levels: Vec<CoarseLevel<N>> = Vec::new();
        let mut last = order.clone();
        for (conditions, spots) in coarser {
            let own = lexicographic(&conditions.mesh.position);
            let fine = levels.last().map_or(&rows, |level| &level.rows);
            let level = coarse_level(conditions, spots, &last, &own, fine);
            levels.push(level);
            last = own;
        }
        let coarsest = coarser.last().map_or(finest, |(coarsest, _)| coarsest);
        let pinned = coarsest.constraints.pinned().into_iter();
        let rank = inverse(&last);
        Hierarchy {
            unknowns: unknowns(finest, &order),
            pinned: pinned.map(|node| rank[node]).collect(),
            order,
            rows,
            levels,
        }
    }

    /// Memory of interpolation and coarser meshes \[bytes\].
    pub fn bytes(&self) -> usize {
        let level = |level: &CoarseLevel<N>| {
            let simplices = level.simplices.len() * (4 * N + 4 * N * N + 4);
            level.unknowns.bytes() + level.transfer.bytes() + level.rows.bytes() + simplices
        };
        let levels: usize = self.levels.iter().map(level).sum();
        self.rows.bytes() + self.unknowns.bytes() + 4 * self.order.len() + levels
    }
}

fn coarse_level<const D: usize, const N: usize>(
    conditions: &Conditions<'_, D, N>,
    spots: &[Spot<N>],
    finer: &[u32],
    own: &[u32],
    fine: &Rows,
) -> CoarseLevel<N>
where
    Dim<D>: Dimension<D>,
{
    let mesh = conditions.mesh;
    let rank = inverse(own);
    let spot = |&node: &u32| {
        let (nodes, weights) = spots[node as usize];
        (nodes.map(|node| rank[node as usize]), weights)
    };
    let transfer = Transfer::new(finer.iter().map(spot), own.len());
    let nodes = mesh.simplices.iter();
    let simplices: Vec<[u32; N]> = nodes.map(|nodes| nodes.map(|node| rank[node])).collect();
    let stiffness = mesh.geometry.iter().map(|shape| {
        shape.gradient.map(|a| {
            let entry = |b: Vector<D>| (shape.volume * space::dot(&a, &b)) as f32;
            shape.gradient.map(entry)
        })
    });
    CoarseLevel {
        rows: Arc::new(transfer.coarse_rows(fine, &simplices)),
        unknowns: unknowns(conditions, own),
        transfer,
        simplices,
        stiffness: stiffness.collect(),
        sizes: (mesh.geometry.iter())
            .map(|shape| shape.size() as f32)
            .collect(),
    }
}

fn unknowns<const D: usize, const N: usize>(
    conditions: &Conditions<'_, D, N>,
    order: &[u32],
) -> Unknowns<N> {
    let constraints = conditions.constraints;
    let mut frames = Vec::new();
    let mut number = |&node: &u32| match &constraints.frames[node as usize] {
        None => NO_FRAME,
        Some(frame) => {
            let mut turn = [[0.0; N]; N];
            turn[D][D] = 1.0;
            for (k, direction) in frame.directions().iter().enumerate() {
                (0..D).for_each(|d| turn[d][k] = direction[d]);
            }
            frames.push(turn);
            frames.len() as u32 - 1
        }
    };
    let frame = order.iter().map(&mut number).collect();
    let given = constraints.fixed_but_pins();
    let fixed = |&node: &u32| std::array::from_fn(|q| given[N * node as usize + q]);
    Unknowns {
        fixed: order.iter().map(fixed).collect(),
        frame,
        frames,
    }
}

/// Nodes layer by layer across the longest side, in each line by line: the order in which an incomplete factor is
/// the best and a complete one narrow.
fn lexicographic<const D: usize>(position: &[Vector<D>]) -> Vec<u32> {
    let first = position.first().copied().unwrap_or_else(Vector::zeros);
    let ends = position
        .iter()
        .fold([first; 2], |[lower, upper], x| [lower.inf(x), upper.sup(x)]);
    let extent = ends[1] - ends[0];
    let mut axes: [usize; D] = std::array::from_fn(|d| d);
    axes.sort_by(|&a, &b| extent[b].total_cmp(&extent[a]));
    let mut order: Vec<u32> = (0..position.len() as u32).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (&position[a as usize], &position[b as usize]);
        let by_axis = axes.iter().map(|&d| a[d].total_cmp(&b[d]));
        by_axis.fold(Ordering::Equal, Ordering::then)
    });
    order
}

/// The rank of each node in an order.
pub(super) fn inverse(order: &[u32]) -> Vec<u32> {
    let mut rank = vec![0; order.len()];
    for (k, &node) in order.iter().enumerate() {
        rank[node as usize] = k as u32;
    }
    rank
}

/// The blocks of a system, its nodes in this order.
fn rows_of<const N: usize>(pattern: &Pattern<N>, order: &[u32]) -> Rows {
    let rank = inverse(order);
    let mut rows = Rows::with_capacity(order.len(), pattern.neighbour.len());
    let mut columns = Vec::new();
    for &node in order {
        columns.clear();
        let neighbours = pattern.neighbours(node as usize).iter();
        columns.extend(neighbours.map(|&other| rank[other]));
        columns.sort_unstable();
        rows.push(&columns);
    }
    rows
}
