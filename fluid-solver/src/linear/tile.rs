//! Products of dense blocks, the loops in which factors spend their time.
//!
//! Blocks are by columns. Each function looks once whether its blocks lie in what it was given, and then no more.
//! Every number is a sum in a fixed order, whatever the width of the registers; nothing is fused. Loops rather than
//! closures: a closure is not compiled for the registers of its caller.

use super::real::{PANEL, Real};

/// So many products of two numbers are worth another thread.
pub const SHARED: usize = 1 << 20;

/// A block by columns, read.
#[derive(Clone, Copy)]
pub struct Block<'a, T> {
    /// Its numbers, from its first on.
    pub values: &'a [T],
    /// From column to column.
    pub stride: usize,
}

/// A block by columns, changed.
pub struct BlockMut<'a, T> {
    /// Its numbers, from its first on.
    pub values: &'a mut [T],
    /// From column to column.
    pub stride: usize,
}

impl<'a, T> Block<'a, T> {
    /// From a column on.
    #[inline(always)]
    pub fn columns_from(self, column: usize) -> Block<'a, T> {
        Block {
            values: &self.values[column * self.stride..],
            stride: self.stride,
        }
    }
}

impl<T> BlockMut<'_, T> {
    /// From a column on.
    #[inline(always)]
    pub fn columns_from(&mut self, column: usize) -> BlockMut<'_, T> {
        BlockMut {
            values: &mut self.values[column * self.stride..],
            stride: self.stride,
        }
    }
}

/// Numbers that `columns` columns of `rows` rows reach over.
#[inline(always)]
fn reach(stride: usize, columns: usize, rows: usize) -> usize {
    (columns - 1) * stride + rows
}

/// What becomes of C with a product.
pub mod kind {
    /// C ← A B
    pub const SET: u8 = 0;
    /// C ← − A B
    pub const SET_MINUS: u8 = 1;
    /// C ← C − A B
    pub const SUBTRACT: u8 = 2;
}

/// `KIND` of M × `depth` and `depth` × W.
#[inline(always)]
pub fn multiply<T: Real, const M: usize, const W: usize, const KIND: u8>(
    depth: usize,
    a: Block<'_, T>,
    b: Block<'_, T>,
    c: BlockMut<'_, T>,
) {
    if depth == 0 {
        return;
    }
    assert!(
        a.values.len() >= reach(a.stride, depth, M)
            && b.values.len() >= reach(b.stride, W, depth)
            && c.values.len() >= reach(c.stride, W, M)
    );
    let mut sum = [[T::default(); M]; W];
    for q in 0..depth {
        // SAFETY: q < depth, and the blocks were seen to lie in their slices.
        unsafe {
            let from = a.values.as_ptr().add(q * a.stride).cast::<[T; M]>();
            let column = from.read_unaligned();
            for j in 0..W {
                let factor = *b.values.get_unchecked(j * b.stride + q);
                for i in 0..M {
                    sum[j][i] += column[i] * factor;
                }
            }
        }
    }
    for j in 0..W {
        let target = &mut c.values[j * c.stride..][..M];
        for i in 0..M {
            target[i] = with_product::<T, KIND>(target[i], sum[j][i]);
        }
    }
}

/// Products that are deeper are cut.
pub const DEPTH: usize = 192;

/// A number of C with its product.
#[inline(always)]
fn with_product<T: Real, const KIND: u8>(c: T, product: T) -> T {
    match KIND {
        kind::SET => product.flushed(),
        kind::SET_MINUS => (T::default() - product).flushed(),
        _ => (c - product).flushed(),
    }
}

/// `KIND` with copies: `a` is by columns of M rows, `b` W columns.
#[inline(always)]
pub fn multiply_copied<T: Real, const M: usize, const W: usize, const KIND: u8>(
    a: &[[T; M]],
    b: &[[T; DEPTH]],
    c: BlockMut<'_, T>,
) {
    let (a, b) = (&a[..a.len().min(DEPTH)], &b[..W]);
    let mut sum = [[T::default(); M]; W];
    for q in 0..a.len() {
        for j in 0..W {
            let factor = b[j][q];
            for i in 0..M {
                sum[j][i] += a[q][i] * factor;
            }
        }
    }
    for j in 0..W {
        let target = &mut c.values[j * c.stride..][..M];
        for i in 0..M {
            target[i] = with_product::<T, KIND>(target[i], sum[j][i]);
        }
    }
}

/// Rows of a chunk of [`subtract_columns`].
pub const CHUNK: usize = 8;

/// y ← y − A x on `rows` rows, rounded up to whole chunks in y and A, where what is beyond has no meaning.
#[inline(always)]
pub fn subtract_columns<T: Real>(rows: usize, a: Block<'_, T>, x: &[T], y: &mut [T]) {
    let rows = rows.next_multiple_of(CHUNK);
    if rows == 0 || x.is_empty() {
        return;
    }
    assert!(y.len() >= rows && a.values.len() >= reach(a.stride, x.len(), rows));
    let (eights, others) = x.as_chunks::<8>();
    for (c, x) in eights.iter().enumerate() {
        let mut row = 0;
        while row < rows {
            // SAFETY: row and column are in the block, which was seen to lie in its slice.
            unsafe {
                let from = a.values.as_ptr().add(8 * c * a.stride + row);
                let target = y.as_mut_ptr().add(row).cast::<[T; CHUNK]>();
                let mut even = target.read_unaligned();
                let mut odd = [T::default(); CHUNK];
                for q in 0..4 {
                    let first = from.add(2 * q * a.stride).cast::<[T; CHUNK]>();
                    let second = from.add((2 * q + 1) * a.stride).cast::<[T; CHUNK]>();
                    let (first, second) = (first.read_unaligned(), second.read_unaligned());
                    for i in 0..CHUNK {
                        even[i] -= first[i] * x[2 * q];
                        odd[i] -= second[i] * x[2 * q + 1];
                    }
                }
                for i in 0..CHUNK {
                    even[i] = (even[i] + odd[i]).flushed();
                }
                target.write_unaligned(even);
            }
            row += CHUNK;
        }
    }
    for (c, &x) in others.iter().enumerate() {
        let column = &a.values[(8 * eights.len() + c) * a.stride..][..rows];
        let target = &mut y[..rows];
        for i in 0..rows {
            target[i] = (target[i] - column[i] * x).flushed();
        }
    }
}

/// A x of the part below (`BELOW`) or above the diagonal of a panel's block, on all its rows; `values` begin with it.
#[inline(always)]
pub fn multiply_triangle<T: Real, const BELOW: bool>(
    a: Block<'_, T>,
    x: &[T],
    mut y: [T; PANEL],
) -> [T; PANEL] {
    let chunks = y.as_chunks_mut::<CHUNK>().0;
    for half in 0..PANEL / CHUNK {
        let mut sum = chunks[half];
        for k in 0..x.len() {
            let rows = half * CHUNK;
            let mask = if BELOW { &T::BELOW[k] } else { &T::ABOVE[k] };
            let (column, mask) = (&a.values[k * a.stride + rows..][..CHUNK], &mask[rows..]);
            for i in 0..CHUNK {
                sum[i] += column[i] * mask[i] * x[k];
            }
        }
        for i in 0..CHUNK {
            chunks[half][i] = sum[i].flushed();
        }
    }
    y
}
