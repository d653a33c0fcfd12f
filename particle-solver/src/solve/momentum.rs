//! Sweeps with momentum, for when plain sweeps stall: on a column of n grains plain sweeps need
//! O(n²) iterations, these O(n).
//!
//! Nesterov's momentum on the impulses with restart (Nesterov 1983; O'Donoghue and Candès 2015),
//! projected on the Coulomb cone with the normal impulse as the limit:
//!
//! ```text
//!   t⁺ = ½(1 + √(1 + 4t²)),   R̂ = Π(R + (t − 1)/t⁺ (R − R_previous))                      (A1)
//! ```

use space::{Dim, Dimension};

use crate::contact::delassus::{System, push};
use crate::contact::law::Local;
use crate::solve::sweep::sweep;

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
pub struct MomentumSweeps<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    momentum: Momentum,
    previous: Vec<Local<D>>,
    last_change: f64,
}

impl<const D: usize> MomentumSweeps<D>
where
    Dim<D>: Dimension<D>,
{
    /// Start from the present impulses.
    pub fn new(system: &System<D>) -> MomentumSweeps<D> {
        let momentum = Momentum { t: 1.0 };
        MomentumSweeps {
            momentum,
            previous: system.impulses(),
            last_change: f64::INFINITY,
        }
    }

    /// One sweep and the extrapolation after it.
    pub fn iterate(&mut self, system: &mut System<D>) {
        let change = sweep(system, 1.0);
        if change > self.last_change {
            self.momentum.t = 1.0;
        }
        self.last_change = change;
        let coefficient = self.momentum.next();
        for place in 0..system.contacts.len() {
            let swept = system.contacts[place].impulse;
            let target = extrapolate(&swept, &self.previous[place], coefficient);
            self.previous[place] = swept;
            assign(system, place, &target);
        }
    }
}

/// R + c (R − R_previous).
#[inline]
fn extrapolate<const D: usize>(now: &Local<D>, previous: &Local<D>, coefficient: f64) -> Local<D>
where
    Dim<D>: Dimension<D>,
{
    let step = now.minus(previous).times(coefficient);
    Local {
        normal: now.normal + step.normal,
        tangential: now.tangential + step.tangential,
    }
}

/// Give a contact the projection of these impulses, and the velocities their change.
#[inline]
fn assign<const D: usize>(system: &mut System<D>, place: usize, target: &Local<D>)
where
    Dim<D>: Dimension<D>,
{
    let friction = system.friction_of(&system.contacts[place]);
    let contact = &mut system.contacts[place];
    let normal = target.normal.max(0.0);
    let tangential = Dim::<D>::limited(target.tangential, friction * normal);
    let projected = Local { normal, tangential };
    let change = projected.minus(&contact.impulse);
    if change != Local::default() {
        contact.impulse = projected;
        push(&mut system.bodies, contact, &change);
    }
}
