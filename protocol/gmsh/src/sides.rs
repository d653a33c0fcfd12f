//! Sides of simplices.

use space::simplex::facet_corners;
use space::{Dim, Dimension};

/// A side of a simplex: its nodes ascending, the simplex, the corner opposite to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side<const D: usize> {
    pub(crate) nodes: [usize; D],
    pub(crate) simplex: usize,
    pub(crate) corner: usize,
}

/// All sides, those with the same nodes beside each other.
pub(crate) struct Sides<const D: usize>(Vec<Side<D>>);

impl<const D: usize> Sides<D>
where
    Dim<D>: Dimension<D>,
{
    pub(crate) fn of<const N: usize>(simplices: &[[usize; N]]) -> Sides<D> {
        let mut sides = Vec::with_capacity(N * simplices.len());
        for (simplex, nodes) in simplices.iter().enumerate() {
            for corner in 0..N {
                let facet = facet_corners::<D>(corner).map(|k| nodes[k]);
                sides.push(Side {
                    nodes: ordered(facet),
                    simplex,
                    corner,
                });
            }
        }
        sides.sort_unstable();
        Sides(sides)
    }

    /// Sides with the same nodes.
    pub(crate) fn groups(&self) -> impl Iterator<Item = &[Side<D>]> {
        self.0.chunk_by(|a, b| a.nodes == b.nodes)
    }
}

/// The nodes of a side, ascending.
pub(crate) fn ordered<const D: usize>(mut nodes: [usize; D]) -> [usize; D] {
    nodes.sort_unstable();
    nodes
}
