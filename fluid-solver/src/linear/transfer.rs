//! Between a mesh and a coarser one: linear interpolation, its transpose, and the matrix between both.
//!
//! ```text
//!   x_i = Σ_I P_iI X_I,      R_I = Σ_i P_iI r_i,      A_IJ = Σ_ij P_iI A_ij P_jJ
//! ```
//!
//! P acts along the axes. Velocity unknowns of nodes on oblique walls are along their frames, so their blocks are
//! turned back before, and forth after; fixed unknowns take no part.

use std::sync::Arc;

use super::block_rows::{Block, BlockRows, Node, Rows};

/// The unknowns of a mesh that are no plain components along the axes.
#[derive(Debug, Clone)]
pub struct Unknowns<const N: usize> {
    /// Is the unknown given?
    pub fixed: Vec<[bool; N]>,
    /// For each node the number of its frame, or [`NO_FRAME`].
    pub frame: Vec<u32>,
    /// Frames: row k holds the direction of unknown k, column by column.
    pub frames: Vec<[[f64; N]; N]>,
}

/// Along the axes.
pub const NO_FRAME: u32 = u32::MAX;

impl<const N: usize> Unknowns<N> {
    /// The frame of a node.
    #[inline]
    fn frame(&self, node: usize) -> Option<&[[f64; N]; N]> {
        self.frames.get(self.frame[node] as usize)
    }

    /// Components along the axes, without the fixed ones.
    #[inline]
    fn free_along_axes(&self, node: usize, values: &Node<N>) -> Node<N> {
        let fixed = &self.fixed[node];
        let free: Node<N> = std::array::from_fn(|q| if fixed[q] { 0.0 } else { values[q] });
        match self.frame(node) {
            None => free,
            Some(frame) => std::array::from_fn(|d| {
                let terms = (0..N).map(|k| frame[d][k] as f32 * free[k]);
                terms.sum()
            }),
        }
    }

    /// Unknowns from components along the axes; fixed ones are 0.
    #[inline]
    fn along_frame(&self, node: usize, values: &Node<N>) -> Node<N> {
        let turned = match self.frame(node) {
            None => *values,
            Some(frame) => std::array::from_fn(|k| {
                let terms = (0..N).map(|d| frame[d][k] as f32 * values[d]);
                terms.sum()
            }),
        };
        let fixed = &self.fixed[node];
        std::array::from_fn(|q| if fixed[q] { 0.0 } else { turned[q] })
    }

    /// The block between two nodes, along the axes and without the 1 of fixed unknowns.
    #[inline]
    fn block_along_axes(&self, row: usize, column: usize, block: &Block<N>) -> [[f64; N]; N] {
        let mut block = block.map(|values| values.map(f64::from));
        if row == column {
            let fixed = &self.fixed[row];
            (0..N).filter(|&q| fixed[q]).for_each(|q| block[q][q] = 0.0);
        }
        if let Some(frame) = self.frame(row) {
            for values in &mut block {
                let along: [f64; N] = *values;
                *values = std::array::from_fn(|d| (0..N).map(|k| frame[d][k] * along[k]).sum());
            }
        }
        if let Some(frame) = self.frame(column) {
            let along = block;
            block = std::array::from_fn(|d| {
                std::array::from_fn(|q| (0..N).map(|k| frame[d][k] * along[k][q]).sum())
            });
        }
        block
    }

    /// The block of the unknowns between two nodes from that along the axes; rows and columns of fixed unknowns are
    /// those of the identity.
    #[inline]
    fn block_from_axes(&self, row: usize, column: usize, block: &[[f64; N]; N]) -> Block<N> {
        let mut block = *block;
        if let Some(frame) = self.frame(row) {
            for values in &mut block {
                let along: [f64; N] = *values;
                *values = std::array::from_fn(|k| (0..N).map(|d| frame[d][k] * along[d]).sum());
            }
        }
        if let Some(frame) = self.frame(column) {
            let along = block;
            block = std::array::from_fn(|k| {
                std::array::from_fn(|q| (0..N).map(|d| frame[d][k] * along[d][q]).sum())
            });
        }
        self.fix(row, column, &block)
    }

