//! Meshes that are fine where a size function says so: bisected from the root, every time anew.
//!
//! ```text
//!   root cell → D! simplices (Kuhn): corner, then along the axes in one of D! orders
//!   simplex (x0 … xD), tag k (root: D)  →  z = (x0 + xk)/2,
//!       (x0 … xk−1, z, xk+1 … xD)  and  (x1 … xk, z, xk+1 … xD),  tag k − 1, or D where k = 1     (B1)
//!   size = H 2^(−generation/D),  H: edge of a cube as large as a root cell                            (B2)
//! ```
//!
//! (B1) is Maubach, SIAM J. Sci. Comput. 16 (1995). A simplex is divided while its size is above h at a corner or
//! in its middle, or an edge of it has a vertex in its middle. Which simplices there are in the end depends on
//! h alone, not on an order or on an earlier mesh; where h₁ ≤ h₂ the mesh of h₁ divides that of h₂. Nothing is kept but
//! the vertices, by their whole coordinates: a simplex is divided if the middle of the edge that (B1) halves is a
//! vertex, so a point is found by descent from its root cell.

use rustc_hash::FxHashMap;
use space::{Dim, Dimension, Vector, dimension::factorial, periodic, simplex, vector};

use super::simplices::Mesh;
use super::sizes::Sizes;
use crate::error::FluidError;

/// Halvings of a root cell along each axis at most.
pub const LEVELS: u32 = 20;
/// Root cells along an axis at most: whole coordinates fit 32 bits.
pub const CELLS_MAX: usize = 1 << (31 - LEVELS);
/// A wish for h counts as met by a size that is larger by less than this share.
const ROUND_OFF: f64 = 1e-9;
/// Names of the sides, in the order of their numbers.
const SIDES: [&str; 6] = ["left", "right", "bottom", "top", "back", "front"];

/// Whole coordinates: a root cell is 2^[`LEVELS`] long along each axis.
type Point<const D: usize> = [u32; D];

/// A box of cells from which a mesh is refined.
#[derive(Debug, Clone, PartialEq)]
pub struct Root<const D: usize> {
    /// Lower corner \[m\].
    pub lower: Vector<D>,
    /// Upper corner \[m\].
    pub upper: Vector<D>,
    /// Cells along each axis.
    pub cells: [usize; D],
    /// Axes along which opposite sides are joined.
    pub periodic: [bool; D],
}

impl<const D: usize> Root<D> {
    fn validate(&self) -> Result<(), FluidError> {
        for d in 0..D {
            let (lower, upper, cells) = (self.lower[d], self.upper[d], self.cells[d]);
            if !(lower.is_finite() && upper.is_finite() && upper > lower) {
                let why = format!("box: upper corner {upper} must exceed lower corner {lower}");
                return Err(FluidError::Mesh(why));
            }
            if !(1..=CELLS_MAX).contains(&cells) {
                return Err(FluidError::Mesh(format!(
                    "{cells} cells along an axis; a mesh that is refined begins with 1 to {CELLS_MAX}"
                )));
            }
        }
        Ok(())
    }

    /// H of (B2) \[m\].
    pub fn size(&self) -> f64 {
        let edges = (0..D).map(|d| (self.upper[d] - self.lower[d]) / self.cells[d] as f64);
        simplex::cube_edge::<D>(edges.product())
    }

    /// Period along each axis \[m\].
    pub fn period(&self) -> space::Period<D> {
        std::array::from_fn(|d| self.periodic[d].then(|| self.upper[d] - self.lower[d]))
    }

    /// Whole coordinate of the upper end of an axis.
    fn end(&self, axis: usize) -> u32 {
        (self.cells[axis] as u32) << LEVELS
    }

    /// Where a point is \[m\].
    fn position(&self, point: &Point<D>) -> Vector<D> {
        vector::from_fn(|d| match self.end(d) {
            end if point[d] == end => self.upper[d],
            end => {
                let share = f64::from(point[d]) / f64::from(end);
                self.lower[d] + (self.upper[d] - self.lower[d]) * share
            }
        })
    }

