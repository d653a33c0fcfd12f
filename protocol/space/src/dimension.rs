//! What cannot be written for every number of dimensions at once.

use crate::linear::Linear;
use crate::vector::{Vector, dot, norm};

/// The marker of a number of dimensions: `Dim<2>` is the plane, `Dim<3>` space.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Dim<const D: usize>;

/// Angular velocity: of the plane a number (counter-clockwise), of space a vector.
pub type Spin<const D: usize> = <Dim<D> as Dimension<D>>::Spin;

/// A vector of the tangent plane of a contact: in the plane its length along the normal turned to
/// the left, in space the vector itself, orthogonal to the normal.
pub type Tangent<const D: usize> = <Dim<D> as Dimension<D>>::Tangent;

/// Operations that have a form of their own in the plane and in space.
///
/// Normals are of unit length.
pub trait Dimension<const D: usize>: Copy + Default + Send + Sync + 'static {
    /// What a simplex is called.
    const SIMPLEX: &'static str;
    /// What a side of it is called.
    const FACET: &'static str;
    /// What its size is called.
    const MEASURE: &'static str;
    /// Unit of that.
    const UNIT: &'static str;

    /// See [`Spin`].
    type Spin: Linear;

    /// See [`Tangent`].
    type Tangent: Linear;

    /// Edges of a facet as pairs of its corners; none in the plane, where a facet is an edge.
    const FACET_EDGES: &'static [[usize; 2]];

    /// Determinant of D edges, D! times the volume they span; positive when they are right-handed.
    fn determinant(edges: &[Vector<D>; D]) -> f64;

    /// A vector normal to a facet with these corners, outward where the D corners are those of a
    /// right-handed simplex without its first; (D − 1)! times as long as the facet is large.
    fn facet_normal(corners: &[Vector<D>; D]) -> Vector<D>;

    /// Orthonormal directions, right-handed, the first of them this unit vector; in the plane the
    /// second is its left normal.
    fn frame(normal: &Vector<D>) -> [Vector<D>; D];

    /// The opposite of [`facet_normal`](Dimension::facet_normal): to the left of a → b in the plane.
    fn inward_normal(corners: &[Vector<D>; D]) -> Vector<D>;

    /// |a × b|.
    fn cross_length(a: &Vector<D>, b: &Vector<D>) -> f64;

    /// The part of a vector in the tangent plane.
    fn tangential(vector: &Vector<D>, normal: &Vector<D>) -> Self::Tangent;

    /// The vector with this part along the normal and this one in the tangent plane.
    fn combined(along: f64, tangent: Self::Tangent, normal: &Vector<D>) -> Vector<D>;

    /// `spin` × `normal`: speed, for r = 1, of the point of a ball that lies in direction `normal`.
    fn surface(spin: Self::Spin, normal: &Vector<D>) -> Self::Tangent;

    /// `normal` × `tangent`: torque, for r = 1, of a force on the point in direction `normal`.
    fn torque(tangent: Self::Tangent, normal: &Vector<D>) -> Self::Spin;

    /// The nearest one that is no longer than `limit` ≥ 0.
    fn limited(tangent: Self::Tangent, limit: f64) -> Self::Tangent;
}

impl Dimension<2> for Dim<2> {
    const SIMPLEX: &'static str = "triangle";
    const FACET: &'static str = "edge";
    const MEASURE: &'static str = "area";
    const UNIT: &'static str = "m²";
    type Spin = f64;
    type Tangent = f64;
    const FACET_EDGES: &'static [[usize; 2]] = &[];

    #[inline(always)]
    fn determinant([a, b]: &[Vector<2>; 2]) -> f64 {
        a[0] * b[1] - b[0] * a[1]
    }

    #[inline(always)]
    fn frame(normal: &Vector<2>) -> [Vector<2>; 2] {
        [*normal, Vector::from([-normal[1], normal[0]])]
    }

