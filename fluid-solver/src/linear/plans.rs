//! Structure of a factor: what each front is made of.

use super::eliminate::Shape;
use super::order::{self, Front};
use super::pattern::Pattern;
use crate::error::FluidError;

/// Structure of a factor.
pub struct Plans<const N: usize> {
    /// Children before parents.
    pub fronts: Vec<Plan<N>>,
    /// Fronts that hand over nothing.
    pub roots: Vec<usize>,
}

/// What a front is made of.
pub struct Plan<const N: usize> {
    /// Its nodes.
    pub front: Front,
    /// Its sizes.
    pub shape: Shape,
    /// Operations of the subtree that ends here.
    pub operations: f64,
    /// Blocks of the matrix that are assembled here.
    pub blocks: Vec<Source>,
    /// For each child, the runs of its boundary.
    pub runs: Vec<Vec<Run>>,
}

/// An N×N block of the matrix.
#[derive(Clone, Copy)]
pub struct Source {
    /// Its number.
    pub number: u32,
    /// Local node of its row.
    pub row: u32,
    /// Local node of its column.
    pub column: u32,
}

/// Consecutive unknowns of a child's boundary that are consecutive in its parent, too, and on one side there.
#[derive(Clone, Copy)]
pub struct Run {
    /// First unknown in the child's boundary.
    pub from: u32,
    /// First unknown in the parent.
    pub to: u32,
    /// Unknowns.
    pub length: u32,
}

impl<const N: usize> Plans<N> {
    /// Analyse a pattern.
    pub fn new(pattern: &Pattern<N>) -> Result<Plans<N>, FluidError> {
        let fronts = order::fronts(pattern)?;
        let blocks = share_blocks(pattern, &fronts);
        let mut local = vec![u32::MAX; pattern.nodes()];
        let mut plans: Vec<Plan<N>> = Vec::with_capacity(fronts.len());
        let mut roots = Vec::new();
        for (front, mut blocks) in fronts.into_iter().zip(blocks) {
            for (k, &node) in front.pivots.iter().chain(&front.boundary).enumerate() {
                local[node] = k as u32;
            }
            for block in &mut blocks {
                block.row = local[block.row as usize];
                block.column = local[block.column as usize];
            }
            let shape = Shape::new(N * front.pivots.len(), N * front.boundary.len());
            let runs = |&child: &usize| runs::<N>(&plans[child].front, &local, shape.pivots);
            let below = front.children.iter().map(|&child| plans[child].operations);
            let own = order::operations(shape.pivots, shape.boundary);
            if front.boundary.is_empty() {
                roots.push(plans.len());
            }
            plans.push(Plan {
                operations: own + below.sum::<f64>(),
                runs: front.children.iter().map(runs).collect(),
                front,
                shape,
                blocks,
            });
        }
        Ok(Plans {
            fronts: plans,
            roots,
        })
    }
}

/// Runs of a child's boundary; `local` are the nodes of the parent.
fn runs<const N: usize>(child: &Front, local: &[u32], pivots: usize) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (k, &node) in child.boundary.iter().enumerate() {
        let to = N as u32 * local[node];
        match runs.last_mut() {
            Some(run) if run.to + run.length == to && to as usize != pivots => {
                run.length += N as u32;
            }
            _ => runs.push(Run {
                from: (N * k) as u32,
                to,
                length: N as u32,
            }),
        }
    }
    runs
}

/// Blocks by the front that eliminates the earlier of their two nodes; nodes are still global.
fn share_blocks<const N: usize>(pattern: &Pattern<N>, fronts: &[Front]) -> Vec<Vec<Source>> {
    let rank = order::ranks(fronts);
    let mut of_node = vec![0; rank.len()];
    for (k, front) in fronts.iter().enumerate() {
        front.pivots.iter().for_each(|&node| of_node[node] = k);
    }
    let mut blocks = vec![Vec::new(); fronts.len()];
    for row in 0..rank.len() {
        for (k, &column) in pattern.neighbours(row).iter().enumerate() {
            let earlier = if rank[row] < rank[column] {
                row
            } else {
                column
            };
            blocks[of_node[earlier]].push(Source {
                number: (pattern.start[row] + k) as u32,
                row: row as u32,
                column: column as u32,
            });
        }
    }
    blocks
}
