//! Where grains are on the mesh: the simplex around a point and its linear shape functions.

use space::{Dim, Dimension, Period, Vector, periodic, simplex, simplex::Shape, vector};

use crate::error::{CouplerError, place};
use crate::transfer::bins::{Bins, Lists};
use crate::transfer::mesh::Mesh;

/// A bin that more simplices reach into is divided: where a mesh is graded, cells are much smaller than most bins.
const CROWDED: usize = 48;
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
    coarse: Lists<D>,
    /// The bins of a bin that is crowded.
    fine: Vec<Option<Lists<D>>>,
    simplices: Vec<[u32; N]>,
    corners: Vec<[Vector<D>; N]>,
    shapes: Vec<Shape<D>>,
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
        let every: Vec<u32> = (0..mesh.corners.len() as u32).collect();
        let bins = Bins::new(lower, upper, every.len());
        let coarse = Lists::new(bins, &bounds, &every);
        let fine = coarse.bins.all().enumerate().map(|(number, bin)| {
            let members = coarse.members(number);
            (members.len() > CROWDED).then(|| {
                let [lower, upper] = coarse.bins.bounds(&bin);
                Lists::new(Bins::new(lower, upper, members.len()), &bounds, members)
            })
        });
        Locator {
            fine: fine.collect(),
            coarse,
            simplices: mesh.simplices.clone(),
            corners: mesh.corners.clone(),
            shapes: mesh.corners.iter().map(Shape::new).collect(),
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
        let bins = &self.coarse.bins;
        let inside = periodic::into_box(point, bins.lower(), &self.period);
        let bin = bins.of(&inside);
        let number = bins.number(bin);
        let here = match &self.fine[number] {
            Some(fine) => fine.members(fine.bins.number(fine.bins.of(&inside))),
            None => self.coarse.members(number),
        };
        // nearly always it is in one of those that reach into its bin; only elsewhere distances matter
        for &index in here {
            let weights = self.weights(index, &inside);
            if simplex::is_inside(&weights) {
                return (0.0, self.stencil(index, simplex::clip(&weights)));
            }
        }
        let mut nearest = (f64::INFINITY, 0, [0.0; N]);
        for bin in (0..RINGS).flat_map(|ring| bins.ring(bin, ring)) {
            for &index in self.coarse.members(bin) {
                let corners = &self.corners[index as usize];
                let weights = self.weights(index, &inside);
                let (weights, distance) = simplex::project(&weights, corners, &inside);
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

    /// Shape functions of a simplex at a point in its coordinates, outside of it too.
    #[inline(always)]
    pub fn weights(&self, simplex: u32, point: &Vector<D>) -> [f64; N] {
        self.shapes[simplex as usize].weights(point)
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
