//! The one geometry of triangles and tetrahedra.
//!
//! ```text
//!   N_i(x) = barycentric coordinate of corner i,  ∇N_i constant,  Σ N_i = 1
//!   ∇N_i = C_i/(D! V),   C_i = −(outward normal of the facet opposite to i), (D − 1)! times its size
//!   ∫ N_i = V/N
//! ```

use crate::dimension::{Dim, Dimension, factorial};
use crate::vector::{Vector, from_fn, hypot};

/// Gradients and volume of one simplex with `N = D + 1` corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simplex<const D: usize, const N: usize> {
    /// ∇N_i \[1/m\].
    pub gradient: [Vector<D>; N],
    /// Volume \[m^D\]: the area of a triangle.
    pub volume: f64,
}

/// Barycentric tolerance of being inside.
pub const INSIDE: f64 = -1e-12;

impl<const D: usize, const N: usize> Simplex<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Geometry from the corners; the volume is negative when they are left-handed (clockwise).
    #[inline]
    pub fn new(corners: &[Vector<D>; N]) -> Simplex<D, N> {
        let determinant = determinant(corners);
        Simplex {
            gradient: cofactors(corners).map(|normal| normal.map(|n| n / determinant)),
            volume: determinant / factorial(D) as f64,
        }
    }

    /// Diameter of the ball (disk) of the same volume \[m\].
    #[inline]
    pub fn size(&self) -> f64 {
        use std::f64::consts::PI;
        match D {
            2 => (4.0 * self.volume / PI).sqrt(),
            _ => (6.0 * self.volume / PI).cbrt(),
        }
    }

    /// Gradient of the linear field with these corner values.
    #[inline(always)]
    pub fn gradient_of(&self, value: &[f64; N]) -> Vector<D> {
        from_fn(|d| {
            let mut sum = value[0] * self.gradient[0][d];
            for i in 1..N {
                sum += value[i] * self.gradient[i][d];
            }
            sum
        })
    }
}

/// Edge of the square or cube of this volume \[m\].
#[inline]
pub fn cube_edge<const D: usize>(volume: f64) -> f64 {
    match D {
        2 => volume.sqrt(),
        _ => volume.cbrt(),
    }
}

/// D! times the volume of a simplex; positive when its corners are right-handed (counter-clockwise).
#[inline]
pub fn determinant<const D: usize, const N: usize>(corners: &[Vector<D>; N]) -> f64
where
    Dim<D>: Dimension<D>,
{
    const { assert!(N == D + 1, "a simplex has one corner more than dimensions") };
    Dim::<D>::determinant(&std::array::from_fn(|k| corners[k + 1] - corners[0]))
}

/// C_i: inward normals of the facets opposite to each corner, D! V ∇N_i.
#[inline]
pub fn cofactors<const D: usize, const N: usize>(corners: &[Vector<D>; N]) -> [Vector<D>; N]
where
    Dim<D>: Dimension<D>,
{
    std::array::from_fn(|i| {
        // Turned around, a facet looks inward.
        let mut facet = facet_corners::<D>(i);
        facet.swap(0, 1);
        Dim::<D>::facet_normal(&facet.map(|corner| corners[corner]))
    })
}

/// The corners of the facet opposite to corner `i`, so that its normal points outward from a
/// right-handed simplex: in the plane the next two, counter-clockwise.
#[inline]
pub const fn facet_corners<const D: usize>(i: usize) -> [usize; D] {
    let mut facet = [0; D];
    let mut k = 0;
    while k < D {
        facet[k] = (i + 1 + k) % (D + 1);
        k += 1;
    }
    // A cyclic shift of four corners is odd: every second facet would look inward.
    if D == 3 && i % 2 == 1 {
        (facet[1], facet[2]) = (facet[2], facet[1]);
    }
    facet
}

/// The shape functions of one simplex as they are evaluated at many points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape<const D: usize> {
    /// Corner 0 \[m\].
    origin: Vector<D>,
    /// ∇N_1 … ∇N_D \[1/m\]; the shape functions sum to one.
    gradient: [Vector<D>; D],
}

impl<const D: usize> Shape<D>
where
    Dim<D>: Dimension<D>,
{
    /// Of the simplex with these corners.
    pub fn new<const N: usize>(corners: &[Vector<D>; N]) -> Shape<D> {
        let (cofactors, determinant) = (cofactors(corners), determinant(corners));
        Shape {
            origin: corners[0],
            gradient: std::array::from_fn(|k| cofactors[k + 1].map(|n| n / determinant)),
        }
    }

    /// N_i of a point, outside of the simplex too: the first is 1 minus the others.
    #[inline(always)]
    pub fn weights<const N: usize>(&self, point: &Vector<D>) -> [f64; N] {
        const { assert!(N == D + 1, "a simplex has one corner more than dimensions") };
        let from = point - self.origin;
        let mut weights = [1.0; N];
        for k in 0..D {
            let mut weight = self.gradient[k][0] * from[0];
            for d in 1..D {
                weight += self.gradient[k][d] * from[d];
            }
            weights[k + 1] = weight;
            weights[0] -= weight;
        }
        weights
    }
}

/// N_i of a point, outside of the simplex too.
#[inline]
pub fn weights<const D: usize, const N: usize>(
    corners: &[Vector<D>; N],
    point: &Vector<D>,
) -> [f64; N]
where
    Dim<D>: Dimension<D>,
{
    Shape::new(corners).weights(point)
}

/// Is a point with these shape functions inside, with a tolerance of 1e-12?
#[inline(always)]
pub fn is_inside<const N: usize>(weights: &[f64; N]) -> bool {
    weights.iter().all(|&weight| weight >= INSIDE)
}

/// Shape functions of a point of the simplex near one that has these: none is negative, and they sum to one.
#[inline(always)]
pub fn clip<const N: usize>(weights: &[f64; N]) -> [f64; N] {
    let clipped = weights.map(|weight| weight.max(0.0));
    let sum: f64 = clipped.iter().sum();
    clipped.map(|weight| weight / sum)
}

/// The shape functions `weights` of a point clipped to the simplex, and the distance of the point from it (an
/// estimate: to the clipped point; exactly 0 inside).
#[inline]
pub fn project<const D: usize, const N: usize>(
    weights: &[f64; N],
    corners: &[Vector<D>; N],
    point: &Vector<D>,
) -> ([f64; N], f64)
where
    Dim<D>: Dimension<D>,
{
    let clipped = clip(weights);
    if is_inside(weights) {
        return (clipped, 0.0);
    }
    let nearest = combine(&clipped, corners);
    (clipped, hypot(&(point - nearest)).max(f64::MIN_POSITIVE))
}

/// Σ N_i x_i, in the order of the corners.
#[inline(always)]
pub fn combine<const D: usize, const N: usize>(
    weights: &[f64; N],
    values: &[Vector<D>; N],
) -> Vector<D> {
    let mut sum = values[0].map(|x| weights[0] * x);
    for i in 1..N {
        for d in 0..D {
            sum[d] += weights[i] * values[i][d];
        }
    }
    sum
}

/// Σ N_i f_i, in the order of the corners.
#[inline(always)]
pub fn interpolate<const N: usize>(weights: &[f64; N], values: &[f64; N]) -> f64 {
    let mut sum = weights[0] * values[0];
    for i in 1..N {
        sum += weights[i] * values[i];
    }
    sum
}
