//! Elimination of the pivots of a front without row exchanges, in panels of 16.
//!
//! ```text
//!   D = L U of a panel's diagonal block;  L⁻¹ (strictly below) and U⁻¹ are kept in its place
//!   rows below    F ← F U⁻¹                                                                (F1)
//!   columns after F ← L⁻¹ F in the rows of the panel                                       (F2)
//!   the rest      F ← F − (rows below)(columns after)                                      (F3)
//!                 of the boundary alone: −(rows below)(columns after), to be added
//! ```
//!
//! With the inverses everything but the diagonal blocks is a matrix product, and a solve has no substitution in it. After
//! the layout that dense factors have had since Dongarra et al. (1990). Columns of (F2) and (F3) are independent of one
//! another, so threads may share them and the numbers stay the same.
//!
//! Arrays are by columns. Rows are padded so that the last tile of a column may run over: what is in padded rows has no
//! meaning.

use super::invert::Invert;
use super::product::Product;
use super::real::{PANEL, Panel, Real};
use super::tile::{Block, BlockMut, SHARED, kind, multiply};
use crate::wide::{Task, Wide};

/// Rows are padded to a multiple of this.
pub const PAD: usize = 8;

/// Sizes of a front: pivots, boundary, and how far columns are apart.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// Unknowns that are eliminated.
    pub pivots: usize,
    /// Unknowns that stay.
    pub boundary: usize,
    /// From column to column of all rows of the pivots' columns.
    pub left: usize,
    /// Of the pivots' rows of the boundary's columns.
    pub top: usize,
    /// Of the boundary's rows of its columns.
    pub rest: usize,
}

impl Shape {
    /// Of a front with so many unknowns.
    pub fn new(pivots: usize, boundary: usize) -> Shape {
        let padded = |rows: usize| rows.next_multiple_of(PAD);
        Shape {
            pivots,
            boundary,
            left: padded(padded(pivots + boundary).max(pivots + padded(boundary))),
            top: padded(pivots),
            rest: padded(boundary),
        }
    }

    /// Numbers of all rows of the pivots' columns, whole chunks and a tile over the last.
    pub fn left_length(&self) -> usize {
        (self.left * self.pivots).next_multiple_of(PANEL) + PANEL
    }

    /// Of the pivots' rows of the boundary's columns.
    pub fn top_length(&self) -> usize {
        (self.top * self.boundary).next_multiple_of(PANEL) + PANEL
    }

    /// Of the boundary's rows of its columns.
    pub fn rest_length(&self) -> usize {
        self.rest * self.boundary + PANEL
    }
}

/// A front whose pivots are to be eliminated.
pub struct Parts<'a, T> {
    /// Its sizes.
    pub shape: Shape,
    /// All rows of the pivots' columns.
    pub left: &'a mut [T],
    /// Pivots' rows of the boundary's columns.
    pub top: &'a mut [T],
    /// What is to be added to the rest comes here.
    pub rest: &'a mut [T],
    /// Room.
    pub room: &'a mut Vec<T>,
    /// May other threads help?
    pub shared: bool,
}

/// A precision that fronts are eliminated in.
pub trait Precision: Real {
    /// Eliminate the pivots of a front; were all of them large enough?
    fn eliminate(wide: Wide, front: Parts<'_, Self>) -> bool;
}

impl Precision for f32 {
    fn eliminate(wide: Wide, front: Parts<'_, f32>) -> bool {
        eliminate::<f32, 16, 8>(wide, front)
    }
}

impl Precision for f64 {
    fn eliminate(wide: Wide, front: Parts<'_, f64>) -> bool {
        eliminate::<f64, 8, 4>(wide, front)
    }
}

/// With tiles of M rows, the last one of a column of H where that is enough.
fn eliminate<T: Real, const M: usize, const H: usize>(wide: Wide, front: Parts<'_, T>) -> bool {
    let Parts {
        shape,
        left,
        top,
        rest,
        room,
        shared,
    } = front;
    let (pivots, boundary) = (shape.pivots, shape.boundary);
    let mut trusted = true;
    for begin in (0..pivots).step_by(PANEL) {
        let end = pivots.min(begin + PANEL);
        let (panel, after) = left.split_at_mut(end * shape.left);
        let panel = &mut panel[begin * shape.left..];
        let inverse = wide.run(Invert::<T, M, H> {
            panel,
            stride: shape.left,
            rows: [begin, end, pivots + boundary],
        });
        trusted &= inverse.trusted;
        let panel = Block {
            values: &*panel,
            stride: shape.left,
        };
        let inverse = &inverse.low;
        let in_left = After::<T, M, H> {
            inverse,
            panel,
            columns: after,
            stride: shape.left,
            count: pivots - end,
            rows: [begin, end, pivots + boundary],
        };
        in_left.eliminate(wide, shared);
        let in_top = After::<T, M, H> {
            inverse,
            panel,
            columns: top,
            stride: shape.top,
            count: boundary,
            rows: [begin, end, pivots],
        };
        in_top.eliminate(wide, shared);
    }
    let product = Product::<T, M, H> {
        depth: pivots,
        a: Block {
            values: left,
            stride: shape.left,
        },
        begin: pivots,
        b: Block {
            values: top,
            stride: shape.top,
        },
        c: rest,
        stride: shape.rest,
        rows: boundary,
        columns: boundary,
        room,
    };
    product.multiply(wide, shared);
    trusted
}

/// (F2) and (F3) on columns after those of a panel.
struct After<'a, T, const M: usize, const H: usize> {
    inverse: &'a Panel<T>,
    panel: Block<'a, T>,
    columns: &'a mut [T],
    stride: usize,
    count: usize,
    /// First row of the panel, first and end of the rows below.
    rows: [usize; 3],
}

