//! A mesh from which a mesh is refined: every simplex is halved across its longest edge.
//!
//! Rivara, Int. J. Numer. Meth. Eng. 20 (1984): in the plane no angle is smaller than half the smallest of the root.
//! Of edges as long as each other the one with the larger middle is taken, coordinate after coordinate, so that all
//! simplices around an edge agree. Sides inherit their boundaries; they stay straight where those of the root are.

use rustc_hash::FxHashMap;
use space::{Dim, Dimension, Period, Vector, dimension::factorial, simplex, vector};

use super::bisection::{Forest, INSIDE, Part, Vertex};
use super::simplices::Mesh;
use crate::error::{FluidError, place};

/// The simplices of a mesh.
#[derive(Debug, Clone)]
pub struct LongestEdge<const D: usize, const N: usize> {
    simplices: Vec<Part<Vector<D>, N>>,
    boundary_names: Vec<String>,
}

impl<const D: usize, const N: usize> LongestEdge<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// From a mesh without joined sides; an error where two of its nodes are at one place, since vertices are told
    /// apart by their places.
    pub fn new(mesh: &Mesh<D, N>) -> Result<LongestEdge<D, N>, FluidError> {
        let mut node_at = FxHashMap::default();
        for (node, position) in mesh.position.iter().enumerate() {
            if let Some(other) = node_at.insert(vertex(&without_sign_of_zero(position)), node) {
                return Err(FluidError::Mesh(format!(
                    "nodes {other} and {node}, counted from 0, are both at {}: a mesh that is refined has one node at \
                     a place",
                    place(position)
                )));
            }
        }
        let mut sides = vec![[INSIDE; N]; mesh.simplices.len()];
        for facet in &mesh.facets {
            // the corner that is not one of the facet's
            let opposite = (0..N).find(|k| !facet.corner.contains(k)).unwrap_or(0);
            sides[facet.simplex][opposite] = facet.boundary as u16;
        }
        let parts = mesh.corners.iter().zip(&mesh.geometry).zip(sides);
        let parts = parts
            .enumerate()
            .map(|(t, ((corners, shape), sides))| Part {
                corners: corners.map(|corner| without_sign_of_zero(&corner)),
                sides,
                generation: 0,
                home: t as u32,
                size: simplex::cube_edge::<D>(factorial(D) as f64 * shape.volume),
            });
        Ok(LongestEdge {
            simplices: parts.collect(),
            boundary_names: mesh.boundary_names.clone(),
        })
    }
}

/// 0 for −0, which is at the same place.
fn without_sign_of_zero<const D: usize>(position: &Vector<D>) -> Vector<D> {
    position.map(|x| x + 0.0)
}

#[inline]
fn vertex<const D: usize>(point: &Vector<D>) -> Vertex<u64, D> {
    Vertex(std::array::from_fn(|d| point[d].to_bits()))
}

impl<const D: usize, const N: usize> Forest<D, N> for LongestEdge<D, N>
where
    Dim<D>: Dimension<D>,
{
    type Point = Vector<D>;
    type Coordinate = u64;

    fn validate(&self) -> Result<(), FluidError> {
        Ok(())
    }

    fn simplices(&self) -> impl Iterator<Item = Part<Vector<D>, N>> + '_ {
        self.simplices.iter().copied()
    }

    #[inline]
    fn vertex(&self, point: &Vector<D>) -> Vertex<u64, D> {
        vertex(point)
    }

    fn position(&self, point: &Vector<D>) -> Vector<D> {
        *point
    }

    fn place(&self, vertex: &Vertex<u64, D>) -> Vector<D> {
        vector::from_fn(|d| f64::from_bits(vertex.0[d]))
    }

    #[inline]
    fn middle(&self, a: &Vector<D>, b: &Vector<D>) -> Option<Vector<D>> {
        Some((a + b) * 0.5)
    }

    fn edge(&self, part: &Part<Vector<D>, N>) -> (usize, usize) {
        let key = |(a, b): (usize, usize)| {
            let (a, b) = (part.corners[a], part.corners[b]);
            ((a - b).norm_squared(), (a + b) * 0.5)
        };
        let longer = |edge, other| {
            let ((length, middle), (least, before)) = (key(edge), key(other));
            let middles = middle.iter().zip(&before);
            let order = middles
                .map(|(x, y)| x.total_cmp(y))
                .find(|order| order.is_ne());
            length > least || length == least && order.is_some_and(|order| order.is_gt())
        };
        let mut longest = (0, 1);
        for a in 0..N {
            for b in a + 1..N {
                if longer((a, b), longest) {
                    longest = (a, b);
                }
            }
        }
        longest
    }

    #[inline]
    fn halves<T: Copy>((a, b): (usize, usize), whole: &[T; N], middle: T) -> [[T; N]; 2] {
        let (mut first, mut second) = (*whole, *whole);
        first[b] = middle;
        second[a] = middle;
        [first, second]
    }

    fn boundary_names(&self) -> Vec<String> {
        self.boundary_names.clone()
    }

    fn period(&self) -> Period<D> {
        [None; D]
    }
}
