//! Matrix and right-hand side, before any unknown is fixed.

use super::pattern::Pattern;

/// The assembled equations.
#[derive(Debug, Clone)]
pub struct System<const N: usize> {
    /// Which entries exist.
    pub pattern: Pattern<N>,
    /// Entries of the matrix K.
    pub matrix: Vec<f64>,
    /// Right-hand side.
    pub right: Vec<f64>,
}

impl<const N: usize> System<N> {
    /// An empty system on the nodes that simplices couple.
    pub fn new(node_count: usize, simplices: &[[usize; N]]) -> System<N> {
        let pattern = Pattern::new(node_count, simplices);
        let (matrix, right) = (vec![0.0; pattern.entries()], vec![0.0; pattern.unknowns()]);
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
        let place = &self.pattern.place[t];
        for i in 0..N {
            for j in 0..N {
                let (begin, stride) = place[i][j];
                for f in 0..N {
                    let at = begin as usize + f * stride as usize;
                    for (d, slot) in self.matrix[at..at + N].iter_mut().enumerate() {
                        *slot += blocks[i][j][d][f];
                    }
                }
            }
        }
    }

    /// The block in the columns of a node and the rows of its `k`-th neighbour, column by column.
    #[inline]
    pub fn block(&self, node: usize, k: usize) -> [[f64; N]; N] {
        let pattern = &self.pattern;
        let begin = N * N * pattern.start[node] + N * k;
        let stride = N * pattern.neighbours(node).len();
        std::array::from_fn(|f| {
            let column = &self.matrix[begin + f * stride..][..N];
            std::array::from_fn(|d| column[d])
        })
    }

    /// Add a block of the element of simplex `t`, that of row corner `i` and column corner `j`, column by column.
    #[inline(always)]
    pub fn add_block(&mut self, t: usize, i: usize, j: usize, columns: &[[f64; N]; N]) {
        let (begin, stride) = self.pattern.place[t][i][j];
        for (f, column) in columns.iter().enumerate() {
            let at = begin as usize + f * stride as usize;
            let slots = &mut self.matrix[at..at + N];
            for d in 0..N {
                slots[d] += column[d];
            }
        }
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
