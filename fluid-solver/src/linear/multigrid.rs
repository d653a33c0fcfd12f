//! One V-cycle over nested meshes, in single precision, with an incomplete factor before and after.
//!
//! ```text
//!   A_(l+1) = Pᵀ A_l P + k ∫∇q·∇p,      k = (τ_H − τ_h) P²                                            (G1)
//!   x = (LU)⁻¹ b,   x ← x + P x_(l+1)(Pᵀ(b − A x)),   x ← x + (LU)⁻¹ (b − A x)                        (G2)
//! ```
//!
//! The product keeps the pressure stabilisation of the finest mesh, which is too little for a coarser one; k of each
//! coarse simplex is told (`equations::coarse`). The last level is factorised completely, where it is small. A
//! pressure that is known up to a constant is pinned there alone: elsewhere that would be a point load.

use std::sync::Arc;

use super::block_rows::{BlockRows, Node};
use super::hierarchy::Hierarchy;
use super::ilu::{Fill, IncompleteLu};
use super::transfer::Unknowns;

/// Most nodes of a last level that is factorised completely.
const COMPLETE_MAX: usize = 1500;

/// Matrices of all levels, and room for a cycle.
pub struct Multigrid<const N: usize> {
    matrices: Vec<BlockRows<N>>,
    work: Vec<Work<N>>,
}

/// Vectors of a level.
struct Work<const N: usize> {
    right: Vec<Node<N>>,
    x: Vec<Node<N>>,
    residual: Vec<Node<N>>,
    step: Vec<Node<N>>,
}

/// Factors of all levels.
pub struct Smoothers<const N: usize> {
    factors: Vec<IncompleteLu<N>>,
}

impl<const N: usize> Smoothers<N> {
    /// Room for factors with this level of fill.
    pub fn new(matrices: &Multigrid<N>, level: u8) -> Smoothers<N> {
        let matrices = &matrices.matrices;
        let last = matrices.len() - 1;
        let factor = |(l, matrix): (usize, &BlockRows<N>)| {
            let complete = l == last && matrix.rows.len() <= COMPLETE_MAX;
            let fill = if complete {
                Fill::Complete
            } else {
                Fill::Level(level)
            };
            IncompleteLu::new(&matrix.rows, fill)
        };
        Smoothers {
            factors: matrices.iter().enumerate().map(factor).collect(),
        }
    }

    /// Factorise the matrices of all levels; false where one has no factor.
    pub fn factorise(&mut self, matrices: &Multigrid<N>) -> bool {
        let mut pairs = self.factors.iter_mut().zip(&matrices.matrices);
        pairs.all(|(factor, matrix)| factor.factorise(matrix))
    }

    /// Memory \[bytes\].
    pub fn bytes(&self, matrices: &Multigrid<N>) -> usize {
        let pairs = self.factors.iter().zip(&matrices.matrices);
        pairs.map(|(factor, matrix)| factor.bytes(matrix)).sum()
    }
}

impl<const N: usize> Multigrid<N> {
    /// Room for the matrices of a hierarchy.
    pub fn new(hierarchy: &Hierarchy<N>) -> Multigrid<N> {
        let coarse = hierarchy.levels.iter().map(|level| &level.rows);
        let rows: Vec<_> = std::iter::once(&hierarchy.rows).chain(coarse).collect();
        let work = |nodes: usize| {
            let zero = vec![[0.0; N]; nodes];
            Work {
                right: zero.clone(),
                x: zero.clone(),
                residual: zero.clone(),
                step: zero,
            }
        };
        Multigrid {
            matrices: (rows.iter())
                .map(|rows| BlockRows::new(Arc::clone(rows)))
                .collect(),
            work: rows.iter().map(|rows| work(rows.len())).collect(),
        }
    }

    /// The matrix of the mesh itself, to be filled before [`Multigrid::coarsen`].
    pub fn finest(&mut self) -> &mut BlockRows<N> {
        &mut self.matrices[0]
    }

