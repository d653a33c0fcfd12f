//! What cannot be written for every number of dimensions at once.

use crate::vector::Vector;

/// The marker of a number of dimensions: `Dim<2>` is the plane, `Dim<3>` space.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Dim<const D: usize>;

/// Operations that have a form of their own in the plane and in space.
pub trait Dimension<const D: usize>: Copy + Default + Send + Sync + 'static {
    /// Determinant of D edges, D! times the volume they span; positive when they are right-handed.
    fn determinant(edges: &[Vector<D>; D]) -> f64;

    /// A vector normal to a facet with these corners, outward where the D corners are those of a
    /// right-handed simplex without its first; (D − 1)! times as long as the facet is large.
    fn facet_normal(corners: &[Vector<D>; D]) -> Vector<D>;
}

impl Dimension<2> for Dim<2> {
    #[inline(always)]
    fn determinant([a, b]: &[Vector<2>; 2]) -> f64 {
        a[0] * b[1] - b[0] * a[1]
    }

    #[inline(always)]
    fn facet_normal([a, b]: &[Vector<2>; 2]) -> Vector<2> {
        Vector::from([b[1] - a[1], a[0] - b[0]])
    }
}

impl Dimension<3> for Dim<3> {
    #[inline(always)]
    fn determinant([a, b, c]: &[Vector<3>; 3]) -> f64 {
        a.dot(&b.cross(c))
    }

    #[inline(always)]
    fn facet_normal([a, b, c]: &[Vector<3>; 3]) -> Vector<3> {
        (b - a).cross(&(c - a))
    }
}

/// n!
pub const fn factorial(n: usize) -> usize {
    if n < 2 { 1 } else { n * factorial(n - 1) }
}
