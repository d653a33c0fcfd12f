//! Faster iterations for when plain sweeps stall: Gauss–Seidel with momentum, and accelerated
//! projected gradients. On a column of n grains sweeps need O(n²) iterations, these O(n).
//!
//! Both use Nesterov's momentum on the impulses with restart (Nesterov 1983; O'Donoghue and
//! Candès 2015), projected on the Coulomb cone with the normal impulse as the limit:
//!
//! ```text
//!   t⁺ = ½(1 + √(1 + 4t²)),   R̂ = Π(R + (t − 1)/t⁺ (R − R_previous))                      (A1)
//! ```

use crate::delassus::{System, push};
use crate::law::{normal_impulse, tangential_impulse};
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

/// Diagonally scaled projected gradients with momentum; restarts when momentum and gradient
/// disagree. `iterate` costs about a sweep.
#[derive(Debug)]
pub struct ProjectedGradients {
    momentum: Momentum,
    previous: Vec<[f64; 2]>,
    /// 1/λ of the scaled operator.
    step: f64,
}

/// Power iterations for λ.
pub const POWER_ITERATIONS: usize = 40;

impl ProjectedGradients {
    /// Start from the present impulses; λ of K^½ W K^½ from a power iteration.
    pub fn new(system: &System) -> ProjectedGradients {
        let step = 1.0 / (1.05 * largest_eigenvalue(system));
        ProjectedGradients {
            momentum: Momentum { t: 1.0 },
            previous: system.impulses(),
            step,
        }
    }

    /// One gradient step, and the extrapolation after it.
    pub fn iterate(&mut self, system: &mut System) {
        let gradient: Vec<[f64; 2]> = system
            .contacts
            .iter()
            .map(|contact| system.speed(contact))
            .collect();
        let coefficient = self.momentum.next();
        let mut along = 0.0;
        for (place, speed) in gradient.iter().enumerate() {
            let contact = &system.contacts[place];
            let limit = system.friction_of(contact);
            let [k, k_t] = [contact.normal_mass, contact.tangential_mass];
            let normal = normal_impulse(contact.normal_impulse, speed[0], k, self.step);
            let tangential = tangential_impulse(
                contact.tangential_impulse,
                speed[1],
                k_t,
                limit * normal,
                self.step,
            );
            let stepped = [normal, tangential];
            let previous = self.previous[place];
            along += speed[0] * (normal - previous[0]) + speed[1] * (tangential - previous[1]);
            self.previous[place] = stepped;
            assign(system, place, extrapolate(stepped, previous, coefficient));
        }
        if along > 0.0 {
            self.momentum.t = 1.0;
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

/// Largest eigenvalue of the operator scaled by its diagonal, a little from below.
fn largest_eigenvalue(system: &System) -> f64 {
    let rough = system.has_friction();
    let mut bodies = system.bodies.clone();
    let mut vector: Vec<[f64; 2]> = (0..system.contacts.len())
        .map(|place| {
            let spread = |multiplier: usize, modulus: usize| {
                ((place * multiplier) % modulus) as f64 - 0.4 * modulus as f64
            };
            [
                spread(7919, 13),
                if rough { spread(104_729, 11) } else { 0.0 },
            ]
        })
        .collect();
    let mut eigenvalue = 1.0;
    for _ in 0..POWER_ITERATIONS {
        let length = vector
            .iter()
            .map(|v| v[0] * v[0] + v[1] * v[1])
            .sum::<f64>()
            .sqrt();
        for body in &mut bodies {
            body.velocity = [0.0; 2];
            body.surface_speed = 0.0;
        }
        for (contact, value) in system.contacts.iter().zip(&mut vector) {
            *value = [value[0] / length, value[1] / length];
            let [k, k_t] = [contact.normal_mass.sqrt(), contact.tangential_mass.sqrt()];
            push(&mut bodies, contact, [value[0] * k, value[1] * k_t]);
        }
        eigenvalue = 0.0;
        for (contact, value) in system.contacts.iter().zip(&mut vector) {
            let mut still = *contact;
            still.closing_speed = 0.0;
            let (one, two) = (
                &bodies[contact.first as usize],
                &bodies[contact.second as usize],
            );
            let speed = crate::delassus::relative_speed(one, two, &still);
            let image = [
                speed[0] * contact.normal_mass.sqrt(),
                if rough {
                    speed[1] * contact.tangential_mass.sqrt()
                } else {
                    0.0
                },
            ];
            eigenvalue += image[0] * value[0] + image[1] * value[1];
            *value = image;
        }
    }
    eigenvalue.max(1.0)
}
