//! What a fluid holds, and what another mesh makes of it.
//!
//! ```text
//!   V = ∫φ      M = ρ∫u = ρ∫φv      T = ½ρ∫φ|v|²      before and after a change of mesh: ΔV, ΔM, ΔT    (Z3)
//! ```
//!
//! in the plane per metre of depth, with v = u_h/φ_h at the quadrature points of the energy identity. A step begins
//! with what the change leaves, so that (E) of the step knows nothing of it: over a run ΔM and ΔT stand beside the
//! impulses and the work of the steps.

use serde::{Deserialize, Serialize};
use space::simplex::{combine, interpolate};
use space::{Dim, Dimension, Vector, dot, hypot, quadrature};

use crate::mesh::simplices::Mesh;
use crate::numbers::{Numbers, named};

const AXES: [&str; 3] = ["x", "y", "z"];

/// A volume of grains below this part of the fluid's is none but round-off.
const NO_GRAINS: f64 = 1e-12;

/// What a fluid holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Content<const D: usize> {
    /// ∫φ \[m^D\]
    pub volume: f64,
    /// ∫(1−φ) \[m^D\]
    pub solid_volume: f64,
    /// ρ∫u \[kg m/s, in the plane kg/s\]
    pub momentum: Vector<D>,
    /// ρ∫|u|, in the same unit.
    pub momentum_size: f64,
    /// ½ρ∫|u|²/φ \[J, in the plane J/m\]
    pub kinetic_energy: f64,
}

impl<const D: usize> Content<D> {
    fn nothing() -> Content<D> {
        Content {
            volume: 0.0,
            solid_volume: 0.0,
            momentum: Vector::zeros(),
            momentum_size: 0.0,
            kinetic_energy: 0.0,
        }
    }

    /// Of a fluid of this porosity, superficial velocity \[m/s\] and density \[kg/m³\].
    pub fn new<const N: usize>(
        mesh: &Mesh<D, N>,
        porosity: &[f64],
        velocity: &[Vector<D>],
        density: f64,
    ) -> Content<D>
    where
        Dim<D>: Dimension<D>,
    {
        let mut sum = Content::nothing();
        for (nodes, simplex) in mesh.simplices.iter().zip(&mesh.geometry) {
            let (phi, u) = (nodes.map(|n| porosity[n]), nodes.map(|n| velocity[n]));
            for (shape, weight) in quadrature::points::<N>() {
                let (phi, u) = (interpolate(&shape, &phi), combine(&shape, &u));
                let weight = weight * simplex.volume;
                sum.volume += weight * phi;
                sum.solid_volume += weight * (1.0 - phi);
                sum.momentum += u * (weight * density);
                sum.momentum_size += weight * density * hypot(&u);
                sum.kinetic_energy += 0.5 * weight * density * dot(&u, &u) / phi;
            }
        }
        sum
    }
}

/// What the fluid holds on the mesh of the last step and on the one that the next begins on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeshChange<const D: usize> {
    /// On the mesh before.
    pub from: Content<D>,
    /// On the new one.
    pub to: Content<D>,
}

impl<const D: usize> MeshChange<D> {
    /// The mesh has stayed.
    pub fn none() -> MeshChange<D> {
        let nothing = Content::nothing();
        MeshChange {
            from: nothing,
            to: nothing,
        }
    }

    /// ΔT of (Z3) \[J, in the plane J/m\].
    pub fn energy(&self) -> f64 {
        self.to.kinetic_energy - self.from.kinetic_energy
    }

    /// ΔM of (Z3) \[kg m/s, in the plane kg/s\].
    pub fn momentum(&self) -> Vector<D> {
        self.to.momentum - self.from.momentum
    }

    /// ΔV of (Z3) \[m^D\].
    pub fn volume(&self) -> f64 {
        self.to.volume - self.from.volume
    }

    /// As diagnostics: (Z3), and sizes of it over ∫(1−φ), ρ∫|u| and T before.
    pub fn numbers(&self) -> Numbers {
        let (from, momentum) = (&self.from, self.momentum());
        let solid = match from.solid_volume > NO_GRAINS * from.volume {
            true => from.solid_volume,
            false => 0.0,
        };
        let mut numbers = named([
            ("mesh_volume", self.volume()),
            ("mesh_energy", self.energy()),
            ("mesh_volume_share", share(self.volume(), solid)),
            (
                "mesh_momentum_share",
                share(hypot(&momentum), from.momentum_size),
            ),
            (
                "mesh_energy_share",
                share(self.energy(), from.kinetic_energy),
            ),
        ]);
        let along = AXES.iter().zip(momentum.iter());
        numbers.extend(along.map(|(axis, change)| (format!("mesh_momentum_{axis}"), *change)));
        numbers
    }
}

/// |change| over what there was; 0 where there was nothing.
fn share(change: f64, of: f64) -> f64 {
    if of > 0.0 { change.abs() / of } else { 0.0 }
}
