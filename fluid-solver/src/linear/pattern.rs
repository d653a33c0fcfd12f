//! Which entries of the matrix exist.
//!
//! Unknowns are interleaved (u, p) node by node, `N` a node; the matrix is stored by blocks of N × N, row by row: for
//! each node its neighbours in ascending order. Where an element adds its blocks is computed once.

use std::ops::Range;

/// A block of the matrix, column by column.
pub type Block<const N: usize> = [[f64; N]; N];

/// Which entries of the matrix exist.
#[derive(Debug, Clone)]
pub struct Pattern<const N: usize> {
    /// Start of the neighbours of each node, and their total at the end.
    pub start: Vec<usize>,
    /// Neighbours (with the node itself), ascending.
    pub neighbour: Vec<usize>,
    /// For each simplex, row corner i and column corner j: the number of the block.
    pub(super) place: Vec<[[u32; N]; N]>,
}

impl<const N: usize> Pattern<N> {
    /// Pattern of the nodes that simplices couple.
    pub fn new(node_count: usize, simplices: &[[usize; N]]) -> Pattern<N> {
        let mut of_node = vec![Vec::new(); node_count];
        for nodes in simplices {
            for &node in nodes {
                of_node[node].extend_from_slice(nodes);
            }
        }
        let mut start = vec![0];
        let mut neighbour = Vec::new();
        for list in &mut of_node {
            list.sort_unstable();
            list.dedup();
            neighbour.extend_from_slice(list);
            start.push(neighbour.len());
        }
        let place = |row: usize, column: usize| {
            let rank = of_node[row].partition_point(|&node| node < column);
            (start[row] + rank) as u32
        };
        let blocks = simplices.iter();
        let place = blocks
            .map(|t| t.map(|row| t.map(|column| place(row, column))))
            .collect();
        Pattern {
            start,
            neighbour,
            place,
        }
    }

    /// Neighbours of a node, with itself, ascending.
    pub fn neighbours(&self, node: usize) -> &[usize] {
        &self.neighbour[self.range(node)]
    }

    /// Numbers of the blocks in the rows of a node.
    #[inline]
    pub fn range(&self, node: usize) -> Range<usize> {
        self.start[node]..self.start[node + 1]
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.start.len() - 1
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        N * self.nodes()
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.neighbour.len()
    }

    /// Start of each column, and row of each entry.
    pub fn columns(&self) -> (Vec<usize>, Vec<usize>) {
        let mut pointers = vec![0];
        let mut rows = Vec::with_capacity(N * N * self.blocks());
        for node in 0..self.nodes() {
            for _ in 0..N {
                for &other in self.neighbours(node) {
                    rows.extend(N * other..N * other + N);
                }
                pointers.push(rows.len());
            }
        }
        (pointers, rows)
    }

    /// The entries in the order of [`Pattern::columns`].
    pub fn by_columns(&self, blocks: &[Block<N>]) -> Vec<f64> {
        let mut entries = vec![0.0; N * N * self.blocks()];
        let mut above = vec![0; self.nodes()];
        for row in 0..self.nodes() {
            for (&column, block) in self.neighbours(row).iter().zip(&blocks[self.range(row)]) {
                // blocks have neighbours on both sides of the diagonal, so a column is as long as its row
                let own = self.range(column);
                for (f, values) in block.iter().enumerate() {
                    let at = N * N * own.start + N * (f * own.len() + above[column]);
                    entries[at..at + N].copy_from_slice(values);
                }
                above[column] += 1;
            }
        }
        entries
    }

    /// Call `visit(row, column, value)` for every entry, row by row of the blocks.
    #[inline]
    pub fn for_each(&self, blocks: &[Block<N>], mut visit: impl FnMut(usize, usize, f64)) {
        for node in 0..self.nodes() {
            for (&other, block) in self.neighbours(node).iter().zip(&blocks[self.range(node)]) {
                for (f, values) in block.iter().enumerate() {
                    for (d, &value) in values.iter().enumerate() {
                        visit(N * node + d, N * other + f, value);
                    }
                }
            }
        }
    }

    /// y ← y − K x.
    pub fn subtract_product(&self, blocks: &[Block<N>], x: &[f64], y: &mut [f64]) {
        self.subtract_products(blocks, [x], [y]);
    }

    /// y ← y − K x of several x in one go through the matrix.
    pub fn subtract_products<const K: usize>(
        &self,
        blocks: &[Block<N>],
        x: [&[f64]; K],
        y: [&mut [f64]; K],
    ) {
        let x = x.map(|x| x.as_chunks::<N>().0);
        let mut y = y.map(|y| y.as_chunks_mut::<N>().0);
        for node in 0..self.nodes() {
            let mut rows: [[f64; N]; K] = std::array::from_fn(|k| y[k][node]);
            for (&other, block) in self.neighbours(node).iter().zip(&blocks[self.range(node)]) {
                for k in 0..K {
                    let values = &x[k][other];
                    for (column, value) in block.iter().zip(values) {
                        (0..N).for_each(|d| rows[k][d] -= column[d] * value);
                    }
                }
            }
            (0..K).for_each(|k| y[k][node] = rows[k]);
        }
    }
}
