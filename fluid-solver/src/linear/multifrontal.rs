//! Multifrontal LU on the fronts of a nested dissection, N unknowns a node.
//!
//! ```text
//!   front   ⎡F11 F12⎤   pivots       F11 = Pᵀ L11 U11      partial pivoting inside the front
//!           ⎣F21 F22⎦   boundary     L21 = F21 U11⁻¹,  U12 = L11⁻¹ P F12
//!                                    F22 ← F22 − L21 U12   handed to the parent
//! ```
//!
//! After Duff and Reid (1983). Rows are exchanged within the pivot block only; what that costs in
//! accuracy the iterative refinement of the caller repairs, and it falls back on a factor with
//! exchanges anywhere where it cannot. Fronts are computed one by one in a fixed order or, subtree
//! by subtree, on several threads: the numbers are the same.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
};
use faer::{Accum, MatMut, MatRef, Par};

use space::Vector;

use super::dissection::{self, Front};
use super::pattern::{self, Pattern};

/// Subtrees with fewer fronts are not worth another thread.
const FRONTS_SHARED: usize = 16;

/// Structure and numbers of the factor.
pub struct Multifrontal<const N: usize> {
    plans: Vec<Plan<N>>,
    factors: Vec<Factor>,
}

/// What a front is made of.
struct Plan<const N: usize> {
    front: Front,
    /// Blocks of the matrix that are assembled here.
    blocks: Vec<Block>,
    /// For each child, the local node of each node of its boundary.
    maps: Vec<Vec<u32>>,
}

/// An N×N block of the matrix: its number, and the local nodes of its row and column.
#[derive(Clone, Copy)]
struct Block {
    source: u32,
    row: u32,
    column: u32,
}

/// Numbers of a front, column by column.
#[derive(Default)]
struct Factor {
    /// F11 over F21, then L11\U11 over L21: all rows, pivot columns.
    left: Vec<f64>,
    /// U12: pivot rows, boundary columns.
    top: Vec<f64>,
    /// F22, until the parent takes it.
    rest: Vec<f64>,
    /// Row of F11 that comes to each place.
    exchange: Vec<u32>,
}

impl<const N: usize> Multifrontal<N> {
    /// Analyse a pattern on nodes with these positions.
    pub fn new<const D: usize>(pattern: &Pattern<N>, position: &[Vector<D>]) -> Self {
        let fronts = dissection::fronts(pattern, position);
        let blocks = share_blocks(pattern, &fronts);
        let mut local = vec![u32::MAX; position.len()];
        let mut plans: Vec<Plan<N>> = Vec::with_capacity(fronts.len());
        for (front, mut blocks) in fronts.into_iter().zip(blocks) {
            for (k, &node) in front.pivots.iter().chain(&front.boundary).enumerate() {
                local[node] = k as u32;
            }
            for block in &mut blocks {
                block.row = local[block.row as usize];
                block.column = local[block.column as usize];
            }
            let map = |&child: &usize| {
                let boundary: &Vec<usize> = &plans[child].front.boundary;
                boundary.iter().map(|&node| local[node]).collect()
            };
            let maps = front.children.iter().map(map).collect();
            plans.push(Plan {
                front,
                blocks,
                maps,
            });
        }
        let factors = plans.iter().map(|_| Factor::default()).collect();
        Multifrontal { plans, factors }
    }

    /// Factorise the matrix with these blocks, on the threads of the present pool.
    pub fn factorise(&mut self, values: &[pattern::Block<N>]) {
        let shared = rayon::current_num_threads() > 1;
        factor_range(
            &self.plans,
            &mut self.factors,
            0,
            values,
            shared,
            &mut Workspace::default(),
        );
    }

    /// x ← (LU)⁻¹ x
    pub fn solve(&self, x: &mut [f64]) {
        let mut local = Vec::new();
        for (plan, factor) in self.plans.iter().zip(&self.factors) {
            plan.forward(factor, x, &mut local);
        }
        for (plan, factor) in self.plans.iter().zip(&self.factors).rev() {
            plan.backward(factor, x, &mut local);
        }
    }

    /// Entries of the factor.
    pub fn entries(&self) -> usize {
        self.factors
            .iter()
            .map(|factor| factor.left.len() + factor.top.len())
            .sum()
    }
}

