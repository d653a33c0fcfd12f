//! Grains in a fluid: where they are on its mesh, their drag, and the force of the fluid on them.

use protocol::engine::without;
use protocol::scene::{DragLaw, Geometry};
use space::{Dim, Dimension, Vector, hypot};

use crate::drag::laws::{self, Fluid, POROSITY_RANGE, Shape};
use crate::drag::slip::implicit_slip_speed;
use crate::error::{CouplerError, place};
use crate::exits::Exits;
use crate::follow::carry;
use crate::state::{Flow, Grains, State};
use crate::transfer::mesh::Mesh;
use crate::transfer::{Placement, Transfer};

/// What grains and fluid need of each other.
#[derive(Debug)]
pub struct Immersion<const D: usize, const N: usize> {
    /// Between grains and mesh.
    pub transfer: Transfer<D, N>,
    /// The fluid around the grains.
    pub fluid: Fluid,
    /// g \[m/s²\]
    pub gravity: Vector<D>,
    /// Of drag.
    pub law: DragLaw,
    /// Of every grain.
    pub shapes: Vec<Shape>,
    /// Where grains leave.
    pub exits: Exits<D>,
}

impl<const D: usize, const N: usize> Immersion<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Grains on the mesh at xⁿ + ½Δt vⁿ: the mid-point removes the first-order spiral of grains
    /// that follow curved streamlines. A grain that leaves on the way is where it was inside last.
    pub fn place(&self, grains: &Grains<D>, dt: f64) -> Result<Placement, CouplerError> {
        let paths = grains.position.iter().zip(&grains.velocity).enumerate();
        let (transfer, exits) = (&self.transfer, &self.exits);
        let middle =
            paths.map(|(grain, (x, v))| exits.place(transfer, grain, x, &(v * (0.5 * dt))));
        let middle = middle.collect::<Result<Vec<Vector<D>>, _>>()?;
        transfer.place(&middle, &grains.radius)
    }

    /// Take over another mesh, and bring the fluid's accepted fields to it.
    pub fn change_mesh(
        &mut self,
        mesh: &Mesh<D, N>,
        state: &mut State<D>,
    ) -> Result<(), CouplerError> {
        carry(&self.transfer, mesh, state)?;
        self.transfer = Transfer::new(mesh, self.transfer.depth());
        Ok(())
    }

    /// These grains have left, by ascending numbers.
    pub fn remove(&mut self, gone: &[usize]) {
        self.shapes = without(&self.shapes, 1, gone);
    }

    /// φ = 1 − T(V); an error names the first node where it is not positive.
    pub fn porosity(
        &self,
        grains: &Grains<D>,
        placement: &Placement,
    ) -> Result<Vec<f64>, CouplerError> {
        let mut porosity = self.transfer.deposit(placement, |i| grains.volume[i]);
        porosity.iter_mut().for_each(|value| *value = 1.0 - *value);
        let broken = |value: &f64| value.is_nan() || *value <= 0.0;
        match porosity.iter().position(broken) {
            Some(node) => Err(CouplerError::Porosity {
                node,
                porosity: porosity[node],
                at: place(self.transfer.node_position(node)),
            }),
            None => Ok(porosity),
        }
    }

    /// γ of every grain \[kg/s\] with the slip that the drag itself decides over `dt` (D7); none: with
    /// the slip of the start.
    pub fn drag(
        &self,
        grains: &Grains<D>,
        flow: &Flow<D>,
        placement: &Placement,
        porosity: &[f64],
        dt: Option<f64>,
    ) -> Vec<f64> {
        let porosity = self.transfer.sample(placement, porosity);
        let velocity = self.transfer.sample(placement, &flow.velocity);
        let gradient = self.transfer.sample(placement, &flow.pressure_gradient);
        let drag = |i: usize| {
            let (law, fluid, shape) = (self.law, &self.fluid, &self.shapes[i]);
            let porosity = porosity[i].clamp(POROSITY_RANGE[0], POROSITY_RANGE[1]);
            let slip = grains.velocity[i] - velocity[i];
            let slip_speed = match dt.filter(|_| !grains.fixed[i]) {
                None => hypot(&slip),
                Some(dt) => {
                    let inertia = grains.mass[i] / dt;
                    let drive = slip * inertia + self.gravity * grains.mass[i]
                        - gradient[i] * grains.volume[i]
                        + grains.contact_force[i];
                    implicit_slip_speed(law, fluid, porosity, shape, inertia, hypot(&drive))
                }
            };
            laws::coefficient(law, fluid, porosity, slip_speed, shape)
        };
        (0..grains.count()).map(drag).collect()
    }

    /// q = γ N w − V N G \[N\] (S3).
    pub fn force(
        &self,
        grains: &Grains<D>,
        flow: &Flow<D>,
        placement: &Placement,
        drag: &[f64],
    ) -> Vec<Vector<D>> {
        let velocity = self.transfer.sample(placement, &flow.velocity);
        let gradient = self.transfer.sample(placement, &flow.pressure_gradient);
        (0..drag.len())
            .map(|i| velocity[i] * drag[i] - gradient[i] * grains.volume[i])
            .collect()
    }
}

/// Shapes of grains of these radii \[m\].
pub fn shapes(geometry: Geometry, radii: &[f64]) -> Vec<Shape> {
    let cubes: f64 = radii.iter().map(|r| r.powi(3)).sum();
    let squares: f64 = radii.iter().map(|r| r.powi(2)).sum();
    let sauter = cubes / squares; // mean radius weighted by surface
    radii
        .iter()
        .map(|&radius| Shape::new(geometry, radius, radius / sauter))
        .collect()
}
