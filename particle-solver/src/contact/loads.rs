//! What acts on the grains during a sub-step besides contacts.
//!
//! ```text
//!   v_free = (m vⁿ + δt (m g + q))/A,   A = m + γδt                                       (D2)
//! ```

use space::vector::from_fn;
use space::{Dim, Dimension, Spin, Vector};

use crate::grains::{Grains, State};

/// What acts on the grains during a sub-step.
#[derive(Debug)]
pub struct Loads<'a, const D: usize> {
    /// Length of the sub-step \[s\].
    pub dt: f64,
    /// g \[m/s²\].
    pub gravity: Vector<D>,
    /// γ \[kg/s\].
    pub drag: Option<&'a [f64]>,
    /// q \[N\].
    pub force: Option<&'a [Vector<D>]>,
}

/// How the grains would move without contacts.
#[derive(Debug)]
pub struct FreeMotion<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// v_free \[m/s\]; 0 for a fixed grain.
    pub velocity: Vec<Vector<D>>,
    /// s = r ω \[m/s\]: nothing changes a spin but friction.
    pub surface: Vec<Spin<D>>,
}

impl<const D: usize> Loads<'_, D>
where
    Dim<D>: Dimension<D>,
{
    /// γ and q of a grain.
    pub fn on(&self, grain: usize) -> (f64, Vector<D>) {
        let drag = self.drag.map_or(0.0, |drag| drag[grain]);
        let force = self.force.map_or_else(Vector::zeros, |force| force[grain]);
        (drag, force)
    }

    /// v_free (D2); 0 for a fixed grain.
    pub fn free_velocity(&self, grains: &Grains, velocity: &[Vector<D>]) -> Vec<Vector<D>> {
        let one = |grain: usize| {
            if grains.fixed[grain] {
                return Vector::zeros();
            }
            let mass = grains.mass[grain];
            let (drag, force) = self.on(grain);
            from_fn(|axis| {
                let weight = mass * self.gravity[axis];
                (mass * velocity[grain][axis] + self.dt * (weight + force[axis]))
                    / (mass + self.dt * drag)
            })
        };
        (0..grains.count()).map(one).collect()
    }

    /// Motion without contacts from this state.
    pub fn free_motion(&self, grains: &Grains, state: &State<D>) -> FreeMotion<D> {
        let surface = |grain: usize| state.spin[grain] * grains.radius[grain];
        FreeMotion {
            velocity: self.free_velocity(grains, &state.velocity),
            surface: (0..grains.count()).map(surface).collect(),
        }
    }
}
