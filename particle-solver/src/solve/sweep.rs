//! Non-linear Gauss–Seidel: visit contact after contact, solve each against all others.
//!
//! Friction is solved in the same visit, with the new normal impulse as its limit. The order of
//! the contacts does not matter to the rate, so it is the order of their keys. Relaxation 1.5
//! halves the error of a warm-started solve at equal cost; 1.8 spoils warm starts.

use space::{Dim, Dimension, dot};

use crate::contact::delassus::{Body, Contact, System, push, relative_speed};
use crate::contact::law::{Local, normal_impulse, tangential_impulse};

/// Over-relaxation of production sweeps.
pub const RELAXATION: f64 = 1.5;

/// One sweep over all contacts; returns Σ −ΔR·U with the speeds before each visit, which is
/// Σ (ΔR)² W where no bound acts and ω = 1: the size of what it changed \[J\].
pub fn sweep<const D: usize>(system: &mut System<D>, relaxation: f64) -> f64
where
    Dim<D>: Dimension<D>,
{
    let rough = system.has_friction();
    let (friction, ground) = (system.friction, system.ground);
    let System {
        bodies, contacts, ..
    } = system;
    if rough {
        let visit = |contact: &mut Contact<D>| {
            let friction = if contact.second >= ground {
                friction.walls
            } else {
                friction.grains
            };
            visit_rough(bodies, contact, friction, relaxation)
        };
        contacts.iter_mut().map(visit).sum()
    } else {
        let visit = |contact: &mut Contact<D>| visit_smooth(bodies, contact, relaxation);
        contacts.iter_mut().map(visit).sum()
    }
}

/// Solve one frictionless contact.
#[inline(always)]
fn visit_smooth<const D: usize>(
    bodies: &mut [Body<D>],
    contact: &mut Contact<D>,
    relaxation: f64,
) -> f64
where
    Dim<D>: Dimension<D>,
{
    let one = bodies[contact.first as usize];
    let two = bodies[contact.second as usize];
    let speed = dot(&(one.velocity - two.velocity), &contact.normal) + contact.closing_speed;
    let old = contact.impulse.normal;
    let new = normal_impulse(old, speed, contact.mass.normal, relaxation);
    let change = new - old;
    contact.impulse.normal = new;
    let impulse = contact.normal * change;
    bodies[contact.first as usize].velocity = one.velocity + impulse * one.inverse_mass;
    bodies[contact.second as usize].velocity = two.velocity - impulse * two.inverse_mass;
    -change * speed
}

/// Solve one contact with friction; for balls the normal impulse does not change u_t.
#[inline(always)]
fn visit_rough<const D: usize>(
    bodies: &mut [Body<D>],
    contact: &mut Contact<D>,
    friction: f64,
    relaxation: f64,
) -> f64
where
    Dim<D>: Dimension<D>,
{
    let one = bodies[contact.first as usize];
    let two = bodies[contact.second as usize];
    let speed = relative_speed(&one, &two, contact);
    let old = contact.impulse;
    let normal = normal_impulse(old.normal, speed.normal, contact.mass.normal, relaxation);
    let tangential = tangential_impulse::<D>(
        old.tangential,
        speed.tangential,
        contact.mass.tangential,
        friction * normal,
        relaxation,
    );
    contact.impulse = Local { normal, tangential };
    let change = contact.impulse.minus(&old);
    if change != Local::default() {
        push(bodies, contact, &change);
    }
    -change.dot(&speed)
}
