//! Forward and backward substitution with the fronts of a factor.

use super::eliminate::{Precision, Shape};
use super::plans::{Plan, Plans};
use super::real::PANEL;
use super::tile::{Block, CHUNK, multiply_triangle, subtract_columns};
use crate::wide::Task;

/// x ← (LU)⁻¹ x
pub struct Solve<'a, T, const N: usize> {
    /// Structure.
    pub plans: &'a Plans<N>,
    /// L11\U11 over L21 of all fronts.
    pub left: &'a [T],
    /// U12 of all fronts.
    pub top: &'a [T],
    /// x
    pub x: &'a mut [T],
}

impl<T: Precision, const N: usize> Task for Solve<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Solve {
            plans,
            left: all_left,
            top: all_top,
            x,
        } = self;
        let plans = &plans.fronts;
        let mut longest = 0;
        for plan in plans {
            longest = longest.max(plan.shape.pivots + plan.shape.boundary);
        }
        let mut local = vec![T::default(); longest + 2 * PANEL];
        let mut stays = vec![T::default(); longest];
        let (mut left, mut top) = (0, 0);
        for plan in plans {
            let length = plan.shape.left_length();
            forward(plan, &all_left[left..left + length], x, &mut local);
            left += length;
            top += plan.shape.top_length();
        }
        for k in (0..plans.len()).rev() {
            let shape = plans[k].shape;
            let (left_end, top_end) = (left, top);
            left -= shape.left_length();
            top -= shape.top_length();
            let parts = [&all_left[left..left_end], &all_top[top..top_end]];
            backward(&plans[k], parts, x, &mut local, &mut stays);
        }
    }
}

/// Values of nodes, one after the other.
#[inline(always)]
fn gather<T: Precision, const N: usize>(nodes: &[usize], x: &[T], to: &mut [T]) {
    let (x, to) = (x.as_chunks::<N>().0, to.as_chunks_mut::<N>().0);
    for k in 0..nodes.len() {
        to[k] = x[nodes[k]];
    }
}

/// Back to their nodes.
#[inline(always)]
fn scatter<T: Precision, const N: usize>(nodes: &[usize], from: &[T], x: &mut [T]) {
    let (from, x) = (from.as_chunks::<N>().0, x.as_chunks_mut::<N>().0);
    for k in 0..nodes.len() {
        x[nodes[k]] = from[k];
    }
}

/// L y = x on a front.
#[inline(always)]
fn forward<T: Precision, const N: usize>(plan: &Plan<N>, left: &[T], x: &mut [T], local: &mut [T]) {
    let Shape {
        pivots,
        boundary,
        left: stride,
        ..
    } = plan.shape;
    gather::<T, N>(&plan.front.pivots, x, local);
    local[pivots..pivots + boundary].fill(T::default());
    let mut begin = 0;
    while begin < pivots {
        let end = pivots.min(begin + PANEL);
        // L⁻¹ of the panel, without its diagonal of ones
        let mut old = [T::default(); PANEL];
        old.copy_from_slice(&local[begin..begin + PANEL]);
        let block = Block {
            values: &left[begin * stride + begin..],
            stride,
        };
        let new = multiply_triangle::<T, true>(block, &old[..end - begin], old);
        let new = &new[..end - begin];
        local[begin..end].copy_from_slice(new);
        let below = Block {
            values: &left[begin * stride + end..],
            stride,
        };
        subtract_columns(pivots + boundary - end, below, new, &mut local[end..]);
        begin = end;
    }
    scatter::<T, N>(&plan.front.pivots, local, x);
    let nodes = &plan.front.boundary;
    let (local, x) = (local[pivots..].as_chunks::<N>().0, x.as_chunks_mut::<N>().0);
    for k in 0..nodes.len() {
        for d in 0..N {
            x[nodes[k]][d] += local[k][d];
        }
    }
}

/// U x = y on a front, which has a left and a top.
#[inline(always)]
fn backward<T: Precision, const N: usize>(
    plan: &Plan<N>,
    [left, top]: [&[T]; 2],
    x: &mut [T],
    local: &mut [T],
    stays: &mut [T],
) {
    let shape = plan.shape;
    gather::<T, N>(&plan.front.pivots, x, local);
    gather::<T, N>(&plan.front.boundary, x, stays);
    let right = Block {
        values: top,
        stride: shape.top,
    };
    subtract_columns(shape.pivots, right, &stays[..shape.boundary], local);
    let mut end = shape.pivots;
    while end > 0 {
        let begin = (end - 1) / PANEL * PANEL;
        let mut old = [T::default(); PANEL];
        old.copy_from_slice(&local[begin..begin + PANEL]);
        let block = Block {
            values: &left[begin * shape.left + begin..],
            stride: shape.left,
        };
        let mut diagonal = [T::default(); PANEL];
        for k in 0..end - begin {
            diagonal[k] = block.values[k * shape.left + k] * old[k];
        }
        let new = multiply_triangle::<T, false>(block, &old[..end - begin], diagonal);
        let new = &new[..end - begin];
        local[begin..end].copy_from_slice(new);
        let above = Block {
            values: &left[begin * shape.left..],
            stride: shape.left,
        };
        subtract_columns(begin, above, new, local);
        end = begin;
    }
    scatter::<T, N>(&plan.front.pivots, local, x);
}

// a panel's rows are whole chunks
const _: () = assert!(PANEL.is_multiple_of(CHUNK));
