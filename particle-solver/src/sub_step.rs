//! The contacts of one sub-step: find, solve, and look again when contacts pushed too far.
//!
//! Candidates are found at the start of the sub-step only. The margin is the displacement by
//! contacts that is allowed for (`contact::Margin`); a first guess comes from the forces and from
//! the pairs that approach each other, and whoever is pushed beyond it gets a larger one.

use crate::contact::{Candidate, Impulses, Margin, candidates};
use crate::delassus::{Loads, System};
use crate::error::Error;
use crate::grains::{Grains, State};
use crate::neighbours::{Neighbours, Place};
use crate::solve::{Goal, Outcome, solve};
use crate::vector::{Vector, dot, norm, sub};
use crate::walls::Walls;

/// Times the margin may be enlarged.
const ATTEMPTS_MAX: usize = 30;
/// Smallest and largest margin of the first attempt, of the radius.
const PUSH: [f64; 2] = [0.02, 0.1];
/// Head room over what is known to be needed.
const HEAD_ROOM: f64 = 1.25;

/// What a sub-step does not change.
#[derive(Debug, Clone, Copy)]
pub struct Stage<'a> {
    /// Grains.
    pub grains: &'a Grains,
    /// Walls.
    pub walls: &'a Walls,
    /// Period in x and y \[m\].
    pub period: [Option<f64>; 2],
    /// μ between grains, and between grains and walls.
    pub friction: [f64; 2],
    /// I/(m r²).
    pub inertia_factor: f64,
    /// Residual wished for.
    pub tolerance: f64,
    /// Residual without which a solve has failed.
    pub required: f64,
    /// Sweeps allowed.
    pub sweeps_max: usize,
}

/// A solved contact problem.
#[derive(Debug)]
pub struct Solved {
    /// Bodies with their velocities, contacts with their impulses.
    pub system: System,
    /// The candidates, in the order of the contacts.
    pub pairs: Vec<Candidate>,
    /// Residual, convergence, and the sweeps of all attempts.
    pub outcome: Outcome,
    /// Contact problems solved.
    pub attempts: usize,
}

/// Solve the contacts of a sub-step from `state`, starting from its impulses. Not converged is
/// for the caller to judge.
pub fn solve_contacts(
    stage: &Stage<'_>,
    neighbours: &mut Neighbours,
    state: &State,
    loads: &Loads<'_>,
) -> Result<Solved, Error> {
    let grains = stage.grains;
    let free = loads.free_velocity(grains, &state.velocity);
    let surface: Vec<f64> = (0..grains.count())
        .map(|grain| grains.radius[grain] * state.spin[grain])
        .collect();
    let mut push = first_push(grains, &free, &state.velocity, loads.dt);
    let place = Place {
        grains,
        position: &state.position,
        walls: stage.walls,
        period: stage.period,
    };
    let mut find = |push: &[f64]| {
        let margin = Margin {
            dt: loads.dt,
            free_velocity: &free,
            push,
        };
        candidates(neighbours, &place, &margin)
    };
    let mut pairs = find(&push);
    if allow_for_impacts(&pairs, &free, loads.dt, &mut push) {
        pairs = find(&push);
    }
    let mut warm = None;
    let mut sweeps = 0;
    let mut last = (0, 0.0, 0.0);
    for attempts in 1..=ATTEMPTS_MAX {
        let mut system = System::assemble(stage, loads, &free, &surface, &pairs);
        system.weigh(grains, loads, &state.velocity);
        let recalled = warm
            .as_ref()
            .unwrap_or(&state.impulses)
            .recall(&pairs, loads.dt);
        let goal = Goal {
            wished: stage.tolerance,
            required: stage.required,
        };
        let mut outcome = solve(&mut system, &recalled, goal, stage.sweeps_max);
        sweeps += outcome.sweeps;
        outcome.sweeps = sweeps;
        let pushed = enlarge(&system, &free, loads.dt, &mut push);
        let Some(pushed) = pushed.filter(|_| outcome.converged) else {
            return Ok(Solved {
                system,
                pairs,
                outcome,
                attempts,
            });
        };
        last = pushed;
        warm = Some(impulses(&system, &pairs, loads.dt));
        pairs = find(&push);
    }
    let (grain, moved, margin) = last;
    Err(Error::Margin {
        grain,
        moved,
        margin,
        attempts: ATTEMPTS_MAX,
    })
}

/// The impulses that act, by key.
pub fn impulses(system: &System, pairs: &[Candidate], dt: f64) -> Impulses {
    let entries = pairs
        .iter()
        .zip(&system.contacts)
        .filter(|(_, contact)| contact.normal_impulse > 0.0)
        .map(|(pair, contact)| (pair.key, contact.normal_impulse, contact.tangential_impulse))
        .collect();
    Impulses { dt, entries }
}

/// What forces would do, were contacts to undo it.
fn first_push(grains: &Grains, free: &[Vector], velocity: &[Vector], dt: f64) -> Vec<f64> {
    (0..grains.count())
        .map(|grain| {
            if grains.fixed[grain] {
                return 0.0;
            }
            let gained = dt * norm(sub(free[grain], velocity[grain]));
            let [least, most] = PUSH.map(|part| part * grains.radius[grain]);
            (HEAD_ROOM * gained).clamp(least, most)
        })
        .collect()
}

/// Allow for what approaching pairs would overlap; true when that is more than before.
fn allow_for_impacts(pairs: &[Candidate], free: &[Vector], dt: f64, push: &mut [f64]) -> bool {
    let mut raised = false;
    for pair in pairs {
        let (first, second) = (pair.key.first as usize, pair.key.second as usize);
        let other = free.get(second).copied().unwrap_or_default();
        let overlap = -pair.gap.max(0.0) - dt * dot(sub(free[first], other), pair.normal);
        for grain in [first, second] {
            // A margin of 0 belongs to a fixed grain.
            if let Some(push) = push.get_mut(grain).filter(|push| **push > 0.0)
                && HEAD_ROOM * overlap > *push
            {
                *push = HEAD_ROOM * overlap;
                raised = true;
            }
        }
    }
    raised
}

/// Enlarge the margin of grains pushed beyond it; the worst of them (grain, moved, margin).
fn enlarge(
    system: &System,
    free: &[Vector],
    dt: f64,
    push: &mut [f64],
) -> Option<(usize, f64, f64)> {
    let mut worst: Option<(usize, f64, f64)> = None;
    for (grain, push) in push.iter_mut().enumerate() {
        let moved = dt * norm(sub(system.bodies[grain].velocity, free[grain]));
        if moved > *push {
            if worst.is_none_or(|(_, most, margin)| moved - *push > most - margin) {
                worst = Some((grain, moved, *push));
            }
            *push = HEAD_ROOM * moved;
        }
    }
    worst
}
