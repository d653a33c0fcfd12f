//! Non-linear Gauss–Seidel: visit contact after contact, solve each against all others.
//!
//! Friction is solved in the same visit, with the new normal impulse as its limit. The order of
//! the contacts does not matter to the rate, so it is the order of their keys. Relaxation 1.5
//! halves the error of a warm-started solve at equal cost; 1.8 spoils warm starts.

use crate::delassus::{Body, Contact, System, push, relative_speed};
use crate::law::{normal_impulse, tangential_impulse};

/// Over-relaxation of production sweeps.
pub const RELAXATION: f64 = 1.5;

/// One sweep over all contacts; returns Σ −ΔR·U with the speeds before each visit, which is
/// Σ (ΔR)² W where no bound acts and ω = 1: the size of what it changed \[J\].
pub fn sweep(system: &mut System, relaxation: f64) -> f64 {
    if system.has_friction() {
        let (grain, wall) = (system.friction[0], system.friction[1]);
        let ground = system.bodies.len() as u32 - 1;
        let System {
            bodies, contacts, ..
        } = system;
        contacts
            .iter_mut()
            .map(|contact| {
                let friction = if contact.second == ground {
                    wall
                } else {
                    grain
                };
                visit_rough(bodies, contact, friction, relaxation)
            })
            .sum()
    } else {
        let System {
            bodies, contacts, ..
        } = system;
        contacts
            .iter_mut()
            .map(|contact| visit_smooth(bodies, contact, relaxation))
            .sum()
    }
}

/// Solve one frictionless contact.
#[inline(always)]
fn visit_smooth(bodies: &mut [Body], contact: &mut Contact, relaxation: f64) -> f64 {
    let [nx, ny] = contact.normal;
    let one = bodies[contact.first as usize];
    let two = bodies[contact.second as usize];
    let speed = (one.velocity[0] - two.velocity[0]) * nx
        + (one.velocity[1] - two.velocity[1]) * ny
        + contact.closing_speed;
    let new = normal_impulse(
        contact.normal_impulse,
        speed,
        contact.normal_mass,
        relaxation,
    );
    let change = new - contact.normal_impulse;
    contact.normal_impulse = new;
    let (x, y) = (change * nx, change * ny);
    let first = &mut bodies[contact.first as usize];
    first.velocity = [
        one.velocity[0] + one.inverse_mass * x,
        one.velocity[1] + one.inverse_mass * y,
    ];
    let second = &mut bodies[contact.second as usize];
    second.velocity = [
        two.velocity[0] - two.inverse_mass * x,
        two.velocity[1] - two.inverse_mass * y,
    ];
    -change * speed
}

/// Solve one contact with friction; for disks the normal impulse does not change u_t.
#[inline(always)]
fn visit_rough(bodies: &mut [Body], contact: &mut Contact, friction: f64, relaxation: f64) -> f64 {
    let one = bodies[contact.first as usize];
    let two = bodies[contact.second as usize];
    let speed = relative_speed(&one, &two, contact);
    let normal = normal_impulse(
        contact.normal_impulse,
        speed[0],
        contact.normal_mass,
        relaxation,
    );
    let tangential = tangential_impulse(
        contact.tangential_impulse,
        speed[1],
        contact.tangential_mass,
        friction * normal,
        relaxation,
    );
    let change = [
        normal - contact.normal_impulse,
        tangential - contact.tangential_impulse,
    ];
    contact.normal_impulse = normal;
    contact.tangential_impulse = tangential;
    if change != [0.0; 2] {
        push(bodies, contact, change);
    }
    -(change[0] * speed[0] + change[1] * speed[1])
}
