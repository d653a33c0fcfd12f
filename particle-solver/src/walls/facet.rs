//! A flat piece of wall, seen by the grains.

use space::dimension::factorial;
use space::{Dim, Dimension, Vector, dot, hypot, norm};

/// A wall with these corners \[m\]: in the plane the segment a → b, solid on its right; in space a
/// triangle, solid on the side from which its corners are seen counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facet<const D: usize> {
    /// Its corners.
    pub corners: [Vector<D>; D],
    /// At which it moves along itself \[m/s\].
    pub velocity: Vector<D>,
}

impl<const D: usize> Facet<D> {
    /// A wall that does not move.
    pub fn at_rest(corners: [Vector<D>; D]) -> Facet<D> {
        Facet {
            corners,
            velocity: Vector::zeros(),
        }
    }
}

/// A facet, prepared.
#[derive(Debug, Clone)]
pub struct Face<const D: usize> {
    /// Centroid \[m\].
    pub middle: Vector<D>,
    /// Unit normal, towards the grains.
    pub normal: Vector<D>,
    /// At which it moves along itself \[m/s\].
    pub velocity: Vector<D>,
    /// Side k begins at corner k: the corner itself in the plane, the edge to the next one in space.
    pub sides: [Side<D>; D],
    /// Corners from the middle \[m\].
    pub corners: [Vector<D>; D],
    /// From the middle to the farthest of them \[m\].
    pub extent: f64,
}

/// Where a face ends.
#[derive(Debug, Clone, Copy)]
pub struct Side<const D: usize> {
    /// Unit vector in the face, orthogonal to the side, into the face.
    pub inward: Vector<D>,
    /// From the middle of the face \[m\].
    pub distance: f64,
    /// The wall goes on towards the grains here (a concave corner): the face reaches beyond it, as far as
    /// this at most \[m\].
    pub extended: Option<f64>,
}

impl<const D: usize> Face<D>
where
    Dim<D>: Dimension<D>,
{
    /// Prepare a facet; its size (length, area) when that is not positive and finite.
    pub fn new(facet: &Facet<D>) -> Result<Face<D>, f64> {
        let corners = &facet.corners;
        let normal = Dim::<D>::inward_normal(corners);
        let size = norm(&normal) / factorial(D - 1) as f64;
        if !(size.is_finite() && size > 0.0) {
            return Err(size);
        }
        let middle = middle(corners);
        let sides = std::array::from_fn(|k| {
            let (inward, side_size) = inward(&side_of(corners, k), &corners[(k + D - 1) % D]);
            Side {
                inward,
                distance: size * (D - 1) as f64 / (side_size * D as f64),
                extended: None,
            }
        });
        Ok(Face {
            middle,
            normal: normal * (1.0 / norm(&normal)),
            velocity: facet.velocity,
            sides,
            corners: corners.map(|corner| corner - middle),
            extent: corners
                .map(|c| norm(&(c - middle)))
                .into_iter()
                .fold(0.0, f64::max),
        })
    }

    /// Does it move along itself, but for round-off?
    pub fn moves_along(&self) -> bool {
        const ASIDE: f64 = 1e-6;
        dot(&self.velocity, &self.normal).abs() <= ASIDE * hypot(&self.velocity)
    }

    /// Above the face \[m\].
    #[inline]
    pub fn height(&self, offset: &Vector<D>) -> f64 {
        dot(offset, &self.normal)
    }

    /// From the foot of a point to each side \[m\], negative beyond it.
    #[inline]
    pub fn left(&self, offset: &Vector<D>) -> [f64; D] {
        std::array::from_fn(|k| self.sides[k].distance + dot(offset, &self.sides[k].inward))
    }

    /// To the nearest point of the face \[m\].
    pub fn distance(&self, offset: &Vector<D>) -> f64 {
        if self.left(offset).iter().all(|&left| left >= 0.0) {
            return self.height(offset).abs();
        }
        let mut nearest = f64::INFINITY;
        for first in 0..D {
            for second in first + 1..D {
                let edge = self.corners[second] - self.corners[first];
                let from = offset - self.corners[first];
                let part = (dot(&from, &edge) / dot(&edge, &edge)).clamp(0.0, 1.0);
                nearest = nearest.min(norm(&(from - edge * part)));
            }
        }
        nearest
    }

    /// How far the face may reach beyond its corners when it reaches 1 beyond its sides: 1 in the
    /// plane, 1/sin(θ/2) at a corner of angle θ.
    pub fn spread(&self) -> f64 {
        let mut spread = 1.0f64;
        for &[k, l] in Dim::<D>::FACET_EDGES {
            let cosine = dot(&self.sides[k].inward, &self.sides[l].inward);
            spread = spread.max((2.0 / (1.0 + cosine)).sqrt());
        }
        spread
    }
}

/// Corners of side `k`.
pub fn side_of<const D: usize>(corners: &[Vector<D>; D], k: usize) -> Vec<Vector<D>> {
    (k..k + D - 1).map(|corner| corners[corner % D]).collect()
}

/// Mean of some points.
pub fn middle<const D: usize>(points: &[Vector<D>]) -> Vector<D> {
    let sum = points[1..].iter().fold(points[0], |sum, point| sum + point);
    sum * (1.0 / points.len() as f64)
}

/// Unit vector from a side to the corner opposite to it, orthogonal to the side, and the size of the
/// side: 1 of a corner, the length of an edge.
fn inward<const D: usize>(side: &[Vector<D>], opposite: &Vector<D>) -> (Vector<D>, f64) {
    let mut inward = opposite - side[0];
    let mut size = 1.0;
    for corner in &side[1..] {
        let along = corner - side[0];
        let length = norm(&along);
        let unit = along * (1.0 / length);
        inward -= unit * dot(&inward, &unit);
        size *= length;
    }
    (inward * (1.0 / norm(&inward)), size)
}