/// Blocks by the front that eliminates the earlier of their two nodes; nodes are still global.
fn share_blocks<const N: usize>(pattern: &Pattern<N>, fronts: &[Front]) -> Vec<Vec<Block>> {
    let rank = dissection::ranks(fronts);
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
            blocks[of_node[earlier]].push(Block {
                source: (pattern.start[row] + k) as u32,
                row: row as u32,
                column: column as u32,
            });
        }
    }
    blocks
}

/// Buffers that outlive a front.
#[derive(Default)]
struct Workspace {
    spare: Vec<Vec<f64>>,
    column: Vec<f64>,
}

/// Factorise the fronts of a range that ends a subtree; `base` is the number of the first.
fn factor_range<const N: usize>(
    plans: &[Plan<N>],
    factors: &mut [Factor],
    base: usize,
    values: &[pattern::Block<N>],
    shared: bool,
    workspace: &mut Workspace,
) {
    let root = plans.len() - 1;
    let children = &plans[root].front.children;
    if shared && plans.len() > FRONTS_SHARED && children.len() == 2 {
        let split = children[0] + 1 - base;
        let (low_plans, high_plans) = plans[..root].split_at(split);
        let (low, high) = factors[..root].split_at_mut(split);
        rayon::join(
            || factor_range(low_plans, low, base, values, true, workspace),
            || {
                factor_range(
                    high_plans,
                    high,
                    base + split,
                    values,
                    true,
                    &mut Workspace::default(),
                )
            },
        );
        factor_front(
            &plans[root],
            factors,
            base,
            values,
            &mut Workspace::default(),
        );
        return;
    }
    for k in 0..plans.len() {
        factor_front(&plans[k], &mut factors[..=k], base, values, workspace);
    }
}

/// Assemble and eliminate the last front of `factors`.
fn factor_front<const N: usize>(
    plan: &Plan<N>,
    factors: &mut [Factor],
    base: usize,
    values: &[pattern::Block<N>],
    workspace: &mut Workspace,
) {
    let (done, last) = factors.split_at_mut(factors.len() - 1);
    let factor = &mut last[0];
    let (p, b) = plan.sizes();
    let clear = |buffer: &mut Vec<f64>, length: usize| {
        buffer.clear();
        buffer.resize(length, 0.0);
    };
    factor.rest = workspace.spare.pop().unwrap_or_default();
    clear(&mut factor.left, (p + b) * p);
    clear(&mut factor.top, p * b);
    clear(&mut factor.rest, b * b);
    plan.assemble(factor, values);
    for (&child, map) in plan.front.children.iter().zip(&plan.maps) {
        let rest = std::mem::take(&mut done[child - base].rest);
        plan.add_child(factor, map, &rest);
        workspace.spare.push(rest);
    }
    eliminate(factor, p, b, &mut workspace.column);
}

/// Factorise the pivot block and update the rest.
fn eliminate(factor: &mut Factor, p: usize, b: usize, column: &mut Vec<f64>) {
    let mut memory = MemBuffer::new(StackReq::or(
        lu_in_place_scratch::<u32, f64>(p, p, Par::Seq, Default::default()),
        StackReq::empty(),
    ));
    let left = MatMut::from_column_major_slice_mut(&mut factor.left, p + b, p);
    let (mut pivot, below) = left.split_at_row_mut(p);
    let mut inverse = vec![0; p];
    factor.exchange.resize(p, 0);
    lu_in_place(
        pivot.as_mut(),
        &mut factor.exchange,
        &mut inverse,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    );
    if b == 0 {
        return;
    }
    let pivot = pivot.as_ref();
    for values in factor.top.chunks_exact_mut(p) {
        column.clear();
        column.extend(factor.exchange.iter().map(|&row| values[row as usize]));
        values.copy_from_slice(column);
    }
    let mut below = below;
    let mut top = MatMut::from_column_major_slice_mut(&mut factor.top, p, b);
    solve_unit_lower_triangular_in_place(pivot, top.as_mut(), Par::Seq);
    solve_lower_triangular_in_place(pivot.transpose(), below.as_mut().transpose_mut(), Par::Seq);
    let rest = MatMut::from_column_major_slice_mut(&mut factor.rest, b, b);
    let (below, top): (MatRef<'_, f64>, MatRef<'_, f64>) = (below.as_ref(), top.as_ref());
    matmul(rest, Accum::Add, below, top, -1.0, Par::Seq);
}