    /// The same point for all of its periodic images.
    fn vertex(&self, mut point: Point<D>) -> Point<D> {
        for d in 0..D {
            if self.periodic[d] && point[d] == self.end(d) {
                point[d] = 0;
            }
        }
        point
    }

    /// The simplices of all root cells.
    fn simplices<const N: usize>(&self) -> impl Iterator<Item = Part<D, N>> + '_ {
        let cells = 0..self.cells.iter().product();
        cells.flat_map(move |cell: usize| {
            let mut rest = cell;
            let corner: Point<D> = std::array::from_fn(|d| {
                let at = rest % self.cells[d];
                rest /= self.cells[d];
                (at as u32) << LEVELS
            });
            orders::<D>().map(move |order| Part::kuhn(corner, order))
        })
    }
}

/// All orders of the axes.
fn orders<const D: usize>() -> impl Iterator<Item = [usize; D]> {
    (0..factorial(D)).map(|mut code| {
        let mut left: Vec<usize> = (0..D).collect();
        std::array::from_fn(|d| {
            let choices = D - d;
            let chosen = code % choices;
            code /= choices;
            left.remove(chosen)
        })
    })
}

/// A simplex on its way.
#[derive(Debug, Clone, Copy)]
struct Part<const D: usize, const N: usize> {
    corners: [Point<D>; N],
    tag: u8,
    generation: u8,
}

/// The middle of an edge, where it has one in whole coordinates.
#[inline]
fn middle<const D: usize>(a: &Point<D>, b: &Point<D>) -> Option<Point<D>> {
    let even = (0..D).all(|d| (a[d] + b[d]).is_multiple_of(2));
    even.then(|| std::array::from_fn(|d| (a[d] + b[d]) / 2))
}

impl<const D: usize, const N: usize> Part<D, N> {
    /// One of the D! simplices of a root cell.
    fn kuhn(corner: Point<D>, order: [usize; D]) -> Part<D, N> {
        let mut corners = [corner; N];
        for (k, &axis) in order.iter().enumerate() {
            corners[k + 1] = corners[k];
            corners[k + 1][axis] += 1 << LEVELS;
        }
        Part {
            corners,
            tag: D as u8,
            generation: 0,
        }
    }

    /// The middle of the edge that is halved next; none at the last level.
    fn halved(&self) -> Option<Point<D>> {
        middle(&self.corners[0], &self.corners[self.tag as usize])
    }

    /// (B1)
    fn bisect(&self, middle: Point<D>) -> [Part<D, N>; 2] {
        let k = self.tag as usize;
        let (mut first, mut second) = (*self, *self);
        first.corners[k] = middle;
        for i in 0..k {
            second.corners[i] = self.corners[i + 1];
        }
        second.corners[k] = middle;
        for child in [&mut first, &mut second] {
            child.tag = if k > 1 { self.tag - 1 } else { D as u8 };
            child.generation += 1;
        }
        [first, second]
    }
}

/// A mesh, and how points are found in it.
#[derive(Debug, Clone)]
pub struct Bisection<const D: usize, const N: usize> {
    root: Root<D>,
    /// The node of each vertex.
    nodes: FxHashMap<Point<D>, u32>,
}

/// A mesh on its way.
struct Refinement<'a, const D: usize, const N: usize> {
    root: &'a Root<D>,
    sizes: &'a Sizes<D>,
    /// h of every vertex.
    vertices: FxHashMap<Point<D>, f64>,
    leaves: Vec<Part<D, N>>,
    leaves_max: usize,
    /// (B2) of each generation \[m\], less round-off.
    smaller_than: Vec<f64>,
}

