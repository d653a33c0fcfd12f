//! Incomplete LU of a matrix of blocks: fill of a level, or all of it.
//!
//! ```text
//!   level of (i, j) = min over k < i, j of level (i, k) + level (k, j) + 1,  0 where the matrix has a block
//!   L_ik = (A_ik − Σ L_im U_mk) U_kk⁻¹,     U_ij = A_ij − Σ L_im U_mj,       kept up to the level
//! ```
//!
//! Rows are eliminated in their order, without exchange; blocks of the diagonal are inverted with it. Sums of a row
//! are in double precision, what is kept is in single.

use std::collections::BinaryHeap;
use std::{cmp::Reverse, sync::Arc};

use super::block_rows::{Block, BlockRows, Node, Rows, inverse, subtract};

/// How much is filled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fill {
    /// Up to a level.
    Level(u8),
    /// All.
    Complete,
}

/// L and U in one, with inverted diagonal blocks.
#[derive(Debug, Clone)]
pub struct IncompleteLu<const N: usize> {
    factor: BlockRows<N>,
}

impl<const N: usize> IncompleteLu<N> {
    /// Room for the factor of a matrix with these blocks.
    pub fn new(rows: &Arc<Rows>, fill: Fill) -> IncompleteLu<N> {
        let rows = match fill {
            Fill::Level(0) => Arc::clone(rows),
            Fill::Level(level) => Arc::new(filled(rows, Some(level))),
            Fill::Complete => Arc::new(filled(rows, None)),
        };
        IncompleteLu {
            factor: BlockRows::new(rows),
        }
    }

    /// Factorise; false where a block of the diagonal has no inverse.
    pub fn factorise(&mut self, matrix: &BlockRows<N>) -> bool {
        let rows = Arc::clone(&self.factor.rows);
        let mut place = vec![u32::MAX; rows.len()];
        let mut work: Vec<[[f64; N]; N]> = Vec::new();
        for row in 0..rows.len() {
            let range = rows.range(row);
            let columns = &rows.column[range.clone()];
            for (k, &column) in columns.iter().enumerate() {
                place[column as usize] = k as u32;
            }
            work.clear();
            work.resize(columns.len(), [[0.0; N]; N]);
            let given = matrix.rows.range(row);
            let blocks = matrix.rows.column[given.clone()].iter();
            for (&column, block) in blocks.zip(&matrix.blocks[given]) {
                work[place[column as usize] as usize] = block.map(|c| c.map(f64::from));
            }
            let diagonal = rows.diagonal[row] as usize - range.start;
            for k in 0..diagonal {
                self.eliminate(k, columns[k] as usize, &place, &mut work);
            }
            for &column in columns {
                place[column as usize] = u32::MAX;
            }
            match inverse(&work[diagonal]) {
                Some(inverse) => work[diagonal] = inverse,
                None => return false,
            }
            for (slot, block) in self.factor.blocks[range].iter_mut().zip(&work) {
                *slot = block.map(|column| column.map(|value| value as f32));
            }
        }
        true
    }

    /// Take row `pivot` times block `k` from the row in work.
    #[inline]
    fn eliminate(&self, k: usize, pivot: usize, place: &[u32], work: &mut [[[f64; N]; N]]) {
        let (rows, blocks) = (&self.factor.rows, &self.factor.blocks);
        let diagonal = rows.diagonal[pivot] as usize;
        let mut lower = [[0.0; N]; N];
        add_product(&work[k], &blocks[diagonal], &mut lower, 1.0);
        work[k] = lower;
        let right = diagonal + 1..rows.range(pivot).end;
        let columns = rows.column[right.clone()].iter();
        for (&column, upper) in columns.zip(&blocks[right]) {
            if let Some(target) = work.get_mut(place[column as usize] as usize) {
                add_product(&lower, upper, target, -1.0);
            }
        }
    }

    /// x ← (LU)⁻¹ right
    pub fn solve(&self, right: &[Node<N>], x: &mut [Node<N>]) {
        let (rows, blocks) = (&self.factor.rows, &self.factor.blocks);
        for row in 0..rows.len() {
            let lower = rows.start[row] as usize..rows.diagonal[row] as usize;
            let mut sum = right[row];
            let columns = rows.column[lower.clone()].iter();
            for (&column, block) in columns.zip(&blocks[lower]) {
                subtract(block, &x[column as usize], &mut sum);
            }
            x[row] = sum;
        }
        for row in (0..rows.len()).rev() {
            let diagonal = rows.diagonal[row] as usize;
            let upper = diagonal + 1..rows.range(row).end;
            let mut sum = x[row];
            let columns = rows.column[upper.clone()].iter();
            for (&column, block) in columns.zip(&blocks[upper]) {
                subtract(block, &x[column as usize], &mut sum);
            }
            let mut solved = [0.0; N];
            subtract(&blocks[diagonal], &sum, &mut solved);
            x[row] = solved.map(|value| -value);
        }
    }

