//! What a scene needs to know of the mesh of a file.

use gmsh::{Border, survey};
use space::{Dim, Dimension, Vector, simplex};

/// What a scene needs to know of a mesh.
#[derive(Debug, Clone)]
pub struct Mesh<const D: usize> {
    /// Coordinates of each node \[m\].
    pub position: Vec<Vector<D>>,
    /// The boundary.
    pub borders: Vec<Border<D>>,
    /// What was read otherwise than written.
    pub notes: Vec<String>,
    /// Longest side over shortest height, and the number of that element.
    pub aspect: (f64, u64),
    /// Edge of a cube as large as D! of its largest simplex \[m\].
    pub largest_cell: f64,
}

impl<const D: usize> Mesh<D> {
    /// Of a mesh as it was read.
    pub fn of<const N: usize>(mesh: &gmsh::Mesh<D, N>) -> Mesh<D>
    where
        Dim<D>: Dimension<D>,
    {
        let size =
            |nodes: &[usize; N]| simplex::determinant(&nodes.map(|n| mesh.position[n])).abs();
        let largest = mesh.simplices.iter().map(size).fold(0.0, f64::max);
        let quality = survey::quality(mesh);
        Mesh {
            position: mesh.position.clone(),
            borders: mesh.borders.clone(),
            notes: mesh.notes.clone(),
            aspect: (quality.aspect, quality.longest),
            largest_cell: simplex::cube_edge::<D>(largest),
        }
    }
}
