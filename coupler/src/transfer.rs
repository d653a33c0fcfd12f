//! Grains ↔ mesh: deposit a quantity of the grains on the nodes, sample a nodal field at the grains.
//!
//! ```text
//!   deposit   c = B⁻¹ Nᵀx,   B = M_ℓ + L²K      (T1)   lumped mass M_ℓ, stiffness K; L = 0: M_ℓ⁻¹ Nᵀx
//!   sample    f_i = (N B⁻¹ M_ℓ f)_i             (T2)   the adjoint of (T1) in the mass M_ℓ
//! ```
//!
//! so that Σ_α ℓ_α f_α c_α = Σ_i x_i f_i for any f, x: action = reaction. K 1 = 0 conserves the sum
//! of what is deposited for every L. L ≥ 2d removes the mesh dependence of large grains. Spheres in
//! a slab are deposited over its depth: the fluid is solved per metre of depth.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{MatMut, Side};
use protocol::engine::MeshDescription;

use crate::error::CouplerError;
use crate::locate::{Locator, Stencil};

/// The transfer between one mesh and any set of grains.
#[derive(Debug)]
pub struct Transfer {
    locator: Locator,
    node_position: Vec<f64>,
    nodal_mass: Vec<f64>,
    smoothing: Option<Smoothing>,
    depth: f64,
}

/// Where a set of grains is on the mesh.
#[derive(Debug, Clone, Default)]
pub struct Placement {
    stencils: Vec<Stencil>,
}

impl Transfer {
    /// Transfer on a mesh, smoothed over the length L \[m\] (0: lumped mass); `depth` \[m\] is that
    /// of the slab for spheres, 1 for disks.
    pub fn new(
        mesh: &MeshDescription,
        smoothing_length: f64,
        depth: f64,
    ) -> Result<Transfer, CouplerError> {
        let smoothing = (smoothing_length > 0.0)
            .then(|| Smoothing::new(mesh, smoothing_length))
            .transpose()?;
        Ok(Transfer {
            locator: Locator::new(mesh),
            node_position: mesh.node_position.clone(),
            nodal_mass: mesh.nodal_mass.clone(),
            smoothing,
            depth,
        })
    }

    /// Lumped mass ℓ_α of the nodes \[m²\].
    pub fn nodal_mass(&self) -> &[f64] {
        &self.nodal_mass
    }

    /// Depth of the slab \[m\]; 1 for disks.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Position of a node \[m\].
    pub fn node_position(&self, node: usize) -> [f64; 2] {
        [
            self.node_position[2 * node],
            self.node_position[2 * node + 1],
        ]
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodal_mass.len()
    }

    /// Find grains (interleaved positions \[m\]) on the mesh.
    pub fn place(&self, positions: &[f64]) -> Result<Placement, CouplerError> {
        let stencils = positions
            .chunks_exact(2)
            .enumerate()
            .map(|(grain, point)| self.locator.locate(grain, [point[0], point[1]]))
            .collect::<Result<_, _>>()?;
        Ok(Placement { stencils })
    }

    /// (T1) of a scalar a grain.
    pub fn deposit(&self, placement: &Placement, values: impl Fn(usize) -> f64) -> Vec<f64> {
        self.deposit_columns(placement, |grain| [values(grain)])
    }

    /// (T1) of a vector a grain; interleaved result.
    pub fn deposit_vector(
        &self,
        placement: &Placement,
        values: impl Fn(usize) -> [f64; 2],
    ) -> Vec<f64> {
        interleave(&self.deposit_columns(placement, values))
    }

    /// (T1) of some numbers a grain, all nodes of the first, then all of the next.
    fn deposit_columns<const N: usize>(
        &self,
        placement: &Placement,
        values: impl Fn(usize) -> [f64; N],
    ) -> Vec<f64> {
        let count = self.node_count();
        let mut nodal = vec![0.0; N * count];
        for (grain, stencil) in placement.stencils.iter().enumerate() {
            let values = values(grain).map(|value| value / self.depth);
            for (&node, &weight) in stencil.nodes.iter().zip(&stencil.weights) {
                for (column, value) in values.iter().enumerate() {
                    nodal[column * count + node as usize] += weight * value;
                }
            }
        }
        self.over_mass(&mut nodal);
        nodal
    }

    /// (T2) of a nodal scalar.
    pub fn sample(&self, placement: &Placement, nodal: &[f64]) -> Vec<f64> {
        let smoothed = self.smooth(|| nodal.to_vec());
        let field = smoothed.as_deref().unwrap_or(nodal);
        let at = |stencil: &Stencil| {
            let [a, b, c] = stencil.nodes.map(|node| field[node as usize]);
            stencil.weights[0] * a + stencil.weights[1] * b + stencil.weights[2] * c
        };
        placement.stencils.iter().map(at).collect()
    }

