//! Points and vectors of `D` components.
//!
//! Sums run over the components in their order, so the same numbers give the same bits everywhere.

/// A point \[m\] or a vector of `D` components.
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;

/// a·b, summed in the order of the components.
#[inline(always)]
pub fn dot<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> f64 {
    let mut sum = a[0] * b[0];
    for d in 1..D {
        sum += a[d] * b[d];
    }
    sum
}

/// |a| as the root of a·a: for lengths far from the ends of the range.
#[inline(always)]
pub fn norm<const D: usize>(a: &Vector<D>) -> f64 {
    dot(a, a).sqrt()
}

/// |a| without overflow or underflow; its last bit may differ from [`norm`].
#[inline(always)]
pub fn hypot<const D: usize>(a: &Vector<D>) -> f64 {
    (1..D).fold(a[0].abs(), |length, d| length.hypot(a[d]))
}

/// The vector whose component d is `component(d)`.
#[inline(always)]
pub fn from_fn<const D: usize>(mut component: impl FnMut(usize) -> f64) -> Vector<D> {
    Vector::<D>::from_fn(|d, _| component(d))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_lengths_agree_in_the_plane_and_in_space() {
        let plane = Vector::from([3.0, -4.0]);
        let space = Vector::from([2.0, -3.0, 6.0]);
        assert_eq!((norm(&plane), hypot(&plane)), (5.0, 5.0));
        assert_eq!((norm(&space), hypot(&space)), (7.0, 7.0));
        assert_eq!(hypot(&Vector::from([3e-300, 4e-300])), 5e-300);
        assert_eq!(norm(&Vector::from([3e-300, 4e-300])), 0.0);
    }
}
