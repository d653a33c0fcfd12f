//! One sub-step of length h: what contacts gave in the last one is given again, each contact is visited once.
//!
//! ```text
//!   a = (m v + h(m g + q))/(m + γh),   v = a + Δv of the sub-step before                   (M3)
//!   b = gap/h  where gap > θ, else 0;   θ = 1e-4 r of a contact that acts, else 0          (M4)
//!   R_n ← [R_n − ω W_nn⁻¹ (u_n + b)]₊,   R_t ← within μ R_n: R_t − ω W_tt⁻¹ u_t,  ω = 0.8   (M5)
//!   x ← x + h v
//! ```
//!
//! Gaps and normals are those of the positions at its start. ω ≤ 1 is what keeps a row of such sub-steps stable: the
//! amplification of a chain of equal grains has the modulus 1 at ω = 1 and is 1.2 at 1.1. With θ a contact that opens
//! by round-off of its motion keeps the impulse that it presses with; without, it loses some each time and a pile
//! loosens.

use space::{Dim, Dimension, Vector, dot};

use crate::contact::law::{Friction, Local, normal_impulse, tangential_impulse};
use crate::contact::pairs::direction;
use crate::small::near::push;
use crate::small::records::{Body, Contact, Free, GRAIN, Given, Sum};
use crate::walls::near::Walls;

/// ω.
const RELAXATION: f64 = 0.8;
/// θ, of the smaller radius.
const HYSTERESIS: f64 = 1e-4;

/// What the sub-steps of a row share.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a, const D: usize> {
    /// Walls.
    pub walls: &'a Walls<D>,
    /// What a shift adds to the first position less the second \[m\].
    pub shifts: &'a [Vector<D>],
    /// μ.
    pub friction: Friction,
    /// Number of the first ground.
    pub ground: u32,
    /// h \[s\].
    pub dt: f64,
}

/// Where a contact's bodies are: its gap \[m\] and unit normal; none beyond the end of a wall.
#[inline(always)]
pub fn geometry<const D: usize>(
    frame: &Frame<'_, D>,
    contact: &Contact<D>,
    one: &Body<D>,
    two: &Body<D>,
) -> Option<(f64, Vector<D>)>
where
    Dim<D>: Dimension<D>,
{
    if contact.feature != GRAIN {
        let mut offset = one.position - frame.walls.middle(contact.feature as usize);
        offset += frame.shifts[contact.shift as usize];
        let (feature, radius) = (contact.feature as usize, one.radius);
        return frame.walls.touched_by(feature, &offset, radius, radius);
    }
    let (apart, size) = (apart(frame, contact, one, two), one.radius + two.radius);
    let square = dot(&apart, &apart);
    if square > 1e-24 * size * size {
        let distance = square.sqrt();
        return Some((distance - size, apart * (1.0 / distance)));
    }
    let (first, second) = (contact.first as usize, contact.second as usize);
    let (normal, distance) = direction(&apart, size, first, second);
    Some((distance - size, normal))
}

/// From the centre of the second to that of the first of two grains \[m\].
#[inline(always)]
fn apart<const D: usize>(
    frame: &Frame<'_, D>,
    contact: &Contact<D>,
    one: &Body<D>,
    two: &Body<D>,
) -> Vector<D>
where
    Dim<D>: Dimension<D>,
{
    let apart = one.position - two.position;
    match contact.shift {
        0 => apart,
        shift => apart + frame.shifts[shift as usize],
    }
}

/// Are two grains so far from each other that they do not meet in the sub-step, at whatever angle?
#[inline(always)]
fn are_far<const D: usize>(
    frame: &Frame<'_, D>,
    contact: &Contact<D>,
    one: &Body<D>,
    two: &Body<D>,
) -> bool
where
    Dim<D>: Dimension<D>,
{
    let apart = apart(frame, contact, one, two);
    let relative = one.velocity - two.velocity;
    let speed = (0..D).fold(0.0, |sum, axis| sum + relative[axis].abs());
    let reach = one.radius + two.radius + frame.dt * speed;
    dot(&apart, &apart) >= reach * reach
}

/// Give velocities what forces and the contacts of the sub-step before give (M3).
pub fn begin<const D: usize>(bodies: &mut [Body<D>], free: &[Free<D>], given: &mut [Given<D>])
where
    Dim<D>: Dimension<D>,
{
    for ((body, free), given) in bodies.iter_mut().zip(free).zip(given) {
        let before = Given {
            velocity: body.velocity * free.keep + free.gain,
            surface: body.surface,
        };
        body.velocity = before.velocity + given.velocity;
        body.surface = before.surface + given.surface;
        *given = before;
    }
}

