//! The smoothing of what is deposited: B = M_ℓ + L²K with the stiffness K of the mesh.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{MatMut, Side};
use space::{Dim, Dimension, simplex};

use crate::error::CouplerError;
use crate::transfer::mesh::Mesh;

/// The Cholesky factor of B, made once: B is symmetric and positive definite, and the same for a
/// whole run.
pub struct Kernel {
    factor: Llt<usize, f64>,
    mass: Vec<f64>,
    total: f64,
}

impl std::fmt::Debug for Kernel {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Kernel").finish_non_exhaustive()
    }
}

impl Kernel {
    /// Factor B of a mesh for the length L \[m\].
    pub fn new<const D: usize, const N: usize>(
        mesh: &Mesh<D, N>,
        length: f64,
    ) -> Result<Kernel, CouplerError>
    where
        Dim<D>: Dimension<D>,
    {
        let nodes = mesh.nodal_mass.len();
        let lower = lower_entries(mesh, length);
        let broken = |why: String| CouplerError::Smoothing { length, why };
        let matrix = SparseColMat::try_new_from_triplets(nodes, nodes, &lower)
            .map_err(|error| broken(format!("{error:?}")))?;
        let factor = SymbolicLlt::try_new(matrix.symbolic(), Side::Lower)
            .map_err(|error| broken(format!("{error:?}")))
            .and_then(|symbolic| {
                Llt::try_new_with_symbolic(symbolic, matrix.as_ref(), Side::Lower)
                    .map_err(|error| broken(format!("{error:?}")))
            })?;
        Ok(Kernel {
            factor,
            mass: mesh.nodal_mass.clone(),
            total: mesh.nodal_mass.iter().sum(),
        })
    }

    /// B⁻¹ b of one column or more, in place. B 1 = M_ℓ 1, so what round-off has taken from the sum of a
    /// column comes back by a constant.
    pub fn solve(&self, columns: &mut [f64]) {
        let nodes = self.mass.len();
        let sums: Vec<f64> = columns
            .chunks_exact(nodes)
            .map(|b| b.iter().sum())
            .collect();
        let all = MatMut::from_column_major_slice_mut(&mut *columns, nodes, sums.len());
        self.factor.solve_in_place(all);
        for (x, sum) in columns.chunks_exact_mut(nodes).zip(sums) {
            let lost = sum - dot(x, &self.mass);
            x.iter_mut().for_each(|x| *x += lost / self.total);
        }
    }
}

/// Lower triangle of B.
fn lower_entries<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    length: f64,
) -> Vec<Triplet<usize, usize, f64>>
where
    Dim<D>: Dimension<D>,
{
    let masses = mesh.nodal_mass.iter().enumerate();
    let mut lower: Vec<_> = masses
        .map(|(node, &mass)| Triplet::new(node, node, mass))
        .collect();
    for (nodes, corners) in mesh.simplices.iter().zip(&mesh.corners) {
        let nodes = nodes.map(|node| node as usize);
        let stiffness = simplex::stiffness(corners);
        for i in 0..N {
            for j in (0..N).filter(|&j| nodes[j] <= nodes[i]) {
                let entry = length * length * stiffness[i][j];
                lower.push(Triplet::new(nodes[i], nodes[j], entry));
            }
        }
    }
    lower
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