    #[inline(always)]
    fn facet_normal([a, b]: &[Vector<2>; 2]) -> Vector<2> {
        Vector::from([b[1] - a[1], a[0] - b[0]])
    }

    #[inline(always)]
    fn inward_normal([a, b]: &[Vector<2>; 2]) -> Vector<2> {
        Vector::from([-(b[1] - a[1]), b[0] - a[0]])
    }

    #[inline(always)]
    fn cross_length(a: &Vector<2>, b: &Vector<2>) -> f64 {
        (a[0] * b[1] - a[1] * b[0]).abs()
    }

    #[inline(always)]
    fn tangential(vector: &Vector<2>, normal: &Vector<2>) -> f64 {
        vector[1] * normal[0] - vector[0] * normal[1]
    }

    #[inline(always)]
    fn combined(along: f64, tangent: f64, normal: &Vector<2>) -> Vector<2> {
        Vector::from([
            along * normal[0] - tangent * normal[1],
            along * normal[1] + tangent * normal[0],
        ])
    }

    #[inline(always)]
    fn surface(spin: f64, _: &Vector<2>) -> f64 {
        spin
    }

    #[inline(always)]
    fn torque(tangent: f64, _: &Vector<2>) -> f64 {
        tangent
    }

    #[inline(always)]
    fn limited(tangent: f64, limit: f64) -> f64 {
        tangent.min(limit).max(-limit)
    }
}

impl Dimension<3> for Dim<3> {
    const SIMPLEX: &'static str = "tetrahedron";
    const FACET: &'static str = "face";
    const MEASURE: &'static str = "volume";
    const UNIT: &'static str = "m³";
    type Spin = Vector<3>;
    type Tangent = Vector<3>;
    const FACET_EDGES: &'static [[usize; 2]] = &[[0, 1], [1, 2], [2, 0]];

    #[inline(always)]
    fn determinant([a, b, c]: &[Vector<3>; 3]) -> f64 {
        a.dot(&b.cross(c))
    }

    /// After Duff et al. (2017): no branch but a sign.
    #[inline(always)]
    fn frame(normal: &Vector<3>) -> [Vector<3>; 3] {
        let (x, y, z) = (normal[0], normal[1], normal[2]);
        let sign = 1f64.copysign(z);
        let (a, b) = (-1.0 / (sign + z), -x * y / (sign + z));
        let first = Vector::from([1.0 + sign * x * x * a, sign * b, -sign * x]);
        [*normal, first, Vector::from([b, sign + y * y * a, -y])]
    }

    #[inline(always)]
    fn facet_normal([a, b, c]: &[Vector<3>; 3]) -> Vector<3> {
        (b - a).cross(&(c - a))
    }

    #[inline(always)]
    fn inward_normal([a, b, c]: &[Vector<3>; 3]) -> Vector<3> {
        (c - a).cross(&(b - a))
    }

    #[inline(always)]
    fn cross_length(a: &Vector<3>, b: &Vector<3>) -> f64 {
        norm(&a.cross(b))
    }

    #[inline(always)]
    fn tangential(vector: &Vector<3>, normal: &Vector<3>) -> Vector<3> {
        vector - normal * dot(vector, normal)
    }

    #[inline(always)]
    fn combined(along: f64, tangent: Vector<3>, normal: &Vector<3>) -> Vector<3> {
        normal * along + tangent
    }

    #[inline(always)]
    fn surface(spin: Vector<3>, normal: &Vector<3>) -> Vector<3> {
        spin.cross(normal)
    }

    #[inline(always)]
    fn torque(tangent: Vector<3>, normal: &Vector<3>) -> Vector<3> {
        normal.cross(&tangent)
    }

    #[inline(always)]
    fn limited(tangent: Vector<3>, limit: f64) -> Vector<3> {
        let length = norm(&tangent);
        if length <= limit {
            return tangent;
        }
        tangent * (limit / length)
    }
}

/// n!
pub const fn factorial(n: usize) -> usize {
    if n < 2 { 1 } else { n * factorial(n - 1) }
}