impl<const D: usize, const N: usize> Bisection<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Refine a root until no cell is larger than asked; an error where that takes more than `simplices_max`.
    pub fn new(
        root: &Root<D>,
        sizes: &Sizes<D>,
        simplices_max: usize,
    ) -> Result<(Bisection<D, N>, Mesh<D, N>), FluidError> {
        root.validate()?;
        let size = |generation: u32| root.size() * (-f64::from(generation) / D as f64).exp2();
        let generations = 0..=D as u32 * LEVELS;
        let mut refinement = Refinement {
            root,
            sizes,
            vertices: FxHashMap::default(),
            leaves: Vec::new(),
            leaves_max: simplices_max,
            smaller_than: generations.map(|g| size(g) / (1.0 + ROUND_OFF)).collect(),
        };
        refinement.divide()?;
        refinement.close()?;
        refinement.finish()
    }

    /// What it was refined from.
    pub fn root(&self) -> &Root<D> {
        &self.root
    }

    /// The nodes around a point and their linear shape functions; of a point outside of the box, the nearest in it.
    pub fn locate(&self, point: &Vector<D>) -> ([u32; N], [f64; N]) {
        let root = &self.root;
        let inside = periodic::into_box(point, &root.lower, &root.period());
        let mut corner: Point<D> = [0; D];
        let mut fraction = [0.0; D];
        for d in 0..D {
            let along = (inside[d] - root.lower[d]) / (root.upper[d] - root.lower[d]);
            let along = along.clamp(0.0, 1.0) * root.cells[d] as f64;
            let cell = (along as usize).min(root.cells[d] - 1);
            corner[d] = (cell as u32) << LEVELS;
            fraction[d] = along - cell as f64;
        }
        let mut order: [usize; D] = std::array::from_fn(|d| d);
        order.sort_by(|&a, &b| fraction[b].total_cmp(&fraction[a]));
        let mut part = Part::<D, N>::kuhn(corner, order);
        let mut weights = [0.0; N];
        weights[0] = 1.0 - fraction[order[0]];
        for k in 1..D {
            weights[k] = fraction[order[k - 1]] - fraction[order[k]];
        }
        weights[D] = fraction[order[D - 1]];
        while let Some(middle) = part.halved().filter(|middle| self.has(middle)) {
            let k = part.tag as usize;
            let [first, second] = part.bisect(middle);
            if weights[0] >= weights[k] {
                weights[0] -= weights[k];
                weights[k] *= 2.0;
                part = first;
            } else {
                let (least, rest) = (weights[0], weights[k] - weights[0]);
                weights.copy_within(1..k, 0);
                weights[k - 1] = rest;
                weights[k] = 2.0 * least;
                part = second;
            }
        }
        let node = |corner: &Point<D>| self.nodes.get(&root.vertex(*corner)).copied();
        // every corner of a simplex that is not divided is a vertex
        (
            part.corners.map(|corner| node(&corner).unwrap_or(0)),
            weights,
        )
    }

    fn has(&self, point: &Point<D>) -> bool {
        self.nodes.contains_key(&self.root.vertex(*point))
    }
}

