//! Matrix and right-hand side, before any unknown is fixed.

use super::pattern::{Block, Pattern};

/// The assembled equations.
#[derive(Debug, Clone)]
pub struct System<const N: usize> {
    /// Which entries exist.
    pub pattern: Pattern<N>,
    /// Blocks of the matrix K.
    pub matrix: Vec<Block<N>>,
    /// Right-hand side.
    pub right: Vec<f64>,
}

impl<const N: usize> System<N> {
    /// An empty system on the nodes that simplices couple.
    pub fn new(node_count: usize, simplices: &[[usize; N]]) -> System<N> {
        let pattern = Pattern::new(node_count, simplices);
        let matrix = vec![[[0.0; N]; N]; pattern.blocks()];
        let right = vec![0.0; pattern.unknowns()];
        System {
            pattern,
            matrix,
            right,
        }
    }

    /// Add the right-hand side of an element with these nodes.
    #[inline]
    pub fn add_right(&mut self, nodes: &[usize; N], right: &[[f64; N]; N]) {
        for (values, &node) in right.iter().zip(nodes) {
            for q in 0..N {
                self.right[N * node + q] += values[q];
            }
        }
    }

    /// Add the blocks of the element of simplex `t`, row node first.
    #[inline]
    pub fn add_matrix(&mut self, t: usize, blocks: &[[[[f64; N]; N]; N]; N]) {
        for i in 0..N {
            for j in 0..N {
                let block = &blocks[i][j];
                let columns = std::array::from_fn(|f| std::array::from_fn(|d| block[d][f]));
                self.add_block(t, i, j, &columns);
            }
        }
    }

    /// Add a block of the element of simplex `t`, that of row corner `i` and column corner `j`, column by column.
    #[inline(always)]
    pub fn add_block(&mut self, t: usize, i: usize, j: usize, columns: &Block<N>) {
        let slots = &mut self.matrix[self.pattern.place[t][i][j] as usize];
        for (slots, column) in slots.iter_mut().zip(columns) {
            (0..N).for_each(|d| slots[d] += column[d]);
        }
    }

    /// Neighbours of a node, and the blocks in its rows.
    #[inline]
    pub fn row(&self, node: usize) -> (&[usize], &[Block<N>]) {
        let pattern = &self.pattern;
        (pattern.neighbours(node), &self.matrix[pattern.range(node)])
    }

    /// K x − r, the reaction on each unknown.
    pub fn reaction(&self, x: &[f64]) -> Vec<f64> {
        let mut residual = self.right.clone();
        self.pattern
            .subtract_product(&self.matrix, x, &mut residual);
        residual.iter_mut().for_each(|value| *value = -*value);
        residual
    }
}
