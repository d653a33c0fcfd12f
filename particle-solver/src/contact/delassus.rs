//! The contact operator, matrix-free: bodies carry velocities, contacts carry impulses.
//!
//! ```text
//!   A = m + γδt                     inertia with implicit drag                            (D1)
//!   v = v_free + A⁻¹ Hᵀ R,   A (v − v_free) is each grain's sum of impulses               (D3)
//!   W_nn = 1/A_i + 1/A_j,    W_tt = W_nn + r_i²/I_i + r_j²/I_j                            (D4)
//!   u_t = (v_i − v_j)_t − (s_i + s_j) × n,   s = r ω,   Δs = −(r²/I) n × R_t              (D8)
//! ```
//!
//! The drag is in A, hence in the contact operator: with the bare mass two grains pressed
//! together keep their gap but miss their momentum balance by as much as the contact force.
//! For balls the normal passes through both centres, so W_nt = 0. Fluid torque is not modelled:
//! I has no drag. Spin appears as the surface speed s, its inverse inertia r²/I = 1/(κ m).

use space::{Dim, Dimension, Spin, Vector, dot};

use crate::contact::impulses::Pair;
use crate::contact::law::{EffectiveMass, Friction, Local, closing_speed};
use crate::contact::loads::{FreeMotion, Loads};
use crate::grains::Grains;
use crate::walls::grounds::Grounds;

/// A body of the contact problem; one cache line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Body<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// v \[m/s\].
    pub velocity: Vector<D>,
    /// s = r ω \[m/s\].
    pub surface: Spin<D>,
    /// 1/A \[1/kg\]; 0 when it cannot move.
    pub inverse_mass: f64,
    /// r²/I \[1/kg\].
    pub inverse_inertia: f64,
}

impl<const D: usize> Body<D>
where
    Dim<D>: Dimension<D>,
{
    /// One that nothing accelerates, like the ground.
    fn steady(velocity: Vector<D>) -> Body<D> {
        Body {
            velocity,
            surface: Spin::<D>::default(),
            inverse_mass: 0.0,
            inverse_inertia: 0.0,
        }
    }
}

/// A contact of the contact problem; in the plane one cache line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Contact<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// Body that the normal points to.
    pub first: u32,
    /// Body that the normal comes from; bodies after the grains are the grounds.
    pub second: u32,
    /// Unit normal.
    pub normal: Vector<D>,
    /// b of (L1) \[m/s\].
    pub closing_speed: f64,
    /// R, R_n ≥ 0 \[N s\].
    pub impulse: Local<D>,
    /// 1/W.
    pub mass: EffectiveMass,
}

/// One contact problem.
#[derive(Debug, Clone)]
pub struct System<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// One a grain, then the grounds.
    pub bodies: Vec<Body<D>>,
    /// Number of the first ground.
    pub ground: u32,
    /// Contacts of all pairs.
    pub contacts: Vec<Contact<D>>,
    /// 1/(δt F_c) of each contact \[1/(N s)\], see `residual`.
    pub weights: Vec<f64>,
    /// Free velocity and surface speed of each body.
    pub free: Vec<(Vector<D>, Spin<D>)>,
    /// μ.
    pub friction: Friction,
}

/// What a contact problem is made of besides loads and pairs.
#[derive(Debug, Clone, Copy)]
pub struct Material {
    /// μ.
    pub friction: Friction,
    /// κ = I/(m r²).
    pub inertia_factor: f64,
}

