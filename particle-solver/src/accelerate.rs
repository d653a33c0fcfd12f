//! Sweeps with momentum, for when plain sweeps stall: on a column of n grains plain sweeps need
//! O(n²) iterations, these O(n).
//!
//! Nesterov's momentum on the impulses with restart (Nesterov 1983; O'Donoghue and Candès 2015),
//! projected on the Coulomb cone with the normal impulse as the limit:
//!
//! ```text
//!   t⁺ = ½(1 + √(1 + 4t²)),   R̂ = Π(R + (t − 1)/t⁺ (R − R_previous))                      (A1)
//! ```

use crate::delassus::{System, push};
use crate::nlgs::sweep;

/// Momentum of (A1).
#[derive(Debug)]
struct Momentum {
    t: f64,
}

impl Momentum {
    /// The next coefficient (t − 1)/t⁺.
    fn next(&mut self) -> f64 {
        let next = 0.5 * (1.0 + (1.0 + 4.0 * self.t * self.t).sqrt());
        let coefficient = (self.t - 1.0) / next;
        self.t = next;
        coefficient
    }
}

/// Gauss–Seidel sweeps with momentum; restarts when a sweep changes more than the one before.
#[derive(Debug)]
pub struct MomentumSweeps {
    momentum: Momentum,
    previous: Vec<[f64; 2]>,
    last_change: f64,
}

impl MomentumSweeps {
    /// Start from the present impulses.
    pub fn new(system: &System) -> MomentumSweeps {
        let momentum = Momentum { t: 1.0 };
        MomentumSweeps {
            momentum,
            previous: system.impulses(),
            last_change: f64::INFINITY,
        }
    }

    /// One sweep and the extrapolation after it.
    pub fn iterate(&mut self, system: &mut System) {
        let change = sweep(system, 1.0);
        if change > self.last_change {
            self.momentum.t = 1.0;
        }
        self.last_change = change;
        let coefficient = self.momentum.next();
        for place in 0..system.contacts.len() {
            let contact = &system.contacts[place];
            let swept = [contact.normal_impulse, contact.tangential_impulse];
            let target = extrapolate(swept, self.previous[place], coefficient);
            self.previous[place] = swept;
            assign(system, place, target);
        }
    }
}

/// R + c (R − R_previous).
fn extrapolate(now: [f64; 2], previous: [f64; 2], coefficient: f64) -> [f64; 2] {
    [
        now[0] + coefficient * (now[0] - previous[0]),
        now[1] + coefficient * (now[1] - previous[1]),
    ]
}

/// Give a contact the projection of these impulses, and the velocities their change.
fn assign(system: &mut System, place: usize, target: [f64; 2]) {
    let limit = system.friction_of(&system.contacts[place]);
    let contact = &mut system.contacts[place];
    let normal = target[0].max(0.0);
    let tangential = target[1].min(limit * normal).max(-limit * normal);
    let change = [
        normal - contact.normal_impulse,
        tangential - contact.tangential_impulse,
    ];
    if change != [0.0; 2] {
        contact.normal_impulse = normal;
        contact.tangential_impulse = tangential;
        let contact = *contact;
        push(&mut system.bodies, &contact, change);
    }
}