    /// (T2) of an interleaved nodal vector field; interleaved result.
    pub fn sample_vector(&self, placement: &Placement, nodal: &[f64]) -> Vec<f64> {
        let smoothed = self
            .smooth(|| [component(nodal, 0), component(nodal, 1)].concat())
            .map(|columns| interleave(&columns));
        let field = smoothed.as_deref().unwrap_or(nodal);
        let mut sampled = Vec::with_capacity(2 * placement.stencils.len());
        for stencil in &placement.stencils {
            for axis in 0..2 {
                let [a, b, c] = stencil.nodes.map(|node| field[2 * node as usize + axis]);
                sampled
                    .push(stencil.weights[0] * a + stencil.weights[1] * b + stencil.weights[2] * c);
            }
        }
        sampled
    }

    /// B⁻¹ M_ℓ f of columns; none where the transfer is not smoothed.
    fn smooth(&self, columns: impl FnOnce() -> Vec<f64>) -> Option<Vec<f64>> {
        let smoothing = self.smoothing.as_ref()?;
        let mut columns = columns();
        let masses = self.nodal_mass.iter().cycle();
        columns
            .iter_mut()
            .zip(masses)
            .for_each(|(f, mass)| *f *= mass);
        smoothing.solve(&mut columns);
        Some(columns)
    }

    fn over_mass(&self, columns: &mut [f64]) {
        match &self.smoothing {
            Some(smoothing) => smoothing.solve(columns),
            None => columns
                .iter_mut()
                .zip(self.nodal_mass.iter().cycle())
                .for_each(|(value, mass)| *value /= mass),
        }
    }
}

/// One component of an interleaved field.
pub fn component(interleaved: &[f64], axis: usize) -> Vec<f64> {
    interleaved.iter().skip(axis).step_by(2).copied().collect()
}

/// Two columns, one after the other, as vectors.
fn interleave(columns: &[f64]) -> Vec<f64> {
    let (x, y) = columns.split_at(columns.len() / 2);
    x.iter().zip(y).flat_map(|(&x, &y)| [x, y]).collect()
}

/// The Cholesky factor of B = M_ℓ + L²K, made once: B is symmetric and positive definite, and the same
/// for a whole run.
struct Smoothing {
    factor: Llt<usize, f64>,
    mass: Vec<f64>,
    area: f64,
}

impl std::fmt::Debug for Smoothing {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Smoothing").finish_non_exhaustive()
    }
}

impl Smoothing {
    fn new(mesh: &MeshDescription, length: f64) -> Result<Smoothing, CouplerError> {
        let nodes = mesh.nodal_mass.len();
        let mut lower: Vec<Triplet<usize, usize, f64>> = mesh
            .nodal_mass
            .iter()
            .enumerate()
            .map(|(node, &mass)| Triplet::new(node, node, mass))
            .collect();
        for (corners, positions) in mesh.triangles.iter().zip(&mesh.triangle_position) {
            let corners = corners.map(|node| node as usize);
            let stiffness = triangle_stiffness(positions);
            for i in 0..3 {
                for j in (0..3).filter(|&j| corners[j] <= corners[i]) {
                    let entry = length * length * stiffness[i][j];
                    lower.push(Triplet::new(corners[i], corners[j], entry));
                }
            }
        }
        let broken = |why: String| CouplerError::Smoothing { length, why };
        let matrix = SparseColMat::try_new_from_triplets(nodes, nodes, &lower)
            .map_err(|error| broken(format!("{error:?}")))?;
        let factor = SymbolicLlt::try_new(matrix.symbolic(), Side::Lower)
            .map_err(|error| broken(format!("{error:?}")))
            .and_then(|symbolic| {
                Llt::try_new_with_symbolic(symbolic, matrix.as_ref(), Side::Lower)
                    .map_err(|error| broken(format!("{error:?}")))
            })?;
        Ok(Smoothing {
            factor,
            mass: mesh.nodal_mass.clone(),
            area: mesh.nodal_mass.iter().sum(),
        })
    }

    /// B⁻¹ b of one column or more, in place. B 1 = M_ℓ 1, so what round-off has taken from the sum of a
    /// column comes back by a constant.
    fn solve(&self, columns: &mut [f64]) {
        let nodes = self.mass.len();
        let sums: Vec<f64> = columns
            .chunks_exact(nodes)
            .map(|b| b.iter().sum())
            .collect();
        let all = MatMut::from_column_major_slice_mut(&mut *columns, nodes, sums.len());
        self.factor.solve_in_place(all);
        for (x, sum) in columns.chunks_exact_mut(nodes).zip(sums) {
            let lost = sum - dot(x, &self.mass);
            x.iter_mut().for_each(|x| *x += lost / self.area);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// ∫∇N_i·∇N_j over one triangle.
fn triangle_stiffness(corners: &[f64; 6]) -> [[f64; 3]; 3] {
    let [ax, ay, bx, by, cx, cy] = *corners;
    let doubled_area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    let edges = [[by - cy, cx - bx], [cy - ay, ax - cx], [ay - by, bx - ax]]; // 2A ∇N_i
    let entry = |i: usize, j: usize| {
        (edges[i][0] * edges[j][0] + edges[i][1] * edges[j][1]) / (2.0 * doubled_area)
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}