impl<const D: usize> System<D>
where
    Dim<D>: Dimension<D>,
{
    /// Assemble (D1)–(D4) at the free velocities, without impulses.
    pub fn assemble(
        grains: &Grains,
        material: &Material,
        loads: &Loads<'_, D>,
        free: &FreeMotion<D>,
        (pairs, grounds): (&[Pair<D>], &Grounds<D>),
    ) -> System<D> {
        let count = grains.count();
        let mut bodies = vec![Body::steady(Vector::zeros()); count];
        bodies.extend(grounds.velocity.iter().map(|v| Body::steady(*v)));
        for (grain, body) in bodies[..count].iter_mut().enumerate() {
            body.velocity = free.velocity[grain];
            if !grains.fixed[grain] {
                body.surface = free.surface[grain];
                body.inverse_mass = 1.0 / (grains.mass[grain] + loads.dt * loads.on(grain).0);
                body.inverse_inertia = 1.0 / (material.inertia_factor * grains.mass[grain]);
            }
        }
        let contacts = pairs
            .iter()
            .map(|pair| {
                let second = pair.key.second as usize;
                let second = match second.checked_sub(count) {
                    Some(feature) => count as u32 + grounds.of(feature),
                    None => pair.key.second,
                };
                Contact::new(&bodies, pair, second, count as u32, loads.dt)
            })
            .collect();
        let free = bodies
            .iter()
            .map(|body| (body.velocity, body.surface))
            .collect();
        System {
            bodies,
            ground: count as u32,
            contacts,
            weights: Vec::new(),
            free,
            friction: material.friction,
        }
    }

    /// Is any tangential work to be done?
    pub fn has_friction(&self) -> bool {
        self.friction.acts()
    }

    /// μ of a contact.
    #[inline]
    pub fn friction_of(&self, contact: &Contact<D>) -> f64 {
        if contact.second >= self.ground {
            self.friction.walls
        } else {
            self.friction.grains
        }
    }

    /// (U_n, u_t) of a contact \[m/s\].
    #[inline]
    pub fn speed(&self, contact: &Contact<D>) -> Local<D> {
        relative_speed(
            &self.bodies[contact.first as usize],
            &self.bodies[contact.second as usize],
            contact,
        )
    }

    /// v = v_free + A⁻¹HᵀR (D3), from scratch: momentum is then exact to round-off per grain.
    pub fn apply_impulses(&mut self) {
        for (body, free) in self.bodies.iter_mut().zip(&self.free) {
            (body.velocity, body.surface) = *free;
        }
        for contact in &self.contacts {
            if contact.impulse != Local::default() {
                push(&mut self.bodies, contact, &contact.impulse);
            }
        }
    }

    /// The impulses, to come back to.
    pub fn impulses(&self) -> Vec<Local<D>> {
        self.contacts
            .iter()
            .map(|contact| contact.impulse)
            .collect()
    }

    /// Set the impulses, brought into the cone, and the velocities that follow from them.
    pub fn set_impulses(&mut self, impulses: &[Local<D>]) {
        for (place, impulse) in impulses.iter().enumerate() {
            let limit = self.friction_of(&self.contacts[place]) * impulse.normal;
            self.contacts[place].impulse = Local {
                normal: impulse.normal,
                tangential: Dim::<D>::limited(impulse.tangential, limit),
            };
        }
        self.apply_impulses();
    }
}

impl<const D: usize> Contact<D>
where
    Dim<D>: Dimension<D>,
{
    fn new(bodies: &[Body<D>], pair: &Pair<D>, second: u32, ground: u32, dt: f64) -> Contact<D> {
        let first = pair.key.first;
        let (one, two) = (&bodies[first as usize], &bodies[second as usize]);
        let normal = one.inverse_mass + two.inverse_mass;
        // A wall stays where it is: what its velocity has along the normal is round-off, or a ridge's.
        let stays = match second >= ground {
            true => dot(&two.velocity, &pair.normal),
            false => 0.0,
        };
        Contact {
            first,
            second,
            normal: pair.normal,
            closing_speed: closing_speed(pair.gap, dt) + stays,
            impulse: Local::default(),
            mass: EffectiveMass {
                normal: 1.0 / normal,
                tangential: 1.0 / (normal + one.inverse_inertia + two.inverse_inertia),
            },
        }
    }
}

/// (U_n, u_t) between two bodies (D8).
#[inline(always)]
pub fn relative_speed<const D: usize>(
    one: &Body<D>,
    two: &Body<D>,
    contact: &Contact<D>,
) -> Local<D>
where
    Dim<D>: Dimension<D>,
{
    let normal = &contact.normal;
    let apart = one.velocity - two.velocity;
    Local {
        normal: dot(&apart, normal) + contact.closing_speed,
        tangential: Dim::<D>::tangential(&apart, normal)
            - Dim::<D>::surface(one.surface, normal)
            - Dim::<D>::surface(two.surface, normal),
    }
}

/// Add a change of impulse to the velocities of both bodies (D3), (D8).
#[inline(always)]
pub fn push<const D: usize>(bodies: &mut [Body<D>], contact: &Contact<D>, change: &Local<D>)
where
    Dim<D>: Dimension<D>,
{
    let impulse = Dim::<D>::combined(change.normal, change.tangential, &contact.normal);
    let torque = Dim::<D>::torque(change.tangential, &contact.normal);
    let one = &mut bodies[contact.first as usize];
    one.velocity += impulse * one.inverse_mass;
    one.surface = one.surface - torque * one.inverse_inertia;
    let two = &mut bodies[contact.second as usize];
    two.velocity -= impulse * two.inverse_mass;
    two.surface = two.surface - torque * two.inverse_inertia;
}
