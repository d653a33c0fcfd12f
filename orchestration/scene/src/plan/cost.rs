//! What a step costs, roughly: for the shares that a plan gives, never for a result.
//!
//! ```text
//!   fluid      1.4 µs a triangle (assembly) + 0.94 µs N^1.2 (factor) + 0.9 µs N (solves), N nodes
//!   grains     1.1 µs a grain, 0.4 of it the search for contacts when it is made each time;
//!              dry: 20 µs more, the contacts
//!   coupler    0.1 µs a node + 0.9 µs a grain; 2 µs a grain more where grains are spread
//!   in space   14 µs N (assembly, multigrid), 14 µs N (solve, powers), 40 µs a grain that is spread
//! ```
//!
//! One pass on one thread, from the scenes of this repository (docs/leaving-out.md; `cloud-3d`).

use protocol::scene::MeshSource;

use crate::refinement;
use crate::scene::Scene;

/// Seconds of one pass by part; only their ratios are meant.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cost {
    /// The matrix of the fluid: assembly and factor.
    pub matrix: f64,
    /// Right-hand side and solves of the fluid.
    pub solve: f64,
    /// Search for contacts, made each time.
    pub search: f64,
    /// The rest of the grains.
    pub grains: f64,
    /// Transfer, drag, budgets.
    pub coupler: f64,
    /// Points of grains that are spread.
    pub spreading: f64,
}

impl Cost {
    /// Of a scene whose grains are spread or not; a mesh file counts as 10 000 nodes.
    pub fn of(scene: &Scene, spread: bool) -> Cost {
        let nodes = match scene.coupler.fluid.as_ref().map(|fluid| &fluid.mesh) {
            None => 0.0,
            Some(MeshSource::File { .. }) => 1e4,
            Some(MeshSource::Rectangle { cells, .. } | MeshSource::Box { cells, .. }) => {
                cells.iter().map(|&count| (count + 1) as f64).product()
            }
        };
        let nodes = refinement::nodes(&scene.coupler, &scene.grains).unwrap_or(nodes);
        let grains = scene.grains.len() as f64;
        let coupled = if nodes > 0.0 && grains > 0.0 {
            1.0
        } else {
            0.0
        };
        let assembly = 1.4e-6 * 2.0 * nodes;
        let (matrix, solve, spreading) = match scene.grains.dimension {
            3 => (14e-6 * nodes, 14e-6 * nodes, 40e-6),
            _ => (
                0.6 * assembly + 0.94e-6 * nodes.powf(1.2),
                0.4 * assembly + 0.9e-6 * nodes,
                2e-6,
            ),
        };
        Cost {
            matrix,
            solve,
            search: 0.4e-6 * grains,
            grains: if nodes > 0.0 { 0.7e-6 } else { 20.7e-6 } * grains,
            coupler: coupled * (0.1e-6 * nodes + 0.9e-6 * grains),
            spreading: match spread {
                true => coupled * spreading * grains,
                false => 0.0,
            },
        }
    }

    /// This part of it.
    pub fn share(&self, seconds: f64) -> f64 {
        let fluid = self.matrix + self.solve;
        let total = fluid + self.search + self.grains + self.coupler + self.spreading;
        seconds / total.max(f64::MIN_POSITIVE)
    }
}
