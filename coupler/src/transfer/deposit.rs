//! Deposit a quantity of the grains on the nodes, sample a nodal field at the grains.
//!
//! ```text
//!   deposit   c = B⁻¹ Nᵀx,   B = M_ℓ + L²K      (T1)   lumped mass M_ℓ, stiffness K; L = 0: M_ℓ⁻¹ Nᵀx
//!   sample    f_i = (N B⁻¹ M_ℓ f)_i             (T2)   the adjoint of (T1) in the mass M_ℓ
//! ```
//!
//! so that Σ_α ℓ_α f_α c_α = Σ_i x_i f_i for any f, x: action = reaction. K 1 = 0 conserves the sum
//! of what is deposited for every L. L ≥ 2d removes the mesh dependence of large grains. Spheres in
//! a slab are deposited over its depth: the fluid is solved per metre of depth.

use space::{Dim, Dimension, Vector};

use crate::error::CouplerError;
use crate::transfer::kernel::Kernel;
use crate::transfer::locate::{Locator, Stencil};
use crate::transfer::mesh::Mesh;
use crate::transfer::quantity::{Quantity, columns, set_columns};

/// The transfer between one mesh and any set of grains.
#[derive(Debug)]
pub struct Transfer<const D: usize, const N: usize> {
    locator: Locator<D, N>,
    node_position: Vec<Vector<D>>,
    nodal_mass: Vec<f64>,
    kernel: Option<Kernel>,
    depth: f64,
}

/// Where a set of grains is on the mesh.
#[derive(Debug, Clone, Default)]
pub struct Placement<const N: usize> {
    stencils: Vec<Stencil<N>>,
}

impl<const D: usize, const N: usize> Transfer<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Transfer on a mesh, smoothed over the length L \[m\] (0: lumped mass); `depth` \[m\] is that
    /// of the slab for spheres in the plane, 1 otherwise.
    pub fn new(
        mesh: &Mesh<D, N>,
        smoothing_length: f64,
        depth: f64,
    ) -> Result<Transfer<D, N>, CouplerError> {
        let kernel = (smoothing_length > 0.0)
            .then(|| Kernel::new(mesh, smoothing_length))
            .transpose()?;
        Ok(Transfer {
            locator: Locator::new(mesh),
            node_position: mesh.node_position.clone(),
            nodal_mass: mesh.nodal_mass.clone(),
            kernel,
            depth,
        })
    }

    /// Lumped mass ℓ_α of the nodes \[m^D\].
    pub fn nodal_mass(&self) -> &[f64] {
        &self.nodal_mass
    }

    /// Depth of the slab \[m\]; 1 for disks.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Position of a node \[m\].
    pub fn node_position(&self, node: usize) -> &Vector<D> {
        &self.node_position[node]
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodal_mass.len()
    }

    /// Find grains (positions \[m\]) on the mesh.
    pub fn place(&self, positions: &[Vector<D>]) -> Result<Placement<N>, CouplerError> {
        let stencils = positions
            .iter()
            .enumerate()
            .map(|(grain, point)| self.locator.locate(grain, point))
            .collect::<Result<_, _>>()?;
        Ok(Placement { stencils })
    }

    /// (T1) of a number or a vector a grain.
    pub fn deposit<Q: Quantity>(
        &self,
        placement: &Placement<N>,
        value_of: impl Fn(usize) -> Q,
    ) -> Vec<Q> {
        let mut nodal = vec![Q::from_components(|_| 0.0); self.node_count()];
        for (grain, stencil) in placement.stencils.iter().enumerate() {
            let mut value = value_of(grain);
            value /= self.depth;
            for (&node, &weight) in stencil.nodes.iter().zip(&stencil.weights) {
                nodal[node as usize] += value * weight;
            }
        }
        match &self.kernel {
            Some(kernel) => {
                let mut smoothed = columns(&nodal);
                kernel.solve(&mut smoothed);
                set_columns(&mut nodal, &smoothed);
            }
            None => {
                let masses = nodal.iter_mut().zip(&self.nodal_mass);
                masses.for_each(|(value, &mass)| *value /= mass);
            }
        }
        nodal
    }

    /// (T2) of a nodal field.
    pub fn sample<Q: Quantity>(&self, placement: &Placement<N>, nodal: &[Q]) -> Vec<Q> {
        let smoothed = self.kernel.as_ref().map(|kernel| {
            let mut columns = columns(nodal);
            let masses = self.nodal_mass.iter().cycle();
            columns.iter_mut().zip(masses).for_each(|(f, l)| *f *= l);
            kernel.solve(&mut columns);
            let mut field = nodal.to_vec();
            set_columns(&mut field, &columns);
            field
        });
        let field = smoothed.as_deref().unwrap_or(nodal);
        let at = |stencil: &Stencil<N>| {
            let mut sum = field[stencil.nodes[0] as usize] * stencil.weights[0];
            for k in 1..N {
                sum += field[stencil.nodes[k] as usize] * stencil.weights[k];
            }
            sum
        };
        placement.stencils.iter().map(at).collect()
    }
}
