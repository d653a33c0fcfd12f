//! Meshes that are fine where a size function says so: bisected from the root, every time anew.
//!
//! ```text
//!   simplex, an edge (a, b) of it  →  z = (a + b)/2: one half without b, one without a, both with z   (B1)
//!   size = H 2^(−generation/D),  H: edge of a cube of D! times the volume of the root's simplex       (B2)
//! ```
//!
//! A simplex is divided while its size is above h at a corner or in its middle, or an edge of it has a vertex in its
//! middle. Which edge is halved is the simplex's own affair ([`Forest`]: [`super::root`], [`super::longest`]), so that
//! which simplices there are in the end depends on h alone, not on an order or on an earlier mesh; where h₁ ≤ h₂ the
//! mesh of h₁ divides that of h₂. Nothing is kept but the vertices, by their places: a simplex is divided if the
//! middle of the edge that (B1) halves is a vertex, so a point is found by descent from its simplex of the root.

use std::hash::{Hash, Hasher};

use rustc_hash::{FxHashMap, FxHashSet};
use space::{Dim, Dimension, Vector, norm, simplex};

use super::simplices::Mesh;
use super::sizes::Sizes;
use crate::error::FluidError;

/// Halvings of a simplex along each axis at most.
pub const LEVELS: u32 = 20;
/// A wish for h counts as met by a size that is larger by less than this share.
const ROUND_OFF: f64 = 1e-9;
/// Of a side inside of the domain, or one that is joined to another.
pub const INSIDE: u16 = u16::MAX;

/// What a mesh is refined from: simplices, each the root of a tree of its halves.
pub trait Forest<const D: usize, const N: usize> {
    /// A corner of a simplex.
    type Point: Copy;
    /// Coordinates of a vertex, which is one for all images of a point.
    type Coordinate: Copy + Eq + Into<u64>;

    /// An error where nothing can be refined from it.
    fn validate(&self) -> Result<(), FluidError>;

    /// Its simplices, in their order.
    fn simplices(&self) -> impl Iterator<Item = Part<Self::Point, N>> + '_;

    /// The vertex at a point.
    fn vertex(&self, point: &Self::Point) -> Vertex<Self::Coordinate, D>;

    /// Where a point is \[m\].
    fn position(&self, point: &Self::Point) -> Vector<D>;

    /// Where a vertex is \[m\].
    fn place(&self, vertex: &Vertex<Self::Coordinate, D>) -> Vector<D>;

    /// The middle of an edge; none where it cannot be told from its ends.
    fn middle(&self, a: &Self::Point, b: &Self::Point) -> Option<Self::Point>;

    /// Numbers of the corners between which (B1) halves a simplex.
    fn edge(&self, part: &Part<Self::Point, N>) -> (usize, usize);

    /// What belongs to the corners of both halves, from what belongs to those of the whole and to the middle of the edge
    /// (a, b): the first is without b, the second without a.
    fn halves<T: Copy>(edge: (usize, usize), whole: &[T; N], middle: T) -> [[T; N]; 2];

    /// Names of the boundaries, in the order of their numbers.
    fn boundary_names(&self) -> Vec<String>;

    /// Period along each axis \[m\].
    fn period(&self) -> space::Period<D>;

    /// The same box of simplices twice as large; none where there is no such.
    fn coarser(&self) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }

    /// The simplex that a place is in; none where that would have to be searched.
    fn home(&self, _place: &Vector<D>) -> Option<u32> {
        None
    }
}

/// Where a vertex is, exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Vertex<C, const D: usize>(pub [C; D]);

impl<C: Copy + Into<u64>, const D: usize> Hash for Vertex<C, D> {
    #[inline]
    fn hash<H: Hasher>(&self, state: &mut H) {
        for coordinate in self.0 {
            state.write_u64(coordinate.into());
        }
    }
}

/// A simplex on its way.
#[derive(Debug, Clone, Copy)]
pub struct Part<P, const N: usize> {
    /// Its corners.
    pub corners: [P; N],
    /// The boundary that the side opposite to each corner belongs to, or [`INSIDE`].
    pub sides: [u16; N],
    /// How often it was halved.
    pub generation: u8,
    /// The simplex of the root that it is in.
    pub home: u32,
    /// H of (B2) \[m\].
    pub size: f64,
}

