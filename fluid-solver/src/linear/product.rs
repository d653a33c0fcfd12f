//! The product that a front hands over, in tiles of M rows, the last one of H where that is enough.
//!
//! Where there are many columns, B is copied to columns that are a known number apart, and each tile of A to columns that
//! follow one another: the places of all factors are then found from two.

use super::real::Real;
use super::tile::{Block, BlockMut, DEPTH, SHARED, kind, multiply, multiply_copied};
use crate::wide::{Task, Wide};

/// Over so many columns, copies for a product pay.
const COPIED: usize = 24;

/// C ← − A B, `depth` columns of A.
pub struct Product<'a, T, const M: usize, const H: usize> {
    /// Columns of A.
    pub depth: usize,
    /// A, from row `begin` on.
    pub a: Block<'a, T>,
    /// Its first row.
    pub begin: usize,
    /// B
    pub b: Block<'a, T>,
    /// C
    pub c: &'a mut [T],
    /// From column to column of C.
    pub stride: usize,
    /// Its rows.
    pub rows: usize,
    /// Its columns.
    pub columns: usize,
    /// Room.
    pub room: &'a mut Vec<T>,
}

impl<T: Real, const M: usize, const H: usize> Product<'_, T, M, H> {
    /// Alone or with other threads.
    pub fn multiply(self, wide: Wide, shared: bool) {
        if self.columns == 0 || self.depth == 0 {
            return;
        }
        if !shared || self.columns * self.rows * self.depth < SHARED {
            return wide.run(self);
        }
        let first = self.columns / 2;
        let (low, high) = self.c.split_at_mut(first * self.stride);
        let mut room = Vec::new();
        let high = Product::<T, M, H> {
            b: self.b.columns_from(first),
            c: high,
            columns: self.columns - first,
            room: &mut room,
            ..self
        };
        let low = Product::<T, M, H> {
            c: low,
            columns: first,
            ..self
        };
        rayon::join(|| wide.run(low), || wide.run(high));
    }
}

impl<T: Real, const M: usize, const H: usize> Task for Product<'_, T, M, H> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        if self.columns < COPIED {
            return self.without_copies();
        }
        let of_b = self.columns * DEPTH;
        if self.room.len() < of_b + M * DEPTH {
            self.room.resize(of_b + M * DEPTH, T::default());
        }
        let (copy, tile) = self.room.split_at_mut(of_b);
        let copy = copy.as_chunks_mut::<DEPTH>().0;
        let mut from = 0;
        while from < self.depth {
            let depth = DEPTH.min(self.depth - from);
            for j in 0..self.columns {
                let column = &self.b.values[j * self.b.stride + from..][..depth];
                copy[j][..depth].copy_from_slice(column);
            }
            let mut row = 0;
            while row < self.rows {
                let a = Block {
                    values: &self.a.values[from * self.a.stride + self.begin + row..],
                    stride: self.a.stride,
                };
                let c = BlockMut {
                    values: &mut self.c[row..],
                    stride: self.stride,
                };
                let copy = &copy[..self.columns];
                let rows = if self.rows - row > H { M } else { H };
                match (from == 0, rows == M) {
                    (true, true) => copied::<T, M, { kind::SET_MINUS }>(depth, a, copy, c, tile),
                    (true, false) => copied::<T, H, { kind::SET_MINUS }>(depth, a, copy, c, tile),
                    (false, true) => copied::<T, M, { kind::SUBTRACT }>(depth, a, copy, c, tile),
                    (false, false) => copied::<T, H, { kind::SUBTRACT }>(depth, a, copy, c, tile),
                }
                row += rows;
            }
            from += depth;
        }
    }
}

impl<T: Real, const M: usize, const H: usize> Product<'_, T, M, H> {
    /// Without copies.
    #[inline(always)]
    fn without_copies(self) {
        let mut row = 0;
        while row < self.rows {
            let a = Block {
                values: &self.a.values[self.begin + row..],
                stride: self.a.stride,
            };
            let c = BlockMut {
                values: &mut self.c[row..],
                stride: self.stride,
            };
            if self.rows - row > H {
                strip::<T, M>(self.depth, self.columns, a, self.b, c);
                row += M;
            } else {
                strip::<T, H>(self.depth, self.columns, a, self.b, c);
                row += H;
            }
        }
    }
}

/// M rows of a product with a copy of its right part; there is room for one of the left.
#[inline(always)]
fn copied<T: Real, const M: usize, const KIND: u8>(
    depth: usize,
    a: Block<'_, T>,
    b: &[[T; DEPTH]],
    mut c: BlockMut<'_, T>,
    room: &mut [T],
) {
    let room = &mut room.as_chunks_mut::<M>().0[..depth];
    for q in 0..depth {
        room[q].copy_from_slice(&a.values[q * a.stride..][..M]);
    }
    let mut column = 0;
    while column + 6 <= b.len() {
        multiply_copied::<T, M, 6, KIND>(room, &b[column..], c.columns_from(column));
        column += 6;
    }
    while column + 3 <= b.len() {
        multiply_copied::<T, M, 3, KIND>(room, &b[column..], c.columns_from(column));
        column += 3;
    }
    while column < b.len() {
        multiply_copied::<T, M, 1, KIND>(room, &b[column..], c.columns_from(column));
        column += 1;
    }
}

/// M rows of a product.
#[inline(always)]
fn strip<T: Real, const M: usize>(
    depth: usize,
    columns: usize,
    a: Block<'_, T>,
    b: Block<'_, T>,
    mut c: BlockMut<'_, T>,
) {
    let mut column = 0;
    while column + 6 <= columns {
        multiply::<T, M, 6, { kind::SET_MINUS }>(
            depth,
            a,
            b.columns_from(column),
            c.columns_from(column),
        );
        column += 6;
    }
    while column + 3 <= columns {
        multiply::<T, M, 3, { kind::SET_MINUS }>(
            depth,
            a,
            b.columns_from(column),
            c.columns_from(column),
        );
        column += 3;
    }
    while column < columns {
        multiply::<T, M, 1, { kind::SET_MINUS }>(
            depth,
            a,
            b.columns_from(column),
            c.columns_from(column),
        );
        column += 1;
    }
}
