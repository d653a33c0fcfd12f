//! Which entries of the matrix exist.
//!
//! Unknowns are interleaved (u, p) node by node, `N` a node; the matrix is stored by columns. Column
//! Nj+f holds, for each neighbour i of j in ascending order, the N rows of i. Where an element adds
//! its block is computed once.

/// Which entries of the matrix exist.
#[derive(Debug, Clone)]
pub struct Pattern<const N: usize> {
    /// Start of the neighbours of each node, and their total at the end.
    pub start: Vec<usize>,
    /// Neighbours (with the node itself), ascending.
    pub neighbour: Vec<usize>,
    /// For each simplex, row corner i and column corner j: where the block begins and how far
    /// its columns are apart.
    pub(super) place: Vec<[[(u32, u32); N]; N]>,
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
        let place = |column: usize, row: usize| {
            let list = &of_node[column];
            let rank = list.partition_point(|&node| node < row);
            let begin = N * N * start[column] + N * rank;
            (begin as u32, (N * list.len()) as u32)
        };
        let blocks = simplices.iter();
        let place = blocks
            .map(|t| t.map(|row| t.map(|column| place(column, row))))
            .collect();
        Pattern {
            start,
            neighbour,
            place,
        }
    }

    /// Neighbours of a node, with itself, ascending.
    pub fn neighbours(&self, node: usize) -> &[usize] {
        &self.neighbour[self.start[node]..self.start[node + 1]]
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        N * (self.start.len() - 1)
    }

    /// Number of entries.
    pub fn entries(&self) -> usize {
        N * N * self.neighbour.len()
    }

    /// Start of each column, and row of each entry.
    pub fn columns(&self) -> (Vec<usize>, Vec<usize>) {
        let mut pointers = vec![0];
        let mut rows = Vec::with_capacity(self.entries());
        for list in self.start.windows(2) {
            for _ in 0..N {
                for &node in &self.neighbour[list[0]..list[1]] {
                    rows.extend(N * node..N * node + N);
                }
                pointers.push(rows.len());
            }
        }
        (pointers, rows)
    }

    /// Call `visit(row, column, value)` for every entry, column by column.
    #[inline]
    pub fn for_each(&self, values: &[f64], mut visit: impl FnMut(usize, usize, f64)) {
        let mut entry = values.iter();
        for (node, list) in self.start.windows(2).enumerate() {
            for column in N * node..N * node + N {
                for &other in &self.neighbour[list[0]..list[1]] {
                    for row in N * other..N * other + N {
                        if let Some(&value) = entry.next() {
                            visit(row, column, value);
                        }
                    }
                }
            }
        }
    }

    /// y ← y − K x.
    pub fn subtract_product(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        self.for_each(values, |row, column, value| y[row] -= value * x[column]);
    }
}