    /// Memory, without that of the matrix \[bytes\].
    pub fn bytes(&self, matrix: &BlockRows<N>) -> usize {
        let own = !Arc::ptr_eq(&self.factor.rows, &matrix.rows);
        self.factor.bytes() + if own { self.factor.rows.bytes() } else { 0 }
    }
}

/// target ← target + sign A B
#[inline(always)]
fn add_product<const N: usize>(
    a: &[[f64; N]; N],
    b: &Block<N>,
    target: &mut [[f64; N]; N],
    sign: f64,
) {
    for (column, factors) in target.iter_mut().zip(b) {
        for (values, factor) in a.iter().zip(factors) {
            let factor = sign * f64::from(*factor);
            for row in 0..N {
                column[row] += values[row] * factor;
            }
        }
    }
}

/// Blocks of the factor; without a level all.
fn filled(rows: &Rows, level: Option<u8>) -> Rows {
    const NONE: u8 = u8::MAX;
    let mut filled = Rows::with_capacity(rows.len(), rows.column.len());
    // Levels of the blocks right of the diagonal that are there already.
    let mut levels: Vec<Vec<u8>> = Vec::with_capacity(rows.len());
    let mut of_column = vec![NONE; rows.len()];
    let mut left = BinaryHeap::new();
    for row in 0..rows.len() {
        let mut columns = rows.column[rows.range(row)].to_vec();
        for &column in &columns {
            of_column[column as usize] = 0;
            if (column as usize) < row {
                left.push(Reverse(column));
            }
        }
        while let Some(Reverse(pivot)) = left.pop() {
            let pivot = pivot as usize;
            let upper = filled.diagonal[pivot] as usize + 1..filled.range(pivot).end;
            for (&column, &own) in filled.column[upper].iter().zip(&levels[pivot]) {
                let new = match level {
                    Some(level) => {
                        let sum = of_column[pivot] + own + 1;
                        if sum > level {
                            continue;
                        }
                        sum
                    }
                    None => 0,
                };
                let known = &mut of_column[column as usize];
                if *known == NONE {
                    columns.push(column);
                    if (column as usize) < row {
                        left.push(Reverse(column));
                    }
                }
                *known = new.min(*known);
            }
        }
        columns.sort_unstable();
        let right = columns.iter().filter(|&&column| column as usize > row);
        levels.push(right.map(|&column| of_column[column as usize]).collect());
        for &column in &columns {
            of_column[column as usize] = NONE;
        }
        filled.push(&columns);
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_complete_factor_solves_and_fill_comes_level_by_level() {
        // A 7 × 6 grid with neighbours along both axes.
        let (nx, ny) = (7, 6);
        let mut rows = Rows::with_capacity(nx * ny, 0);
        for node in 0..nx * ny {
            let (x, y) = (node % nx, node / nx);
            let near = |other: &usize| (other % nx).abs_diff(x) + (other / nx).abs_diff(y) < 2;
            let columns = (0..nx * ny).filter(near).map(|other| other as u32);
            rows.push(&columns.collect::<Vec<_>>());
        }
        let mut matrix = BlockRows::<2>::new(Arc::new(rows));
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        for block in &mut matrix.blocks {
            *block = [[random(), random()], [random(), random()]];
        }
        for row in 0..nx * ny {
            let block = &mut matrix.blocks[matrix.rows.diagonal[row] as usize];
            (0..2).for_each(|k| block[k][k] += 3.0);
        }
        let right: Vec<Node<2>> = (0..nx * ny).map(|_| [random(), random()]).collect();
        let mut last = f32::INFINITY;
        let fills = [
            Fill::Level(0),
            Fill::Level(1),
            Fill::Level(2),
            Fill::Complete,
        ];
        for fill in fills {
            let mut factor = IncompleteLu::new(&matrix.rows, fill);
            assert!(factor.factorise(&matrix));
            let mut x = vec![[0.0; 2]; nx * ny];
            let mut residual = x.clone();
            factor.solve(&right, &mut x);
            matrix.residual(&right, &x, &mut residual);
            let most = residual.as_flattened().iter().map(|r| r.abs());
            let most = most.fold(0.0, f32::max);
            let blocks = factor.factor.blocks.len();
            println!("{fill:?}: {blocks} blocks, residual {most:.1e}");
            assert!(most < last);
            last = most;
        }
        assert!(last < 1e-6);
    }
}
