//! Where grains are on the mesh: the simplex around a point and its linear shape functions.

use space::{Dim, Dimension, Period, Vector, periodic, simplex, vector};

use crate::error::{CouplerError, place};
use crate::transfer::bins::Bins;
use crate::transfer::mesh::Mesh;

/// Bins looked into around that of a point: beyond, it is outside the mesh.
const RINGS: usize = 3;

/// The nodes around one point and their shape functions; the weights sum to one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stencil<const N: usize> {
    /// The simplex.
    pub simplex: u32,
    /// Its corner nodes.
    pub nodes: [u32; N],
    /// Linear shape functions at the point, ≥ 0.
    pub weights: [f64; N],
}

/// The simplices of a mesh by bins, each bin with those that reach into it.
#[derive(Debug)]
pub struct Locator<const D: usize, const N: usize> {
    bins: Bins<D>,
    /// Simplices of bin b: `members[start[b]..start[b + 1]]`.
    start: Vec<usize>,
    members: Vec<u32>,
    simplices: Vec<[u32; N]>,
    corners: Vec<[Vector<D>; N]>,
    period: Period<D>,
    /// How far outside the mesh a point may lie \[m\]: one simplex.
    outside_max: f64,
}

impl<const D: usize, const N: usize> Locator<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Sort the simplices of a mesh into bins.
    pub fn new(mesh: &Mesh<D, N>) -> Locator<D, N> {
        let bounds: Vec<_> = mesh.corners.iter().map(bounds).collect();
        let (mut lower, mut upper) = (infinity::<D>(), -infinity::<D>());
        let mut outside_max = 0.0_f64;
        for (low, high) in &bounds {
            (lower, upper) = (lower.inf(low), upper.sup(high));
            outside_max = outside_max.max((high - low).max());
        }
        let bins = Bins::new(lower, upper, mesh.corners.len());
        let mut sorted = vec![Vec::new(); bins.count()];
        for (index, (low, high)) in bounds.iter().enumerate() {
            for bin in bins.range(bins.of(low), bins.of(high)) {
                sorted[bin].push(index as u32);
            }
        }
        let mut start = vec![0];
        start.extend(sorted.iter().scan(0, |count, bin| {
            *count += bin.len();
            Some(*count)
        }));
        Locator {
            bins,
            start,
            members: sorted.concat(),
            simplices: mesh.simplices.clone(),
            corners: mesh.corners.clone(),
            period: mesh.period,
            outside_max,
        }
    }

    /// The stencil of a point. Just outside the mesh it is that of the nearest simplex, clipped.
    pub fn locate(&self, grain: usize, point: &Vector<D>) -> Result<Stencil<N>, CouplerError> {
        let outside = || CouplerError::GrainOutside {
            grain,
            at: place(point),
        };
        if !point.iter().all(|x| x.is_finite()) {
            return Err(outside());
        }
        let (distance, stencil) = self.nearest(point);
        if distance <= self.outside_max {
            Ok(stencil)
        } else {
            Err(outside())
        }
    }

    /// Is a point in no simplex?
    pub fn is_outside(&self, point: &Vector<D>) -> bool {
        self.nearest(point).0 > 0.0
    }

    /// The stencil of the nearest point of the mesh, and the distance to it \[m\]; infinite where there is
    /// none around.
    fn nearest(&self, point: &Vector<D>) -> (f64, Stencil<N>) {
        let inside = periodic::into_box(point, self.bins.lower(), &self.period);
        let centre = self.bins.of(&inside);
        let mut nearest = (f64::INFINITY, 0, [0.0; N]);
        for bin in (0..RINGS).flat_map(|ring| self.bins.ring(centre, ring)) {
            for &index in &self.members[self.start[bin]..self.start[bin + 1]] {
                let (weights, distance) = simplex::project(&self.corners[index as usize], &inside);
                if distance == 0.0 {
                    return (0.0, self.stencil(index, weights));
                }
                if distance < nearest.0 {
                    nearest = (distance, index, weights);
                }
            }
        }
        (nearest.0, self.stencil(nearest.1, nearest.2))
    }

    fn stencil(&self, index: u32, weights: [f64; N]) -> Stencil<N> {
        Stencil {
            simplex: index,
            nodes: self.simplices[index as usize],
            weights,
        }
    }

    /// Corner nodes of every simplex.
    pub fn simplices(&self) -> &[[u32; N]] {
        &self.simplices
    }

    /// Corners of every simplex \[m\].
    pub fn corners(&self) -> &[[Vector<D>; N]] {
        &self.corners
    }

    /// Period along each axis \[m\].
    pub fn period(&self) -> &Period<D> {
        &self.period
    }

    /// The corner nodes of a simplex.
    pub fn nodes(&self, simplex: u32) -> &[u32; N] {
        &self.simplices[simplex as usize]
    }

    /// The point of a stencil, in the coordinates of its simplex \[m\].
    pub fn point(&self, stencil: &Stencil<N>) -> Vector<D> {
        simplex::combine(&stencil.weights, &self.corners[stencil.simplex as usize])
    }
}

/// Lower and upper corner of the box around a simplex.
fn bounds<const D: usize, const N: usize>(corners: &[Vector<D>; N]) -> (Vector<D>, Vector<D>) {
    let first = (infinity::<D>(), -infinity::<D>());
    let wider = |(low, high): (Vector<D>, Vector<D>), corner: &Vector<D>| {
        (low.inf(corner), high.sup(corner))
    };
    corners.iter().fold(first, wider)
}

fn infinity<const D: usize>() -> Vector<D> {
    vector::from_fn(|_| f64::INFINITY)
}