impl<const N: usize> Plan<N> {
    /// Unknowns eliminated here and left to the boundary.
    fn sizes(&self) -> (usize, usize) {
        (N * self.front.pivots.len(), N * self.front.boundary.len())
    }

    /// Add the blocks of the matrix.
    fn assemble(&self, factor: &mut Factor, values: &[pattern::Block<N>]) {
        let (p, b) = self.sizes();
        for block in &self.blocks {
            let row = N * block.row as usize;
            for (f, values) in values[block.source as usize].iter().enumerate() {
                let column = N * block.column as usize + f;
                let target = target_column(factor, (p, b), column, row);
                target[..N].copy_from_slice(values);
            }
        }
    }

    /// Add what a child left over.
    fn add_child(&self, factor: &mut Factor, map: &[u32], rest: &[f64]) {
        let (p, b) = self.sizes();
        if map.is_empty() {
            return;
        }
        for (index, values) in rest.chunks_exact(N * map.len()).enumerate() {
            let column = N * map[index / N] as usize + index % N;
            // Local nodes of a child's boundary ascend: first pivots of this front, then its rest.
            let split = map.partition_point(|&node| N * (node as usize) < p);
            for (part, nodes) in [(0, &map[..split]), (split, &map[split..])] {
                let Some(&first) = nodes.first() else {
                    continue;
                };
                let begin = N * first as usize;
                let target = target_column(factor, (p, b), column, begin);
                for (k, &node) in nodes.iter().enumerate() {
                    let at = N * node as usize - begin;
                    let from = N * (part + k);
                    for d in 0..N {
                        target[at + d] += values[from + d];
                    }
                }
            }
        }
    }

    /// L y = P x on this front.
    fn forward(&self, factor: &Factor, x: &mut [f64], local: &mut Vec<f64>) {
        let (p, b) = self.sizes();
        local.clear();
        local.extend(factor.exchange.iter().map(|&row| {
            let row = row as usize;
            x[N * self.front.pivots[row / N] + row % N]
        }));
        local.resize(p + b, 0.0);
        for (k, column) in factor.left.chunks_exact(p + b).enumerate() {
            let value = local[k];
            for (target, entry) in local[k + 1..].iter_mut().zip(&column[k + 1..]) {
                *target -= entry * value;
            }
        }
        let nodes = self.front.pivots.iter().zip(local[..p].chunks_exact(N));
        nodes.for_each(|(&node, values)| x[N * node..N * node + N].copy_from_slice(values));
        for (&node, values) in self.front.boundary.iter().zip(local[p..].chunks_exact(N)) {
            for (d, value) in values.iter().enumerate() {
                x[N * node + d] += value;
            }
        }
    }

    /// U x = y on this front.
    fn backward(&self, factor: &Factor, x: &mut [f64], local: &mut Vec<f64>) {
        let (p, b) = self.sizes();
        local.clear();
        for &node in &self.front.pivots {
            local.extend_from_slice(&x[N * node..N * node + N]);
        }
        for (k, column) in factor.top.chunks_exact(p).enumerate() {
            let value = x[N * self.front.boundary[k / N] + k % N];
            for (target, entry) in local.iter_mut().zip(column) {
                *target -= entry * value;
            }
        }
        for (k, column) in factor.left.chunks_exact(p + b).enumerate().rev() {
            local[k] /= column[k];
            let value = local[k];
            for (target, entry) in local[..k].iter_mut().zip(column) {
                *target -= entry * value;
            }
        }
        for (&node, values) in self.front.pivots.iter().zip(local.chunks_exact(N)) {
            x[N * node..N * node + N].copy_from_slice(values);
        }
    }
}

/// Column `column` of a front from row `row` on, in the part that holds both.
#[inline]
fn target_column(
    factor: &mut Factor,
    (p, b): (usize, usize),
    column: usize,
    row: usize,
) -> &mut [f64] {
    if column < p {
        &mut factor.left[column * (p + b) + row..(column + 1) * (p + b)]
    } else if row < p {
        &mut factor.top[(column - p) * p + row..(column - p + 1) * p]
    } else {
        &mut factor.rest[(column - p) * b + row - p..(column - p + 1) * b]
    }
}
