//! Where a flow bends, so that its cells should be small there.
//!
//! ```text
//!   |D²v| ≈ |∇v of one cell − ∇v of the next| / distance of their middles
//!   h(x) = √(jump · largest |v| / |D²v|),  not below `smallest`, not below a quarter of the cells there       (I1)
//! ```
//!
//! A linear field that is taken for v errs by h² |D²v|/8 at most: by `jump`/8 of the largest speed. The jump of ∇v from
//! cell to cell is that of Kelly et al., Int. J. Numer. Meth. Eng. 19 (1983).

use protocol::scene;
use space::{Dim, Dimension, Simplex, Vector, hypot, simplex};

use crate::transfer::mesh::Mesh;

/// Cells become smaller by this factor at most with one mesh: what is finer shows only then.
const AT_ONCE: f64 = 4.0;

/// Two cells that share a facet.
struct Pair<const D: usize> {
    simplices: [u32; 2],
    /// Middle of the facet \[m\].
    middle: Vector<D>,
    /// From one middle to the other \[m\].
    distance: f64,
    /// h of the larger of both \[m\].
    size: f64,
}

/// Of the mesh of an epoch.
pub struct Indicator<const D: usize, const N: usize> {
    asked: scene::Indicator,
    simplices: Vec<[u32; N]>,
    geometry: Vec<Simplex<D, N>>,
    pairs: Vec<Pair<D>>,
}

impl<const D: usize, const N: usize> Indicator<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Of this mesh.
    pub fn new(asked: scene::Indicator, mesh: &Mesh<D, N>) -> Indicator<D, N> {
        let mut sides: Vec<([u32; D], u32, Vector<D>)> = Vec::new();
        for (t, (nodes, corners)) in mesh.simplices.iter().zip(&mesh.corners).enumerate() {
            for k in 0..N {
                let facet = simplex::facet_corners::<D>(k);
                let mut own = facet.map(|corner| nodes[corner]);
                own.sort_unstable();
                sides.push((own, t as u32, middle(&facet.map(|corner| corners[corner]))));
            }
        }
        sides.sort_unstable_by_key(|(nodes, t, _)| (*nodes, *t));
        let both = sides.chunk_by(|a, b| a.0 == b.0);
        let pairs = both.filter_map(|side| match side {
            [(_, a, at), (_, b, there)] => {
                let [first, second] = [a, b].map(|&t| &mesh.corners[t as usize]);
                // across a period each is measured from its own side
                let distance = hypot(&(middle(first) - at)) + hypot(&(middle(second) - there));
                let volume = simplex::determinant(first).max(simplex::determinant(second));
                Some(Pair {
                    simplices: [*a, *b],
                    middle: *at,
                    distance,
                    size: simplex::cube_edge::<D>(volume),
                })
            }
            _ => None,
        });
        Indicator {
            asked,
            pairs: pairs.collect(),
            simplices: mesh.simplices.clone(),
            geometry: mesh.corners.iter().map(Simplex::new).collect(),
        }
    }

    /// (I1) where two cells meet: where, and h \[m\].
    pub fn wishes(&self, velocity: &[Vector<D>]) -> Vec<(Vector<D>, f64)> {
        let largest = velocity.iter().map(hypot).fold(0.0, f64::max);
        let shapes = self.simplices.iter().zip(&self.geometry);
        let gradients: Vec<[Vector<D>; D]> = shapes
            .map(|(nodes, shape)| {
                let of =
                    |d: usize| shape.gradient_of(&nodes.map(|node| velocity[node as usize][d]));
                std::array::from_fn(of)
            })
            .collect();
        let wish = |pair: &Pair<D>| {
            let [a, b] = pair.simplices.map(|t| &gradients[t as usize]);
            let squares = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared());
            let bend = squares.sum::<f64>().sqrt() / pair.distance;
            let wish = (self.asked.jump * largest / bend).sqrt();
            let least = self.asked.smallest.max(pair.size / AT_ONCE);
            // at rest nothing bends: 0/0
            (
                pair.middle,
                if wish.is_nan() {
                    f64::INFINITY
                } else {
                    wish.max(least)
                },
            )
        };
        self.pairs.iter().map(wish).collect()
    }
}

fn middle<const D: usize, const M: usize>(points: &[Vector<D>; M]) -> Vector<D> {
    points.iter().sum::<Vector<D>>() / M as f64
}