/// Visit every contact once, in order (M4), (M5).
pub fn visit_all<const D: usize>(
    frame: &Frame<'_, D>,
    bodies: &mut [Body<D>],
    contacts: &mut [Contact<D>],
    sums: &mut [Sum<D>],
) where
    Dim<D>: Dimension<D>,
{
    let inverse_dt = 1.0 / frame.dt;
    for (contact, sum) in contacts.iter_mut().zip(sums) {
        visit(frame, inverse_dt, bodies, contact, sum);
    }
}

#[inline(always)]
fn visit<const D: usize>(
    frame: &Frame<'_, D>,
    inverse_dt: f64,
    bodies: &mut [Body<D>],
    contact: &mut Contact<D>,
    sum: &mut Sum<D>,
) where
    Dim<D>: Dimension<D>,
{
    let one = bodies[contact.first as usize];
    let two = bodies[contact.second as usize];
    let acts = contact.normal > 0.0;
    if !acts && contact.feature == GRAIN && are_far(frame, contact, &one, &two) {
        return;
    }
    let wall = contact.second >= frame.ground;
    let Some((gap, normal)) = geometry(frame, contact, &one, &two) else {
        apply(bodies, contact, Local::default(), &Vector::zeros());
        return;
    };
    let slack = if acts {
        HYSTERESIS * one.radius.min(two.radius)
    } else {
        0.0
    };
    let apart = one.velocity - two.velocity;
    let mut speed = dot(&apart, &normal);
    if gap > slack {
        speed += gap * inverse_dt;
    }
    if wall {
        // what a wall's velocity has along its normal is round-off, or a ridge's
        speed += dot(&two.velocity, &normal);
    }
    if !acts && speed >= 0.0 {
        return;
    }
    let new = normal_impulse(contact.normal, speed, contact.mass.normal, RELAXATION);
    let friction = if wall {
        frame.friction.walls
    } else {
        frame.friction.grains
    };
    let slip = Dim::<D>::tangential(&apart, &normal)
        - Dim::<D>::surface(one.surface, &normal)
        - Dim::<D>::surface(two.surface, &normal);
    let tangential = tangential_impulse::<D>(
        Dim::<D>::surface(contact.torque, &normal),
        slip,
        contact.mass.tangential,
        friction * new,
        RELAXATION,
    );
    let impulse = Local {
        normal: new,
        tangential,
    };
    apply(bodies, contact, impulse, &normal);
    sum.normal += contact.normal;
    sum.impulse += contact.impulse;
}

/// Put this impulse in the place of that of the sub-step before.
#[inline(always)]
pub fn apply<const D: usize>(
    bodies: &mut [Body<D>],
    contact: &mut Contact<D>,
    impulse: Local<D>,
    normal: &Vector<D>,
) where
    Dim<D>: Dimension<D>,
{
    let whole = Dim::<D>::combined(impulse.normal, impulse.tangential, normal);
    let torque = Dim::<D>::torque(impulse.tangential, normal);
    let (change, turn) = (whole - contact.impulse, torque - contact.torque);
    contact.normal = impulse.normal;
    (contact.impulse, contact.torque) = (whole, torque);
    let one = &mut bodies[contact.first as usize];
    one.velocity += change * one.inverse_mass;
    one.surface = one.surface - turn * one.inverse_inertia;
    let two = &mut bodies[contact.second as usize];
    two.velocity -= change * two.inverse_mass;
    two.surface = two.surface - turn * two.inverse_inertia;
}

/// A straight path: from where, and how fast.
#[derive(Debug, Clone, Copy)]
pub struct Path<const D: usize> {
    /// X \[m\].
    pub from: Vector<D>,
    /// \[m/s\]
    pub velocity: Vector<D>,
}

/// Move the bodies, keep what contacts gave; has one left its path after the time `t` \[s\] (M2)?
pub fn end<const D: usize>(
    bodies: &mut [Body<D>],
    given: &mut [Given<D>],
    paths: &[Path<D>],
    (dt, t): (f64, f64),
) -> bool
where
    Dim<D>: Dimension<D>,
{
    let mut strays = false;
    for ((body, given), path) in bodies.iter_mut().zip(given).zip(paths) {
        *given = Given {
            velocity: body.velocity - given.velocity,
            surface: body.surface - given.surface,
        };
        body.position += body.velocity * dt;
        let aside = body.position - path.from - path.velocity * t;
        let most = push::<D>() * body.radius;
        strays |= dot(&aside, &aside) > most * most;
    }
    strays
}
