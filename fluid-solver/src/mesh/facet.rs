//! A facet of the boundary.

use space::Vector;

/// A facet of the boundary (an edge, a triangle) with the domain behind it.
#[derive(Debug, Clone, Copy)]
pub struct BoundaryFacet<const D: usize> {
    /// Corner numbers of the facet within its simplex; in the plane the domain is on the left.
    pub corner: [usize; D],
    /// Nodes of the facet.
    pub node: [usize; D],
    /// The simplex it belongs to.
    pub simplex: usize,
    /// Which boundary, index into `Mesh::boundary_names`.
    pub boundary: usize,
    /// Outward unit normal.
    pub normal: Vector<D>,
    /// Length \[m\] or area \[m²\].
    pub size: f64,
}

impl<const D: usize> BoundaryFacet<D> {
    /// N_i of the simplex where those of the facet are `on_facet`.
    #[inline]
    pub fn shape<const N: usize>(&self, on_facet: &[f64; D]) -> [f64; N] {
        let mut shape = [0.0; N];
        for (corner, value) in self.corner.iter().zip(on_facet) {
            shape[*corner] = *value;
        }
        shape
    }
}
