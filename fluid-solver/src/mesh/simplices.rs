//! The mesh: nodes, simplices (triangles, tetrahedra), named facets of the boundary; periodic sides
//! share their nodes.
//!
//! Corner coordinates are kept for each simplex as well: across a periodic boundary they are
//! unwrapped, so geometry always comes from them and never from the node coordinates. With one
//! cell across a period two corners of a simplex are the same node; nothing here minds.

use space::{Dim, Dimension, Period, Simplex, Vector};

use super::facet::BoundaryFacet;
use crate::error::{FluidError, places};

/// A mesh of linear simplices with `N = D + 1` corners.
#[derive(Debug, Clone)]
pub struct Mesh<const D: usize, const N: usize> {
    /// Node coordinates \[m\].
    pub position: Vec<Vector<D>>,
    /// Corners of each simplex, right-handed (counter-clockwise).
    pub simplices: Vec<[usize; N]>,
    /// Corner coordinates of each simplex \[m\], unwrapped across periodic boundaries.
    pub corners: Vec<[Vector<D>; N]>,
    /// Gradients and volume of each simplex.
    pub geometry: Vec<Simplex<D, N>>,
    /// Lumped mass ∫N_α of each node \[m^D\].
    pub nodal_mass: Vec<f64>,
    /// Facets of the boundary that are not joined periodically.
    pub facets: Vec<BoundaryFacet<D>>,
    /// Names of the boundaries.
    pub boundary_names: Vec<String>,
    /// Period along each axis \[m\].
    pub period: Period<D>,
}

impl<const D: usize, const N: usize> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Mesh from its parts; `named` lists facets of the boundary by their nodes and boundary, `tag`
    /// numbers simplices in error messages. Every side of a single simplex must be named once.
    pub fn new(
        position: Vec<Vector<D>>,
        simplices: Vec<[usize; N]>,
        boundary_names: Vec<String>,
        named: &[([usize; D], usize)],
        tag: impl Fn(usize) -> usize,
    ) -> Result<Mesh<D, N>, FluidError> {
        let corners: Vec<_> = simplices.iter().map(|t| t.map(|n| position[n])).collect();
        let mut mesh = Mesh::without_facets(position, simplices, corners, tag)?;
        mesh.boundary_names = boundary_names;
        mesh.facets = mesh.match_facets(named)?;
        Ok(mesh)
    }

    /// Geometry and lumped mass; every simplex must be right-handed.
    pub(crate) fn without_facets(
        position: Vec<Vector<D>>,
        simplices: Vec<[usize; N]>,
        corners: Vec<[Vector<D>; N]>,
        tag: impl Fn(usize) -> usize,
    ) -> Result<Mesh<D, N>, FluidError> {
        if simplices.is_empty() {
            return Err(FluidError::Mesh(format!("no {}s", Dim::<D>::SIMPLEX)));
        }
        let geometry: Vec<Simplex<D, N>> = corners.iter().map(Simplex::new).collect();
        let mut nodal_mass = vec![0.0; position.len()];
        for (index, (nodes, shape)) in simplices.iter().zip(&geometry).enumerate() {
            if shape.volume.is_nan() || shape.volume <= 0.0 {
                return Err(FluidError::InvertedSimplex {
                    simplex: Dim::<D>::SIMPLEX,
                    number: tag(index),
                    corners: places(&corners[index], ", "),
                    measure: Dim::<D>::MEASURE,
                    volume: shape.volume,
                    unit: Dim::<D>::UNIT,
                });
            }
            for &node in nodes {
                nodal_mass[node] += shape.volume / N as f64;
            }
        }
        Ok(Mesh {
            position,
            simplices,
            corners,
            geometry,
            nodal_mass,
            facets: Vec::new(),
            boundary_names: Vec::new(),
            period: [None; D],
        })
    }

    /// Mass-averaged gradient ℓ_α⁻¹ ∫N_α ∇p of a nodal field.
    pub fn averaged_gradient(&self, value: &[f64]) -> Vec<Vector<D>> {
        let mut sum = vec![Vector::<D>::zeros(); self.node_count()];
        for (nodes, shape) in self.simplices.iter().zip(&self.geometry) {
            let gradient = shape.gradient_of(&nodes.map(|n| value[n]));
            for &node in nodes {
                for d in 0..D {
                    sum[node][d] += shape.volume / N as f64 * gradient[d];
                }
            }
        }
        for (sum, mass) in sum.iter_mut().zip(&self.nodal_mass) {
            *sum = sum.map(|component| component / mass);
        }
        sum
    }
}

impl<const D: usize, const N: usize> Mesh<D, N> {
    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.position.len()
    }

    /// Index of a boundary by its name.
    pub fn boundary(&self, name: &str) -> Result<usize, FluidError> {
        let found = self.boundary_names.iter().position(|known| known == name);
        found.ok_or_else(|| FluidError::UnknownBoundary {
            name: name.into(),
            allowed: self.boundary_names.clone(),
        })
    }
}