/// The edge of (B1) and its middle; none at the last level.
#[inline]
fn halved<F: Forest<D, N>, const D: usize, const N: usize>(
    root: &F,
    part: &Part<F::Point, N>,
) -> Option<((usize, usize), F::Point)> {
    if u32::from(part.generation) >= D as u32 * LEVELS {
        return None;
    }
    let (a, b) = root.edge(part);
    let middle = root.middle(&part.corners[a], &part.corners[b])?;
    Some(((a, b), middle))
}

/// (B1)
#[inline]
fn bisect<F: Forest<D, N>, const D: usize, const N: usize>(
    part: &Part<F::Point, N>,
    (a, b): (usize, usize),
    middle: F::Point,
) -> [Part<F::Point, N>; 2] {
    let corners = F::halves((a, b), &part.corners, middle);
    // the side opposite to the corner that stays is the cut
    let sides = |cut: usize, gone: usize| {
        let mut sides = part.sides;
        sides[cut] = INSIDE;
        F::halves((a, b), &sides, part.sides[gone])
    };
    let sides = [sides(a, b)[0], sides(b, a)[1]];
    std::array::from_fn(|half| Part {
        corners: corners[half],
        sides: sides[half],
        generation: part.generation + 1,
        ..*part
    })
}

type Vertices<C, V, const D: usize> = FxHashMap<Vertex<C, D>, V>;

/// A mesh, and how points are found in it.
#[derive(Debug, Clone)]
pub struct Bisection<F: Forest<D, N>, const D: usize, const N: usize> {
    root: F,
    vertices: Vertices<F::Coordinate, Known, D>,
    /// A simplex of the root that each node lies in, and where it is there \[m\].
    homes: Vec<(u32, Vector<D>)>,
}

/// What is known of a vertex: h \[m\], its node in the end.
#[derive(Debug, Clone, Copy)]
struct Known {
    wish: f64,
    node: u32,
}

/// No node yet.
const NO_NODE: u32 = u32::MAX;

/// Shape functions of a vertex in its simplex of the root are halves of halves: without round-off, a node that stays
/// keeps its values.
fn exact<const N: usize>(weights: [f64; N]) -> [f64; N] {
    let whole = f64::from(LEVELS * 2).exp2();
    let mut weights = weights.map(|weight| (weight * whole).round() / whole);
    weights[0] = 1.0 - weights[1..].iter().sum::<f64>();
    weights
}

fn too_deep() -> FluidError {
    FluidError::Mesh(format!(
        "cells that are halved more than {LEVELS} times along an axis"
    ))
}

/// A mesh on its way.
struct Refinement<'a, F: Forest<D, N>, const D: usize, const N: usize> {
    root: &'a F,
    sizes: &'a Sizes<D>,
    vertices: Vertices<F::Coordinate, Known, D>,
    leaves: Vec<Part<F::Point, N>>,
    leaves_max: usize,
    /// 2^(−generation/D), less round-off.
    shrunk: Vec<f64>,
}

/// A simplex, and h of its corners \[m\].
type Wished<P, const N: usize> = (Part<P, N>, [f64; N]);

/// Nodes of a mesh around a point, and their linear shape functions there.
pub type Spot<const N: usize> = ([u32; N], [f64; N]);

