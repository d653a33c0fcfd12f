//! What a sub-step reads and writes: a record a grain and a record a contact, each a cache line in the plane.

use space::{Dim, Dimension, Spin, Vector};

use crate::contact::delassus::Material;
use crate::contact::impulses::Key;
use crate::contact::law::EffectiveMass;
use crate::contact::loads::Loads;
use crate::grains::{Grains, State};
use crate::small::near::Near;
use crate::walls::near::Walls;

/// A grain, or a ground that cannot move.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct Body<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// v \[m/s\].
    pub velocity: Vector<D>,
    /// s = r ω \[m/s\].
    pub surface: Spin<D>,
    /// 1/A, A = m + γh \[1/kg\]; 0 when it cannot move.
    pub inverse_mass: f64,
    /// r²/I \[1/kg\].
    pub inverse_inertia: f64,
    /// x \[m\].
    pub position: Vector<D>,
    /// r \[m\]; infinite of a ground.
    pub radius: f64,
}

/// Not a wall.
pub const GRAIN: u32 = u32::MAX;

/// A contact that may act.
#[derive(Debug, Clone, Copy)]
pub struct Contact<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// Body that the normal points to.
    pub first: u32,
    /// Body that the normal comes from; those after the grains are the grounds.
    pub second: u32,
    /// Which shift by whole periods brings the first to the second.
    pub shift: u32,
    /// Face or ridge of the walls; `GRAIN` between grains.
    pub feature: u32,
    /// R_n of the last sub-step \[N s\].
    pub normal: f64,
    /// n × R_t of the last sub-step \[N s\].
    pub torque: Spin<D>,
    /// R_n n + R_t as it was applied: taken back exactly when the normal has turned \[N s\].
    pub impulse: Vector<D>,
    /// 1/W.
    pub mass: EffectiveMass,
}

/// How a grain moves without contacts in a sub-step: v ← `keep` v + `gain`.
#[derive(Debug, Clone, Copy)]
pub struct Free<const D: usize> {
    /// m/(m + γh).
    pub keep: f64,
    /// h (m g + q)/(m + γh) \[m/s\].
    pub gain: Vector<D>,
}

/// Change of velocity and of surface speed that contacts made in the last sub-step \[m/s\].
#[derive(Debug, Clone, Copy)]
pub struct Given<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// Δv.
    pub velocity: Vector<D>,
    /// Δs.
    pub surface: Spin<D>,
}

/// What a contact gave in the sub-steps of a row \[N s\].
#[derive(Debug, Clone, Copy)]
pub struct Sum<const D: usize> {
    /// Σ R_n.
    pub normal: f64,
    /// Σ (R_n n + R_t).
    pub impulse: Vector<D>,
}

/// Bodies at the start of a row of sub-steps of length `loads.dt`, the grounds after the grains.
pub fn bodies<const D: usize>(
    (grains, walls): (&Grains, &Walls<D>),
    material: &Material,
    state: &State<D>,
    loads: &Loads<'_, D>,
) -> (Vec<Body<D>>, Vec<Free<D>>)
where
    Dim<D>: Dimension<D>,
{
    let count = grains.count();
    let (mut bodies, mut free) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for grain in 0..count {
        let (mass, fixed) = (grains.mass[grain], grains.fixed[grain]);
        let (drag, force) = loads.on(grain);
        let inverse_mass = 1.0 / (mass + loads.dt * drag);
        let moves = if fixed { 0.0 } else { 1.0 };
        bodies.push(Body {
            velocity: state.velocity[grain] * moves,
            surface: state.spin[grain] * (grains.radius[grain] * moves),
            inverse_mass: moves * inverse_mass,
            inverse_inertia: moves / (material.inertia_factor * mass),
            position: state.position[grain],
            radius: grains.radius[grain],
        });
        free.push(Free {
            keep: mass * inverse_mass,
            gain: (loads.gravity * mass + force) * (loads.dt * inverse_mass * moves),
        });
    }
    bodies.extend(walls.grounds().velocity.iter().map(|velocity| Body {
        velocity: *velocity,
        surface: Spin::<D>::default(),
        inverse_mass: 0.0,
        inverse_inertia: 0.0,
        position: Vector::zeros(),
        radius: f64::INFINITY,
    }));
    (bodies, free)
}

/// Contacts without impulses between these bodies.
pub fn contacts<const D: usize>(
    near: &[Near],
    (grains, walls): (&Grains, &Walls<D>),
    bodies: &[Body<D>],
) -> Vec<Contact<D>>
where
    Dim<D>: Dimension<D>,
{
    let count = grains.count() as u32;
    let contact = |near: &Near| {
        let Key { first, second, .. } = near.key;
        let (second, feature) = match second.checked_sub(count) {
            Some(feature) => (count + walls.grounds().of(feature as usize), feature),
            None => (second, GRAIN),
        };
        let (one, two) = (&bodies[first as usize], &bodies[second as usize]);
        let normal = one.inverse_mass + two.inverse_mass;
        Contact {
            first,
            second,
            shift: near.shift,
            feature,
            normal: 0.0,
            torque: Spin::<D>::default(),
            impulse: Vector::zeros(),
            mass: EffectiveMass {
                normal: 1.0 / normal,
                tangential: 1.0 / (normal + one.inverse_inertia + two.inverse_inertia),
            },
        }
    };
    near.iter().map(contact).collect()
}
