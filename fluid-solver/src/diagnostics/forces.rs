//! Forces on boundaries, inflow and pressure drop.

use space::Vector;
use space::vector::from_fn;

use super::solved::Solved;
use crate::boundary::frame::turn_back;
use crate::equations::drive::Drive;
use crate::mesh::facet::BoundaryFacet;
use crate::numbers::{Numbers, named};

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

impl<const D: usize, const N: usize> Solved<'_, D, N> {
    /// Force of the fluid on each boundary \[N, in the plane N/m\], in the order of the names.
    pub fn forces(&self) -> Vec<Vector<D>> {
        let boundaries = 0..self.mesh.boundary_names.len();
        boundaries.map(|k| self.force_on(k)).collect()
    }

    /// Force of the fluid on a boundary: reactions of the momentum rows, weighted by φ_i because
    /// Σ φ_i X_i = 1, and the pressure, which is not integrated by parts.
    pub fn force_on(&self, boundary: usize) -> Vector<D> {
        let porosity = &self.terms.solid.matrix.porosity;
        let facets = || {
            let facets = self.mesh.facets.iter();
            facets.filter(move |facet| facet.boundary == boundary)
        };
        let mut nodes: Vec<usize> = facets().flat_map(|facet| facet.node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut force = Vector::zeros();
        for n in nodes {
            let reaction = turn_back(&self.constraints.frames[n], &self.reaction[N * n..]);
            force = from_fn(|d| force[d] - porosity[n] * reaction[d]);
        }
        for facet in facets() {
            let mean = self.mean_pressure(facet);
            force = from_fn(|d| force[d] + facet.size * mean * facet.normal[d]);
        }
        force
    }

    fn mean_pressure(&self, facet: &BoundaryFacet<D>) -> f64 {
        let value = facet.node.map(|n| self.pressure[n]);
        (1..D).fold(value[0], |sum, k| sum + value[k]) / D as f64
    }

    /// Inflow and outflow \[m^D/s\], and pressure drop from where it enters to the open boundary \[Pa\].
    pub fn through_flow(&self) -> Numbers {
        let mut numbers = self.inflow();
        if !self.constraints.closed {
            numbers.push(("outflow".to_owned(), self.outflow()));
        }
        numbers
    }

    /// What enters across given velocities, and the pressure drop from there to the open boundary.
    fn inflow(&self) -> Numbers {
        let (mut inflow, mut pressure, mut size) = (0.0, 0.0, 0.0);
        let crossings = self.constraints.flux_facets.iter();
        for (facet, outward) in crossings.zip(&self.flux.of_facet) {
            if *outward < 0.0 {
                inflow -= outward;
                size += facet.size;
                pressure += self.pressure_on(facet);
            }
        }
        if inflow == 0.0 {
            return Vec::new();
        }
        let (mut outer, mut open) = (0.0, 0.0);
        for facet in &self.constraints.open_facets {
            open += facet.size;
            outer += self.pressure_on(facet);
        }
        let mut numbers = named([("inflow", inflow)]);
        if open > 0.0 {
            numbers.push(("pressure_drop".to_owned(), pressure / size - outer / open));
        }
        numbers
    }

    /// Flux of the mixture out through open boundaries: what the rows of continuity lack where the
    /// pressure is given in their place.
    fn outflow(&self) -> f64 {
        let nodes = 0..self.mesh.node_count();
        let open = nodes.filter(|n| self.constraints.fixed[N * n + D]);
        open.map(|n| -self.reaction[N * n + D]).sum()
    }

    /// The uniform part of ∇p, along the axes where it steers the mean flow.
    pub fn mean_pressure_gradient(&self) -> Numbers {
        let axes = self.drive.iter().flat_map(Drive::steered);
        axes.map(|k| {
            let name = format!("mean_pressure_gradient_{}", AXES[k]);
            (name, self.driving[k])
        })
        .collect()
    }

    /// ∫p over a facet.
    fn pressure_on(&self, facet: &BoundaryFacet<D>) -> f64 {
        let value = facet.node.map(|n| self.pressure[n]);
        let sum = (1..D).fold(value[0], |sum, k| sum + value[k]);
        facet.size / D as f64 * sum
    }

    /// Forces as diagnostics: `force_x_NAME`, `force_y_NAME`… of walls and bodies.
    pub fn wall_forces(&self, forces: &[Vector<D>]) -> Numbers {
        let mut numbers = Numbers::new();
        for (boundary, (name, force)) in self.mesh.boundary_names.iter().zip(forces).enumerate() {
            if self.constraints.condition(boundary).is_wall()
                && self
                    .mesh
                    .facets
                    .iter()
                    .any(|facet| facet.boundary == boundary)
            {
                let components = AXES.iter().zip(force.iter());
                numbers.extend(components.map(|(axis, f)| (format!("force_{axis}_{name}"), *f)));
            }
        }
        numbers
    }
}