impl<F: Forest<D, N> + Clone, const D: usize, const N: usize> Bisection<F, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Refine a root until no cell is larger than asked; an error where that takes more than `simplices_max`.
    pub fn new(
        root: &F,
        sizes: &Sizes<D>,
        simplices_max: usize,
    ) -> Result<(Self, Mesh<D, N>), FluidError> {
        root.validate()?;
        let shrunk = |generation: u32| (-f64::from(generation) / D as f64).exp2();
        let generations = 0..=D as u32 * LEVELS;
        let mut refinement = Refinement {
            root,
            sizes,
            vertices: FxHashMap::default(),
            leaves: Vec::new(),
            leaves_max: simplices_max,
            shrunk: generations.map(|g| shrunk(g) / (1.0 + ROUND_OFF)).collect(),
        };
        refinement.divide()?;
        refinement.close()?;
        refinement.finish()
    }

    /// What it was refined from.
    pub fn root(&self) -> &F {
        &self.root
    }

    /// The nodes of another mesh of the same root, in this one.
    pub fn spots_of(&self, other: &Self) -> Vec<Spot<N>> {
        self.spots(other.homes.iter().copied())
    }

    /// The nodes of a mesh of another root, in this one.
    pub fn spots_by_place(&self, other: &Self) -> Vec<Spot<N>> {
        let homes = other.homes.iter();
        self.spots(homes.map(|&(home, place)| (self.root.home(&place).unwrap_or(home), place)))
    }

    fn spots(&self, homes: impl Iterator<Item = (u32, Vector<D>)>) -> Vec<Spot<N>> {
        let roots: Vec<Part<F::Point, N>> = self.root.simplices().collect();
        let spot = |(home, place): (u32, Vector<D>)| {
            let part = roots[home as usize];
            let corners = part.corners.map(|corner| self.root.position(&corner));
            self.descend(part, exact(simplex::weights(&corners, &place)))
        };
        homes.map(spot).collect()
    }

    /// The nodes around a point and their shape functions, from the simplex of the root that it lies in.
    fn descend(&self, mut part: Part<F::Point, N>, mut weights: [f64; N]) -> Spot<N> {
        while let Some(((a, b), middle)) = halved(&self.root, &part)
            && self.vertices.contains_key(&self.root.vertex(&middle))
        {
            let halves = bisect::<F, D, N>(&part, (a, b), middle);
            let (stays, gone, half) = match weights[a] >= weights[b] {
                true => (a, b, 0),
                false => (b, a, 1),
            };
            let gone = weights[gone];
            weights[stays] -= gone;
            weights = F::halves((a, b), &weights, 2.0 * gone)[half];
            part = halves[half];
        }
        let node = |corner: &F::Point| self.vertices.get(&self.root.vertex(corner));
        // every corner of a simplex that is not divided is a vertex
        let nodes = part
            .corners
            .map(|corner| node(&corner).map_or(0, |known| known.node));
        (nodes, weights)
    }
}