impl<T: Real, const M: usize, const H: usize> After<'_, T, M, H> {
    /// Alone or with other threads.
    fn eliminate(self, wide: Wide, shared: bool) {
        if !shared || self.count * (self.rows[2] - self.rows[1]) * PANEL < SHARED {
            return wide.run(self);
        }
        let first = self.count / 2;
        let (low, high) = self.columns.split_at_mut(first * self.stride);
        let high = After::<T, M, H> {
            columns: high,
            count: self.count - first,
            ..self
        };
        let low = After::<T, M, H> {
            columns: low,
            count: first,
            ..self
        };
        rayon::join(|| wide.run(low), || wide.run(high));
    }
}

impl<T: Real, const M: usize, const H: usize> Task for After<'_, T, M, H> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [begin, end, _] = self.rows;
        if end - begin > PANEL / 2 {
            self.at_most::<PANEL>();
        } else {
            self.at_most::<{ PANEL / 2 }>();
        }
    }
}

impl<T: Real, const M: usize, const H: usize> After<'_, T, M, H> {
    /// With K pivots at most.
    #[inline(always)]
    fn at_most<const K: usize>(self) {
        let After {
            inverse,
            panel,
            columns,
            stride,
            count,
            rows,
        } = self;
        let mut column = 0;
        while column + 6 <= count {
            let columns = &mut columns[column * stride..];
            after::<T, M, H, K, 6>(inverse, panel, columns, stride, rows);
            column += 6;
        }
        while column + 2 <= count {
            let columns = &mut columns[column * stride..];
            after::<T, M, H, K, 2>(inverse, panel, columns, stride, rows);
            column += 2;
        }
        if column < count {
            let columns = &mut columns[column * stride..];
            after::<T, M, H, K, 1>(inverse, panel, columns, stride, rows);
        }
    }
}

/// (F2) and (F3) on W columns, of K pivots at most.
#[inline(always)]
fn after<T: Real, const M: usize, const H: usize, const K: usize, const W: usize>(
    inverse: &Panel<T>,
    panel: Block<'_, T>,
    columns: &mut [T],
    stride: usize,
    [begin, end, rows]: [usize; 3],
) {
    let n = end - begin;
    let mut new = [[T::default(); K]; W];
    for c in 0..W {
        // L⁻¹ is 0 in rows that are no pivots' of this panel: they stay what they are
        let column = &mut columns[c * stride + begin..][..K];
        let mut sum = [T::default(); K];
        sum.copy_from_slice(column);
        let old = sum;
        for q in 0..n {
            let factor = old[q];
            for i in 0..K {
                sum[i] += inverse[q][i] * factor;
            }
        }
        for i in 0..K {
            sum[i] = sum[i].flushed();
        }
        column.copy_from_slice(&sum);
        new[c] = sum;
    }
    let b = Block {
        values: new.as_flattened(),
        stride: K,
    };
    let mut row = end;
    while row < rows {
        let a = Block {
            values: &panel.values[row..],
            stride: panel.stride,
        };
        let c = BlockMut {
            values: &mut columns[row..],
            stride,
        };
        if rows - row > H {
            multiply::<T, M, W, { kind::SUBTRACT }>(n, a, b, c);
            row += M;
        } else {
            multiply::<T, H, W, { kind::SUBTRACT }>(n, a, b, c);
            row += H;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fronts of many sizes with a strong diagonal, eliminated with and without wide registers.
    fn same_bits<T: Precision>() {
        let mut state = 7u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        for (pivots, boundary) in [(3, 0), (9, 12), (16, 7), (30, 40), (75, 110), (210, 60)] {
            let shape = Shape::new(pivots, boundary);
            let mut left = vec![T::default(); shape.left_length()];
            let mut top = vec![T::default(); shape.top_length()];
            for column in 0..pivots {
                for row in 0..pivots + boundary {
                    let strong = if row == column { 8.0 } else { 0.0 };
                    left[column * shape.left + row] = T::of(random() + strong);
                }
            }
            for column in 0..boundary {
                (0..pivots).for_each(|row| top[column * shape.top + row] = T::of(random()));
            }
            let run = |wide: Wide| {
                let (mut left, mut top) = (left.clone(), top.clone());
                let mut rest = vec![T::default(); shape.rest_length()];
                let parts = Parts {
                    shape,
                    left: &mut left,
                    top: &mut top,
                    rest: &mut rest,
                    room: &mut Vec::new(),
                    shared: false,
                };
                assert!(T::eliminate(wide, parts));
                [left, top, rest].map(|part| part.iter().map(|x| x.to_f64().to_bits()).collect())
            };
            let both: [[Vec<u64>; 3]; 2] = [run(Wide::here()), run(Wide::none())];
            assert_eq!(both[0], both[1], "{pivots} pivots, {boundary} stay");
        }
    }

    #[test]
    fn wide_registers_change_no_bit() {
        same_bits::<f32>();
        same_bits::<f64>();
    }
}
