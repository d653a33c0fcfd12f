//! A matrix of N×N blocks in single precision, row by row: what preconditioners are made of.

use std::sync::Arc;

/// A block, column by column.
pub type Block<const N: usize> = [[f32; N]; N];

/// Unknowns of one node.
pub type Node<const N: usize> = [f32; N];

/// Which blocks exist: for each row its columns, ascending, the diagonal among them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rows {
    /// Where each row begins, and the total at the end.
    pub start: Vec<u32>,
    /// Columns of the blocks.
    pub column: Vec<u32>,
    /// Where the diagonal block of each row is.
    pub diagonal: Vec<u32>,
}

impl Rows {
    /// No row yet, with room for so many and so many blocks.
    pub fn with_capacity(rows: usize, blocks: usize) -> Rows {
        let mut start = Vec::with_capacity(rows + 1);
        start.push(0);
        Rows {
            start,
            column: Vec::with_capacity(blocks),
            diagonal: Vec::with_capacity(rows),
        }
    }

    /// Add a row with these columns, ascending.
    pub fn push(&mut self, columns: &[u32]) {
        let own = self.len() as u32;
        let before = columns.partition_point(|&column| column < own);
        self.diagonal.push((self.column.len() + before) as u32);
        self.column.extend_from_slice(columns);
        self.start.push(self.column.len() as u32);
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Is there no row?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where the blocks of a row are.
    #[inline]
    pub fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.start[row] as usize..self.start[row + 1] as usize
    }

    /// Memory \[bytes\].
    pub fn bytes(&self) -> usize {
        4 * (self.start.len() + self.column.len() + self.diagonal.len())
    }
}

/// A matrix.
#[derive(Debug, Clone)]
pub struct BlockRows<const N: usize> {
    /// Which blocks exist.
    pub rows: Arc<Rows>,
    /// Their numbers.
    pub blocks: Vec<Block<N>>,
}

impl<const N: usize> BlockRows<N> {
    /// Zero.
    pub fn new(rows: Arc<Rows>) -> BlockRows<N> {
        BlockRows {
            blocks: vec![[[0.0; N]; N]; rows.column.len()],
            rows,
        }
    }

    /// Row `row` of r − A x, of which r is given.
    #[inline]
    pub fn row_residual(&self, row: usize, right: &Node<N>, x: &[Node<N>]) -> Node<N> {
        let range = self.rows.range(row);
        let columns = self.rows.column[range.clone()].iter();
        let mut residual = *right;
        for (&column, block) in columns.zip(&self.blocks[range]) {
            subtract(block, &x[column as usize], &mut residual);
        }
        residual
    }

    /// residual ← right − A x
    pub fn residual(&self, right: &[Node<N>], x: &[Node<N>], residual: &mut [Node<N>]) {
        for (row, slot) in residual.iter_mut().enumerate() {
            *slot = self.row_residual(row, &right[row], x);
        }
    }

    /// Memory of the numbers \[bytes\].
    pub fn bytes(&self) -> usize {
        self.blocks.len() * size_of::<Block<N>>()
    }
}

/// y ← y − B x
#[inline(always)]
pub fn subtract<const N: usize>(block: &Block<N>, x: &Node<N>, y: &mut Node<N>) {
    for (column, value) in block.iter().zip(x) {
        for row in 0..N {
            y[row] -= column[row] * value;
        }
    }
}

/// The inverse of a block, by Gauss and Jordan with exchange of rows; none where it has none.
pub fn inverse<const N: usize>(block: &[[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let mut left = *block;
    let mut right = [[0.0; N]; N];
    (0..N).for_each(|k| right[k][k] = 1.0);
    for k in 0..N {
        let pivot = (k..N).fold(k, |best, row| {
            if left[k][row].abs() > left[k][best].abs() {
                row
            } else {
                best
            }
        });
        for columns in [&mut left, &mut right] {
            columns.iter_mut().for_each(|column| column.swap(k, pivot));
        }
        let factor = left[k][k].recip();
        if !factor.is_finite() {
            return None;
        }
        let below = left[k];
        for columns in [&mut left, &mut right] {
            for column in columns {
                column[k] *= factor;
                let value = column[k];
                for row in (0..N).filter(|&row| row != k) {
                    column[row] -= below[row] * value;
                }
            }
        }
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_times_its_inverse_is_one() {
        let block: [[f64; 4]; 4] = [
            [0.0, 2.0, 1.0, -1.0],
            [3.0, 0.5, 0.0, 2.0],
            [1.0, 1.0, -4.0, 0.0],
            [0.0, 0.0, 1.0, 1e-3],
        ];
        let inverse = inverse(&block).unwrap();
        for row in 0..4 {
            for column in 0..4 {
                let sum: f64 = (0..4).map(|k| block[k][row] * inverse[column][k]).sum();
                let exact = f64::from(u8::from(row == column));
                assert!((sum - exact).abs() < 1e-12, "{row} {column}: {sum}");
            }
        }
        assert!(super::inverse(&[[1.0, 2.0], [2.0, 4.0]]).is_none());
    }
}
