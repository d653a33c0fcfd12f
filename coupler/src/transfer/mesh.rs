//! The mesh that the fluid engine solves on.

use space::{Dim, Dimension, Period, Vector, simplex};

/// Nodes and simplices (triangles, tetrahedra).
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh<const D: usize, const N: usize> {
    /// Nodes \[m\].
    pub node_position: Vec<Vector<D>>,
    /// Corner nodes of each simplex, right-handed.
    pub simplices: Vec<[u32; N]>,
    /// Corners of each simplex \[m\], unwrapped across periodic boundaries.
    pub corners: Vec<[Vector<D>; N]>,
    /// Lumped mass ℓ of each node \[m^D\].
    pub nodal_mass: Vec<f64>,
    /// Period along each axis \[m\].
    pub period: Period<D>,
}

impl<const D: usize, const N: usize> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// h of the smallest cell: the side of a square of two triangles, of a cube of six tetrahedra.
    pub fn smallest_cell(&self) -> f64 {
        let volumes = self.corners.iter().map(simplex::determinant);
        simplex::cube_edge::<D>(volumes.fold(f64::INFINITY, f64::min))
    }
    /// h of the largest cell.
    pub fn largest_cell(&self) -> f64 {
        let volumes = self.corners.iter().map(simplex::determinant);
        simplex::cube_edge::<D>(volumes.fold(0.0, f64::max))
    }
    /// h around each node \[m\]: the mean over its simplices.
    pub fn cell_of_nodes(&self) -> Vec<f64> {
        let mut sum = vec![(0.0, 0.0); self.nodal_mass.len()];
        for (nodes, corners) in self.simplices.iter().zip(&self.corners) {
            let cell = simplex::cube_edge::<D>(simplex::determinant(corners));
            for &node in nodes {
                let (cells, count) = &mut sum[node as usize];
                (*cells, *count) = (*cells + cell, *count + 1.0);
            }
        }
        sum.iter().map(|(cells, count)| cells / count).collect()
    }
}
