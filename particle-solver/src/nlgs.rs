//! Non-linear Gauss–Seidel: visit contact after contact, solve each against all others.
//!
//! Friction is solved in the same visit, with the new normal impulse as its limit. The order of
//! the contacts does not matter to the rate, so it is the order of their keys. Relaxation 1.5
//! halves the error of a warm-started solve at equal cost; 1.8 spoils warm starts.

use crate::delassus::{Body, Contact, System, push, relative_speed};
use crate::law::{normal_impulse, tangential_impulse};

/// Over-relaxation of production sweeps.
pub const RELAXATION: f64 = 1.5;

/// One sweep over all contacts; returns Σ (ΔR)² W, the size of what it changed \[J\].
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
    change * change / contact.normal_mass
}

/// Solve one contact with friction; for disks the normal impulse does not change u_t.
#[inline(always)]
fn visit_rough(bodies: &mut [Body], contact: &mut Contact, friction: f64, relaxation: f64) -> f64 {
    let one = &bodies[contact.first as usize];
    let two = &bodies[contact.second as usize];
    let [normal_speed, tangential_speed] = relative_speed(one, two, contact);
    let normal = normal_impulse(
        contact.normal_impulse,
        normal_speed,
        contact.normal_mass,
        relaxation,
    );
    let tangential = tangential_impulse(
        contact.tangential_impulse,
        tangential_speed,
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
    push(bodies, contact, change);
    change[0] * change[0] / contact.normal_mass + change[1] * change[1] / contact.tangential_mass
}
