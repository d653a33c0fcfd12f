//! A panel of a front: the inverses of its diagonal block, and the rows below, (F1) of `eliminate`.

use super::real::{PANEL, Panel, Real};
use super::tile::{Block, BlockMut, kind, multiply};
use crate::wide::Task;

/// Take the inverses of a panel's diagonal block, and (F1).
pub struct Invert<'a, T, const M: usize, const H: usize> {
    /// All rows of its columns.
    pub panel: &'a mut [T],
    /// From column to column.
    pub stride: usize,
    /// First row of the diagonal block, first and end of the rows below.
    pub rows: [usize; 3],
}

/// What comes out of [`Invert`].
pub struct Inverse<T> {
    /// L⁻¹, without its diagonal of ones.
    pub low: Panel<T>,
    /// Are the pivots large enough?
    pub trusted: bool,
}

impl<T: Real, const M: usize, const H: usize> Task for Invert<'_, T, M, H> {
    type Output = Inverse<T>;

    #[inline(always)]
    fn run(self) -> Inverse<T> {
        let [begin, end, _] = self.rows;
        if end - begin > PANEL / 2 {
            self.at_most::<PANEL>()
        } else {
            self.at_most::<{ PANEL / 2 }>()
        }
    }
}

impl<T: Real, const M: usize, const H: usize> Invert<'_, T, M, H> {
    /// With K pivots at most.
    #[inline(always)]
    fn at_most<const K: usize>(self) -> Inverse<T> {
        let Invert {
            panel,
            stride,
            rows: [begin, end, rows],
        } = self;
        let n = end - begin;
        let mut d = [[T::default(); K]; K];
        for c in 0..n {
            let column = &panel[c * stride + begin..][..K];
            for i in 0..K {
                d[c][i] = if i < n { column[i] } else { T::default() };
            }
        }
        let (low, up, trusted) = inverses::<T, K>(&mut d, n);
        for c in 0..n {
            let column = &mut panel[c * stride + begin..][..K];
            for i in 0..K {
                let both = low[c][i] + up[c][i];
                column[i] = if i < n { both } else { column[i] };
            }
        }
        let mut row = end;
        while row < rows {
            if rows - row > H {
                scale_tile::<T, M, K>(panel, stride, row, &up, n);
                row += M;
            } else {
                scale_tile::<T, H, K>(panel, stride, row, &up, n);
                row += H;
            }
        }
        let mut inverse = [[T::default(); PANEL]; PANEL];
        for c in 0..K {
            inverse[c][..K].copy_from_slice(&low[c]);
        }
        Inverse {
            low: inverse,
            trusted,
        }
    }
}

/// A block of K rows and columns at most.
type Square<T, const K: usize> = [[T; K]; K];

/// L⁻¹ without its diagonal, and U⁻¹, of the first n rows and columns; are the pivots large enough?
#[inline(always)]
fn inverses<T: Real, const K: usize>(
    d: &mut Square<T, K>,
    n: usize,
) -> (Square<T, K>, Square<T, K>, bool) {
    let zero = T::default();
    let mut trusted = true;
    let mut reciprocal = [zero; K];
    let mut lower = [[zero; K]; K];
    for j in 0..n {
        let pivot = d[j][j].to_f64();
        trusted &= pivot.abs() > T::PIVOT_MIN;
        reciprocal[j] = T::of(1.0 / pivot);
        for i in 0..K {
            lower[j][i] = (d[j][i] * reciprocal[j]).flushed() * T::BELOW[j][i];
        }
        let column = lower[j];
        for c in j + 1..n {
            let factor = d[c][j];
            for i in 0..K {
                d[c][i] -= column[i] * factor;
            }
        }
    }
    let (mut low, mut up) = ([[zero; K]; K], [[zero; K]; K]);
    for j in 0..n {
        (low[j][j], up[j][j]) = (T::ONE, T::ONE);
    }
    for k in 0..n {
        // column k of L from the columns up to it
        for j in 0..=k {
            let factor = low[j][k];
            for i in 0..K {
                low[j][i] -= lower[k][i] * factor;
            }
        }
        // column k of U, from the last one on
        let k = n - 1 - k;
        let mut upper = d[k];
        for i in 0..K {
            upper[i] = upper[i] * T::ABOVE[k][i];
        }
        for j in k..n {
            up[j][k] = up[j][k] * reciprocal[k];
            let factor = up[j][k];
            for i in 0..K {
                up[j][i] -= upper[i] * factor;
            }
        }
    }
    for j in 0..n {
        low[j][j] = zero;
        for i in 0..K {
            low[j][i] = low[j][i].flushed();
            up[j][i] = up[j][i].flushed();
        }
    }
    (low, up, trusted)
}

/// (F1) on M rows.
#[inline(always)]
fn scale_tile<T: Real, const M: usize, const K: usize>(
    panel: &mut [T],
    stride: usize,
    row: usize,
    up: &Square<T, K>,
    n: usize,
) {
    let mut old = [[T::default(); M]; K];
    for q in 0..n {
        old[q].copy_from_slice(&panel[q * stride + row..][..M]);
    }
    let a = Block {
        values: old.as_flattened(),
        stride: M,
    };
    let b = Block {
        values: up.as_flattened(),
        stride: K,
    };
    let mut c = BlockMut {
        values: &mut panel[row..],
        stride,
    };
    // U⁻¹ is 0 below its diagonal
    let mut j = 0;
    while j + 4 <= n {
        let (b, c) = (b.columns_from(j), c.columns_from(j));
        multiply::<T, M, 4, { kind::SET }>(j + 4, a, b, c);
        j += 4;
    }
    while j < n {
        let (b, c) = (b.columns_from(j), c.columns_from(j));
        multiply::<T, M, 1, { kind::SET }>(j + 1, a, b, c);
        j += 1;
    }
}
