//! What the engine asks of a rapier, of that of the plane as of that of space.

use serde::Serialize;
use serde::de::DeserializeOwned;
use space::{Dim, Dimension, Linear, Spin, Vector};

use crate::model::Model;

/// Grains and walls as bodies; the candidate is a copy that has moved on.
pub trait Bodies<const D: usize>: Clone + Serialize + DeserializeOwned
where
    Dim<D>: Dimension<D>,
{
    /// Rapier's workspace.
    type Pipeline: Default;

    /// Grains and walls at the start.
    fn new(model: &Model<D>, position: &[Vector<D>], velocity: &[Vector<D>]) -> Self;

    /// One sub-step of `dt` under drag coefficients \[kg/s\] and forces \[N\]; the grain whose numbers
    /// are no longer finite is an error.
    fn step(
        &mut self,
        model: &Model<D>,
        pipeline: &mut Self::Pipeline,
        dt: f64,
        drag: Option<&[f64]>,
        force: Option<&[Vector<D>]>,
    ) -> Result<(), usize>;

    /// Number of grains.
    fn count(&self) -> usize;

    /// Centre of a grain \[m\].
    fn position(&self, grain: usize) -> Vector<D>;

    /// Velocity of a grain \[m/s\].
    fn velocity(&self, grain: usize) -> Vector<D>;

    /// Angular velocity of a grain, in the plane counter-clockwise \[rad/s\].
    fn spin(&self, grain: usize) -> Spin<D>;

    /// Bodies that the last sub-step found near each other.
    fn pairs(&self, model: &Model<D>) -> Vec<Pair>;

    /// Translational and rotational energy of all grains \[J\].
    fn kinetic_energy(&self, model: &Model<D>) -> f64 {
        let energy = |grain: usize| {
            let (velocity, spin) = (self.velocity(grain), self.spin(grain));
            0.5 * (model.mass[grain] * velocity.dot(&velocity)
                + model.inertia[grain] * spin.dot(spin))
        };
        (0..self.count()).map(energy).sum()
    }
}

/// Two grains, or a grain and a wall.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// Grains are below the number of grains; the others are walls.
    pub ends: [usize; 2],
    /// Did they push each other?
    pub pushes: bool,
    /// Overlap, of the smaller radius; negative when apart.
    pub overlap: f64,
}