impl<const D: usize, const N: usize> Refinement<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// h of a vertex, which is there from now on.
    fn visit(&mut self, point: &Point<D>) -> f64 {
        let (root, sizes) = (self.root, self.sizes);
        let known = self.vertices.entry(root.vertex(*point));
        *known.or_insert_with(|| sizes.at(&root.position(point)))
    }

    /// Divide every simplex of the root while it is too large.
    fn divide(&mut self) -> Result<(), FluidError> {
        let root = self.root;
        let mut waiting = Vec::new();
        for part in root.simplices() {
            waiting.push(part);
            while let Some(part) = waiting.pop() {
                // asked of all, so that every corner is a vertex
                let too_large = self.is_too_large(&part);
                match part.halved().filter(|_| too_large) {
                    Some(middle) => {
                        let [first, second] = part.bisect(middle);
                        waiting.extend([second, first]);
                    }
                    None => self.keep(part)?,
                }
            }
        }
        Ok(())
    }

    fn is_too_large(&mut self, part: &Part<D, N>) -> bool {
        let size = self.smaller_than[part.generation as usize];
        let mut smallest = f64::INFINITY;
        let mut centre = Vector::<D>::zeros();
        for corner in &part.corners {
            smallest = smallest.min(self.visit(corner));
            centre += self.root.position(corner) / N as f64;
        }
        size > smallest || size > self.sizes.at(&centre)
    }

    fn keep(&mut self, part: Part<D, N>) -> Result<(), FluidError> {
        self.leaves.push(part);
        match self.leaves.len() <= self.leaves_max {
            true => Ok(()),
            false => Err(FluidError::TooFine {
                simplex: Dim::<D>::SIMPLEX,
                most: self.leaves_max,
            }),
        }
    }

    /// Divide every simplex while an edge of it has a vertex in its middle, and what is made so while it is too
    /// large: h at that vertex was not asked before.
    fn close(&mut self) -> Result<(), FluidError> {
        loop {
            let before = std::mem::take(&mut self.leaves);
            self.leaves.reserve(before.len() + before.len() / 4);
            let mut changed = false;
            let mut waiting = Vec::new();
            for part in before {
                waiting.push((part, false));
                while let Some((part, new)) = waiting.pop() {
                    let halved = part.halved();
                    let too_large = new && self.is_too_large(&part);
                    match halved.filter(|_| too_large || self.hangs(&part)) {
                        Some(middle) => {
                            changed = true;
                            self.visit(&middle);
                            let [first, second] = part.bisect(middle);
                            waiting.extend([(second, true), (first, true)]);
                        }
                        None => self.keep(part)?,
                    }
                }
            }
            if !changed {
                return Ok(());
            }
        }
    }

    /// Has an edge a vertex in its middle?
    fn hangs(&self, part: &Part<D, N>) -> bool {
        let there = |point: Point<D>| self.vertices.contains_key(&self.root.vertex(point));
        (0..N).any(|i| {
            let others = i + 1..N;
            let middles = others.filter_map(|j| middle(&part.corners[i], &part.corners[j]));
            middles.into_iter().any(there)
        })
    }

    /// Number vertices as simplices meet them, and simplices by descent.
    fn finish(self) -> Result<(Bisection<D, N>, Mesh<D, N>), FluidError> {
        let root = self.root;
        let mut nodes =
            FxHashMap::with_capacity_and_hasher(self.vertices.len(), Default::default());
        let mut position = Vec::with_capacity(self.vertices.len());
        let mut simplices = Vec::with_capacity(self.leaves.len());
        let mut corners = Vec::with_capacity(self.leaves.len());
        let mut sides = Vec::new();
        for part in &self.leaves {
            let mut points = part.corners;
            let mut places = points.map(|point| root.position(&point));
            if simplex::determinant(&places) < 0.0 {
                points.swap(D - 1, D);
                places.swap(D - 1, D);
            }
            let own = points.map(|point| {
                let vertex = root.vertex(point);
                *nodes.entry(vertex).or_insert_with(|| {
                    position.push(root.position(&vertex));
                    position.len() as u32 - 1
                }) as usize
            });
            note_sides(root, &points, simplices.len(), &mut sides);
            simplices.push(own);
            corners.push(places);
        }
        let mut mesh = Mesh::without_facets(position, simplices, corners, |t| t)?;
        mesh.boundary_names = SIDES[..2 * D].iter().map(ToString::to_string).collect();
        let facets = sides.iter();
        mesh.facets = facets.map(|&(t, k, side)| mesh.facet(t, k, side)).collect();
        mesh.period = root.period();
        let root = root.clone();
        Ok((Bisection { root, nodes }, mesh))
    }
}

/// Sides of a simplex that lie on a side of the box which is not joined: simplex, corner opposite to it, side.
fn note_sides<const D: usize, const N: usize>(
    root: &Root<D>,
    points: &[Point<D>; N],
    number: usize,
    sides: &mut Vec<(usize, usize, usize)>,
) {
    for k in 0..N {
        let facet = simplex::facet_corners::<D>(k);
        for d in (0..D).filter(|&d| !root.periodic[d]) {
            for (end, side) in [(0, 2 * d), (root.end(d), 2 * d + 1)] {
                if facet.iter().all(|&corner| points[corner][d] == end) {
                    sides.push((number, k, side));
                }
            }
        }
    }
}