    /// The block between two nodes with rows and columns of fixed unknowns made those of the identity.
    #[inline]
    pub fn fix(&self, row: usize, column: usize, block: &[[f64; N]; N]) -> Block<N> {
        let (rows, columns) = (&self.fixed[row], &self.fixed[column]);
        std::array::from_fn(|c| {
            std::array::from_fn(|r| match rows[r] || columns[c] {
                false => block[c][r] as f32,
                true => f32::from(u8::from(row == column && r == c)),
            })
        })
    }

    /// Memory \[bytes\].
    pub fn bytes(&self) -> usize {
        self.fixed.len() * (N + 4) + self.frames.len() * 8 * N * N
    }
}

/// Interpolation from a coarser mesh, by rows and by columns.
#[derive(Debug, Clone)]
pub struct Transfer {
    start: Vec<u32>,
    entry: Vec<(u32, f32)>,
    /// The same by nodes of the coarser mesh.
    coarse_start: Vec<u32>,
    coarse_entry: Vec<(u32, f32)>,
}

impl Transfer {
    /// For each node those of the coarser mesh and their weights; 0 is left out.
    pub fn new<const N: usize>(
        spots: impl Iterator<Item = ([u32; N], [f64; N])>,
        coarse_count: usize,
    ) -> Transfer {
        let (mut start, mut entry) = (vec![0], Vec::new());
        let mut count = vec![0; coarse_count + 1];
        for (nodes, weights) in spots {
            let pairs = nodes.into_iter().zip(weights);
            for (node, weight) in pairs.filter(|(_, weight)| weight.abs() > 1e-12) {
                entry.push((node, weight as f32));
                count[node as usize + 1] += 1;
            }
            start.push(entry.len() as u32);
        }
        for k in 0..coarse_count {
            count[k + 1] += count[k];
        }
        let mut next = count.clone();
        let mut coarse_entry = vec![(0, 0.0); entry.len()];
        for (fine, range) in start.windows(2).enumerate() {
            for &(node, weight) in &entry[range[0] as usize..range[1] as usize] {
                let slot = &mut next[node as usize];
                coarse_entry[*slot as usize] = (fine as u32, weight);
                *slot += 1;
            }
        }
        Transfer {
            start,
            entry,
            coarse_start: count,
            coarse_entry,
        }
    }

    /// Nodes of the coarser mesh.
    pub fn coarse_count(&self) -> usize {
        self.coarse_start.len() - 1
    }

    #[inline]
    fn of_fine(&self, node: usize) -> &[(u32, f32)] {
        &self.entry[self.start[node] as usize..self.start[node + 1] as usize]
    }

    #[inline]
    fn of_coarse(&self, node: usize) -> &[(u32, f32)] {
        &self.coarse_entry[self.coarse_start[node] as usize..self.coarse_start[node + 1] as usize]
    }

    /// Pᵀ of values of the nodes.
    pub fn sums<const K: usize>(&self, value: impl Fn(usize) -> [f64; K]) -> Vec<[f64; K]> {
        let sum = |node: usize| {
            let mut sum = [0.0; K];
            for &(fine, weight) in self.of_coarse(node) {
                let value = value(fine as usize);
                (0..K).for_each(|k| sum[k] += f64::from(weight) * value[k]);
            }
            sum
        };
        (0..self.coarse_count()).map(sum).collect()
    }

    /// coarse ← Pᵀ fine; `fine` holds components along the axes afterwards.
    pub fn restrict<const N: usize>(
        &self,
        unknowns: [&Unknowns<N>; 2],
        fine: &mut [Node<N>],
        coarse: &mut [Node<N>],
    ) {
        for (node, values) in fine.iter_mut().enumerate() {
            *values = unknowns[0].free_along_axes(node, values);
        }
        for (node, slot) in coarse.iter_mut().enumerate() {
            let mut sum = [0.0; N];
            for &(other, weight) in self.of_coarse(node) {
                let values = &fine[other as usize];
                (0..N).for_each(|q| sum[q] += weight * values[q]);
            }
            *slot = unknowns[1].along_frame(node, &sum);
        }
    }

