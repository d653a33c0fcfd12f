//! Straight paths through a mesh, thrown back by its boundary.

use space::{Dim, Dimension, Vector, simplex};

use crate::transfer::locate::Locator;
use crate::transfer::neighbours::Neighbours;

/// Simplices that a path may cross.
const CROSSED_MAX: usize = 10_000;

/// A point of the mesh, in the coordinates of its simplex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot<const D: usize> {
    /// The simplex around it.
    pub simplex: u32,
    /// The point \[m\].
    pub point: Vector<D>,
}

/// Where a path ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End<const D: usize, const N: usize> {
    /// The point that it reaches.
    pub spot: Spot<D>,
    /// Linear shape functions there, ≥ −1e-12.
    pub weights: [f64; N],
    /// Did the boundary throw it back?
    pub thrown_back: bool,
}

/// A mesh to walk through.
#[derive(Debug, Clone, Copy)]
pub struct Ground<'a, const D: usize, const N: usize> {
    /// The simplices.
    pub locator: &'a Locator<D, N>,
    /// What lies behind their facets.
    pub neighbours: &'a Neighbours<D, N>,
}

impl<const D: usize, const N: usize> Ground<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Go `by` \[m\] from a spot, thrown back by every facet of the boundary like light by a mirror, so
    /// that the end is in the mesh. None: after 10 000 simplices still on the way.
    pub fn go(&self, from: Spot<D>, by: &Vector<D>) -> Option<End<D, N>> {
        self.walk(from, by, Rim::ThrowsBack)
    }

    /// Go `by` \[m\] from a spot, as far as the boundary. None as above.
    pub fn go_to_the_rim(&self, from: Spot<D>, by: &Vector<D>) -> Option<End<D, N>> {
        self.walk(from, by, Rim::Stops)
    }

    fn walk(&self, from: Spot<D>, by: &Vector<D>, rim: Rim) -> Option<End<D, N>> {
        let (mut simplex, mut start) = (from.simplex, from.point);
        let (mut end, mut thrown_back) = (start + by, false);
        for _ in 0..CROSSED_MAX {
            let weights = self.locator.weights(simplex, &end);
            if simplex::is_inside(&weights) {
                let spot = Spot {
                    simplex,
                    point: end,
                };
                return Some(End {
                    spot,
                    weights,
                    thrown_back,
                });
            }
            let (facet, share) = way_out(&self.locator.weights(simplex, &start), &weights);
            match self.neighbours.behind(simplex, facet) {
                Some(behind) => {
                    simplex = behind.simplex;
                    start += behind.shift;
                    end += behind.shift;
                }
                None => {
                    start += (end - start) * share;
                    let corners = &self.locator.corners()[simplex as usize];
                    match rim {
                        Rim::ThrowsBack => end -= beyond(corners, facet, weights[facet]) * 2.0,
                        // inside, but for round-off
                        Rim::Stops => return Some(self.stop(simplex, start)),
                    }
                    thrown_back = true;
                }
            }
        }
        None
    }

    /// The end of a path at a point of a simplex.
    fn stop(&self, simplex: u32, point: Vector<D>) -> End<D, N> {
        End {
            spot: Spot { simplex, point },
            weights: self.locator.weights(simplex, &point),
            thrown_back: false,
        }
    }
}

/// What the boundary does to a path.
#[derive(Clone, Copy)]
enum Rim {
    ThrowsBack,
    Stops,
}

/// The facet through which a path leaves a simplex, and at which share of its length, by the shape
/// functions at its ends.
fn way_out<const N: usize>(start: &[f64; N], end: &[f64; N]) -> (usize, f64) {
    let mut first = (0, f64::INFINITY);
    for k in (0..N).filter(|&k| end[k] < simplex::INSIDE) {
        let inside = start[k].max(0.0);
        let share = inside / (inside - end[k]);
        if share < first.1 {
            first = (k, share);
        }
    }
    first
}

/// From the plane of a facet to a point whose shape function of the opposite corner is `weight`.
fn beyond<const D: usize, const N: usize>(
    corners: &[Vector<D>; N],
    facet: usize,
    weight: f64,
) -> Vector<D>
where
    Dim<D>: Dimension<D>,
{
    let normal = simplex::cofactors(corners)[facet];
    normal * (weight * simplex::determinant(corners) / normal.norm_squared())
}