    /// Make the matrices of coarser meshes (G1); `missing` holds k times `weight` of their simplices, level by level.
    pub fn coarsen(&mut self, hierarchy: &Hierarchy<N>, missing: &[Vec<f64>], weight: f64) {
        for (l, level) in hierarchy.levels.iter().enumerate() {
            let (finer, coarser) = self.matrices.split_at_mut(l + 1);
            let pair = unknowns(hierarchy, l);
            level.transfer.galerkin(pair, &finer[l], &mut coarser[0]);
            let simplices = level.simplices.iter().zip(&level.stiffness);
            for ((nodes, stiffness), k) in simplices.zip(&missing[l]) {
                add_laplacian(
                    &mut coarser[0],
                    pair[1],
                    nodes,
                    stiffness,
                    (weight * k) as f32,
                );
            }
        }
        let last = self.matrices.len() - 1;
        let matrix = &mut self.matrices[last];
        for &row in &hierarchy.pinned {
            let diagonal = matrix.rows.diagonal[row as usize] as usize;
            matrix.blocks[diagonal][N - 1][N - 1] *= 2.0;
        }
    }

    /// A cycle for this right-hand side of the finest mesh; returns the solution. (G2)
    pub fn cycle(
        &mut self,
        hierarchy: &Hierarchy<N>,
        smoothers: &Smoothers<N>,
        fill: impl FnOnce(&mut [Node<N>]),
    ) -> &[Node<N>] {
        fill(&mut self.work[0].right);
        let last = self.matrices.len() - 1;
        for l in 0..last {
            let (matrix, factor) = (&self.matrices[l], &smoothers.factors[l]);
            let (finer, coarser) = self.work.split_at_mut(l + 1);
            let work = &mut finer[l];
            factor.solve(&work.right, &mut work.x);
            matrix.residual(&work.right, &work.x, &mut work.residual);
            let pair = unknowns(hierarchy, l);
            let transfer = &hierarchy.levels[l].transfer;
            transfer.restrict(pair, &mut work.residual, &mut coarser[0].right);
        }
        let work = &mut self.work[last];
        smoothers.factors[last].solve(&work.right, &mut work.x);
        for l in (0..last).rev() {
            let (matrix, factor) = (&self.matrices[l], &smoothers.factors[l]);
            let (finer, coarser) = self.work.split_at_mut(l + 1);
            let work = &mut finer[l];
            let transfer = &hierarchy.levels[l].transfer;
            transfer.prolongate(unknowns(hierarchy, l), &mut coarser[0].x, &mut work.x);
            matrix.residual(&work.right, &work.x, &mut work.residual);
            factor.solve(&work.residual, &mut work.step);
            for (x, step) in work.x.iter_mut().zip(&work.step) {
                (0..N).for_each(|q| x[q] += step[q]);
            }
        }
        &self.work[0].x
    }

    /// Memory \[bytes\].
    pub fn bytes(&self) -> usize {
        let matrices: usize = self.matrices.iter().map(BlockRows::bytes).sum();
        let vectors = |work: &Work<N>| 4 * work.x.len() * size_of::<Node<N>>();
        matrices + self.work.iter().map(vectors).sum::<usize>()
    }
}

/// Unknowns of a level and of the next coarser one.
fn unknowns<const N: usize>(hierarchy: &Hierarchy<N>, level: usize) -> [&Unknowns<N>; 2] {
    let fine = match level {
        0 => &hierarchy.unknowns,
        _ => &hierarchy.levels[level - 1].unknowns,
    };
    [fine, &hierarchy.levels[level].unknowns]
}

/// Add k ∫∇q·∇p of a simplex.
fn add_laplacian<const N: usize>(
    matrix: &mut BlockRows<N>,
    unknowns: &Unknowns<N>,
    nodes: &[u32; N],
    stiffness: &[[f32; N]; N],
    k: f32,
) {
    const MISSING: &str = "nodes of a simplex are neighbours";
    for (i, &row) in nodes.iter().enumerate() {
        let range = matrix.rows.range(row as usize);
        for (j, &column) in nodes.iter().enumerate() {
            let fixed = |node: u32| unknowns.fixed[node as usize][N - 1];
            if fixed(row) || fixed(column) {
                continue;
            }
            let columns = &matrix.rows.column[range.clone()];
            let place = columns.binary_search(&column).expect(MISSING);
            matrix.blocks[range.start + place][N - 1][N - 1] += k * stiffness[i][j];
        }
    }
}