    /// fine ← fine + P coarse; `coarse` holds components along the axes afterwards.
    pub fn prolongate<const N: usize>(
        &self,
        unknowns: [&Unknowns<N>; 2],
        coarse: &mut [Node<N>],
        fine: &mut [Node<N>],
    ) {
        for (node, values) in coarse.iter_mut().enumerate() {
            *values = unknowns[1].free_along_axes(node, values);
        }
        for (node, slot) in fine.iter_mut().enumerate() {
            let mut sum = [0.0; N];
            for &(other, weight) in self.of_fine(node) {
                let values = &coarse[other as usize];
                (0..N).for_each(|q| sum[q] += weight * values[q]);
            }
            let sum = unknowns[0].along_frame(node, &sum);
            (0..N).for_each(|q| slot[q] += sum[q]);
        }
    }

    /// The blocks of Pᵀ A P, those between nodes of a coarse simplex among them.
    pub fn coarse_rows<const N: usize>(&self, fine: &Rows, simplices: &[[u32; N]]) -> Rows {
        let mut of_node: Vec<Vec<u32>> = vec![Vec::new(); self.coarse_count()];
        for nodes in simplices {
            for &node in nodes {
                of_node[node as usize].extend_from_slice(nodes);
            }
        }
        let mut rows = Rows::with_capacity(of_node.len(), 16 * of_node.len());
        for (node, mut columns) in of_node.into_iter().enumerate() {
            columns.push(node as u32);
            columns.sort_unstable();
            columns.dedup();
            for &(row, _) in self.of_coarse(node) {
                for &column in &fine.column[fine.range(row as usize)] {
                    for &(other, _) in self.of_fine(column as usize) {
                        // Seldom one that is not there: only where meshes are not nested.
                        if let Err(place) = columns.binary_search(&other) {
                            columns.insert(place, other);
                        }
                    }
                }
            }
            rows.push(&columns);
        }
        rows
    }

    /// coarse ← Pᵀ fine P
    pub fn galerkin<const N: usize>(
        &self,
        unknowns: [&Unknowns<N>; 2],
        fine: &BlockRows<N>,
        coarse: &mut BlockRows<N>,
    ) {
        let rows = Arc::clone(&coarse.rows);
        let mut place = vec![0_u32; rows.len()];
        let mut sums: Vec<[[f64; N]; N]> = Vec::new();
        for node in 0..rows.len() {
            let range = rows.range(node);
            let columns = &rows.column[range.clone()];
            for (k, &column) in columns.iter().enumerate() {
                place[column as usize] = k as u32;
            }
            sums.clear();
            sums.resize(columns.len(), [[0.0; N]; N]);
            for &(row, weight) in self.of_coarse(node) {
                let row = row as usize;
                for k in fine.rows.range(row) {
                    let column = fine.rows.column[k] as usize;
                    let block = unknowns[0].block_along_axes(row, column, &fine.blocks[k]);
                    for &(other, other_weight) in self.of_fine(column) {
                        let sum = &mut sums[place[other as usize] as usize];
                        let factor = f64::from(weight) * f64::from(other_weight);
                        for (sum, values) in sum.iter_mut().zip(&block) {
                            (0..N).for_each(|q| sum[q] += factor * values[q]);
                        }
                    }
                }
            }
            let slots = coarse.blocks[range].iter_mut().zip(columns);
            for ((slot, &column), sum) in slots.zip(&sums) {
                *slot = unknowns[1].block_from_axes(node, column as usize, sum);
            }
        }
    }

    /// Memory \[bytes\].
    pub fn bytes(&self) -> usize {
        4 * (self.start.len() + self.coarse_start.len()) + 16 * self.entry.len()
    }
}