impl<F: Forest<D, N> + Clone, const D: usize, const N: usize> Refinement<'_, F, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// h of a vertex, which is there from now on.
    fn visit(&mut self, point: &F::Point) -> f64 {
        let (root, sizes) = (self.root, self.sizes);
        let known = self.vertices.entry(root.vertex(point));
        let new = || Known {
            wish: sizes.at(&root.position(point)),
            node: NO_NODE,
        };
        known.or_insert_with(new).wish
    }

    /// Divide every simplex of the root while it is too large.
    fn divide(&mut self) -> Result<(), FluidError> {
        let root = self.root;
        let mut waiting: Vec<Wished<F::Point, N>> = Vec::new();
        for part in root.simplices() {
            waiting.push((part, part.corners.map(|corner| self.visit(&corner))));
            while let Some((part, wishes)) = waiting.pop() {
                let too_large = self.is_too_large(&part, &wishes);
                match halved(root, &part).filter(|_| too_large) {
                    Some((edge, middle)) => {
                        let wishes = F::halves(edge, &wishes, self.visit(&middle));
                        let [first, second] = bisect::<F, D, N>(&part, edge, middle);
                        waiting.extend([(second, wishes[1]), (first, wishes[0])]);
                    }
                    None => self.keep(part)?,
                }
            }
        }
        Ok(())
    }

    fn is_too_large(&self, part: &Part<F::Point, N>, wishes: &[f64; N]) -> bool {
        let size = part.size * self.shrunk[part.generation as usize];
        if wishes.iter().any(|&wish| size > wish) {
            return true;
        }
        let places = part.corners.map(|corner| self.root.position(&corner));
        let mut centre = Vector::<D>::zeros();
        places.iter().for_each(|place| centre += place / N as f64);
        // h of the centre differs from that of a corner by no more than the way between them allows
        let not_below = |(place, wish): (&Vector<D>, &f64)| {
            wish - self.sizes.change(norm(&(place - centre))) >= size
        };
        let far_from_it = places.iter().zip(wishes).any(not_below);
        !far_from_it && self.sizes.are_below(size, &centre)
    }

    fn keep(&mut self, part: Part<F::Point, N>) -> Result<(), FluidError> {
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
    /// large: h at that vertex was not asked before. After the first sweep only vertices of the one before and of this
    /// one can be in the middle of an edge, but for simplices that are new.
    fn close(&mut self) -> Result<(), FluidError> {
        let root = self.root;
        let mut recent: Option<FxHashSet<Vertex<F::Coordinate, D>>> = None;
        loop {
            let before = std::mem::take(&mut self.leaves);
            self.leaves.reserve(before.len() + before.len() / 4);
            let mut made = FxHashSet::default();
            let mut waiting = Vec::new();
            for part in before {
                waiting.push((part, false));
                while let Some((part, new)) = waiting.pop() {
                    let hangs = || match &recent {
                        Some(recent) if !new => self.hangs(&part, |vertex| {
                            recent.contains(vertex) || made.contains(vertex)
                        }),
                        _ => self.hangs(&part, |vertex| self.vertices.contains_key(vertex)),
                    };
                    let divided = hangs() || new && self.is_new_too_large(&part);
                    if !divided {
                        self.keep(part)?;
                        continue;
                    }
                    let (edge, middle) = halved(root, &part).ok_or_else(too_deep)?;
                    self.visit(&middle);
                    made.insert(root.vertex(&middle));
                    let [first, second] = bisect::<F, D, N>(&part, edge, middle);
                    waiting.extend([(second, true), (first, true)]);
                }
            }
            if made.is_empty() {
                return Ok(());
            }
            recent = Some(made);
        }
    }

    fn is_new_too_large(&self, part: &Part<F::Point, N>) -> bool {
        let wish = |corner: &F::Point| self.vertices.get(&self.root.vertex(corner));
        let wishes = part
            .corners
            .map(|corner| wish(&corner).map_or(f64::INFINITY, |known| known.wish));
        self.is_too_large(part, &wishes)
    }

    /// Has an edge a vertex in its middle, of those that are `there`?
    fn hangs(
        &self,
        part: &Part<F::Point, N>,
        there: impl Fn(&Vertex<F::Coordinate, D>) -> bool,
    ) -> bool {
        (0..N).any(|i| {
            (i + 1..N).any(|j| {
                let middle = self.root.middle(&part.corners[i], &part.corners[j]);
                middle.is_some_and(|middle| there(&self.root.vertex(&middle)))
            })
        })
    }

    /// Number vertices as simplices meet them, and simplices by descent.
    fn finish(mut self) -> Result<(Bisection<F, D, N>, Mesh<D, N>), FluidError> {
        let root = self.root;
        let mut position = Vec::with_capacity(self.vertices.len());
        let mut homes = Vec::with_capacity(self.vertices.len());
        let mut simplices = Vec::with_capacity(self.leaves.len());
        let mut corners = Vec::with_capacity(self.leaves.len());
        let mut facets = Vec::new();
        for part in &self.leaves {
            let (mut points, mut sides) = (part.corners, part.sides);
            let mut places = points.map(|point| root.position(&point));
            if simplex::determinant(&places) < 0.0 {
                points.swap(D - 1, D);
                places.swap(D - 1, D);
                sides.swap(D - 1, D);
            }
            let mut own = [0; N];
            for k in 0..N {
                let vertex = root.vertex(&points[k]);
                let known = self.vertices.get_mut(&vertex);
                // every corner of a simplex was visited
                let Some(known) = known else { continue };
                if known.node == NO_NODE {
                    known.node = position.len() as u32;
                    position.push(root.place(&vertex));
                    homes.push((part.home, places[k]));
                }
                own[k] = known.node as usize;
            }
            let named = (0..N).filter(|&k| sides[k] != INSIDE);
            facets.extend(named.map(|k| (simplices.len(), k, usize::from(sides[k]))));
            simplices.push(own);
            corners.push(places);
        }
        let mut mesh = Mesh::without_facets(position, simplices, corners, |t| t)?;
        mesh.boundary_names = root.boundary_names();
        let facets = facets.iter();
        mesh.facets = facets.map(|&(t, k, side)| mesh.facet(t, k, side)).collect();
        mesh.period = root.period();
        let bisection = Bisection {
            root: root.clone(),
            vertices: self.vertices,
            homes,
        };
        Ok((bisection, mesh))
    }
}
