//! The contacts of one sub-step: find, solve, and look again when contacts pushed too far.
//!
//! Candidates are found at the start of the sub-step only. The margin is the displacement by
//! contacts that is allowed for (`pairs::Margin`); a first guess comes from the forces and from
//! the pairs that approach each other, and whoever is pushed beyond it gets a larger one.

use space::{Dim, Dimension, Period, Vector, dot, norm};

use crate::contact::delassus::{Material, System};
use crate::contact::impulses::{Impulses, Key, Pair};
use crate::contact::loads::Loads;
use crate::contact::pairs::{Margin, pairs};
use crate::error::Error;
use crate::grains::{Grains, State};
use crate::search::neighbours::Neighbours;
use crate::search::place::Place;
use crate::solve::schedule::{Goal, Outcome, solve};
use crate::walls::near::Walls;

/// Times the margin may be enlarged.
const ATTEMPTS_MAX: usize = 30;
/// Smallest margin of the first attempt, of the radius.
const PUSH_LEAST: f64 = 0.02;
/// Largest one.
const PUSH_MOST: f64 = 0.1;
/// Head room over what is known to be needed.
const HEAD_ROOM: f64 = 1.25;

/// What a sub-step does not change.
#[derive(Debug, Clone, Copy)]
pub struct Stage<'a, const D: usize> {
    /// Grains.
    pub grains: &'a Grains,
    /// Walls.
    pub walls: &'a Walls<D>,
    /// Period along each axis \[m\].
    pub period: Period<D>,
    /// What contacts are made of.
    pub material: Material,
    /// Residual wished for, and the one without which a solve has failed.
    pub goal: Goal,
    /// Sweeps allowed.
    pub sweeps_max: usize,
}

impl<'a, const D: usize> Stage<'a, D> {
    /// The grains at these positions \[m\].
    pub fn place(&self, position: &'a [Vector<D>]) -> Place<'a, D> {
        Place {
            grains: self.grains,
            position,
            walls: self.walls,
            period: self.period,
        }
    }
}

/// A solved contact problem.
#[derive(Debug)]
pub struct Solved<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// Bodies with their velocities, contacts with their impulses.
    pub system: System<D>,
    /// The pairs, in the order of the contacts.
    pub pairs: Vec<Pair<D>>,
    /// Residual, convergence, and the sweeps of all attempts.
    pub outcome: Outcome,
    /// Contact problems solved.
    pub attempts: usize,
}

/// Solve the contacts of a sub-step from `state`, starting from its impulses. Not converged is
/// for the caller to judge.
pub fn solve_contacts<const D: usize>(
    stage: &Stage<'_, D>,
    neighbours: &mut Neighbours<D>,
    state: &State<D>,
    loads: &Loads<'_, D>,
) -> Result<Solved<D>, Error>
where
    Dim<D>: Dimension<D>,
{
    let free = loads.free_motion(stage.grains, state);
    let mut find = |push: &[f64]| {
        let margin = Margin {
            dt: loads.dt,
            free_velocity: &free.velocity,
            push,
        };
        pairs(neighbours, &stage.place(&state.position), &margin)
    };
    let mut push = first_push(stage.grains, &free.velocity, &state.velocity, loads.dt);
    let mut pairs = find(&push)?;
    if allow_for_impacts(&pairs, &free.velocity, loads.dt, &mut push) {
        pairs = find(&push)?;
    }
    let mut start = state.impulses.recall(keys(&pairs), loads.dt);
    let mut sweeps = 0;
    let mut last = Pushed::default();
    for attempts in 1..=ATTEMPTS_MAX {
        let touching = (&pairs[..], stage.walls.grounds());
        let mut system = System::assemble(stage.grains, &stage.material, loads, &free, touching);
        system.set_weights(stage.grains, loads, &state.velocity);
        let mut outcome = solve(&mut system, &start, stage.goal, stage.sweeps_max);
        sweeps += outcome.sweeps;
        outcome.sweeps = sweeps;
        let pushed = enlarge(&system, &free.velocity, loads.dt, &mut push);
        let Some(pushed) = pushed.filter(|_| outcome.converged) else {
            return Ok(Solved {
                system,
                pairs,
                outcome,
                attempts,
            });
        };
        last = pushed;
        let solved = impulses(&system, &pairs, loads.dt);
        pairs = find(&push)?;
        start = solved.recall(keys(&pairs), loads.dt);
    }
    Err(last.error())
}

/// Which contacts they are.
fn keys<const D: usize>(pairs: &[Pair<D>]) -> impl Iterator<Item = Key> {
    pairs.iter().map(|pair| pair.key)
}

/// The impulses that act, by key.
pub fn impulses<const D: usize>(system: &System<D>, pairs: &[Pair<D>], dt: f64) -> Impulses<D>
where
    Dim<D>: Dimension<D>,
{
    let entries = pairs
        .iter()
        .zip(&system.contacts)
        .filter(|(_, contact)| contact.impulse.normal > 0.0)
        .map(|(pair, contact)| (pair.key, contact.impulse))
        .collect();
    Impulses { dt, entries }
}

/// What forces would do, were contacts to undo it.
fn first_push<const D: usize>(
    grains: &Grains,
    free: &[Vector<D>],
    velocity: &[Vector<D>],
    dt: f64,
) -> Vec<f64> {
    (0..grains.count())
        .map(|grain| {
            if grains.fixed[grain] {
                return 0.0;
            }
            let gained = dt * norm(&(free[grain] - velocity[grain]));
            let radius = grains.radius[grain];
            (HEAD_ROOM * gained).clamp(PUSH_LEAST * radius, PUSH_MOST * radius)
        })
        .collect()
}

/// Allow for what approaching pairs would overlap; true when that is more than before.
fn allow_for_impacts<const D: usize>(
    pairs: &[Pair<D>],
    free: &[Vector<D>],
    dt: f64,
    push: &mut [f64],
) -> bool {
    let mut raised = false;
    for pair in pairs {
        let (first, second) = (pair.key.first as usize, pair.key.second as usize);
        let other = free.get(second).copied().unwrap_or_else(Vector::zeros);
        let overlap = -pair.gap.max(0.0) - dt * dot(&(free[first] - other), &pair.normal);
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

/// A grain that contacts pushed beyond its margin.
#[derive(Debug, Clone, Copy, Default)]
struct Pushed {
    grain: usize,
    /// How far \[m\].
    moved: f64,
    /// How far it was allowed to be \[m\].
    margin: f64,
}

impl Pushed {
    fn error(&self) -> Error {
        Error::Margin {
            grain: self.grain,
            moved: self.moved,
            margin: self.margin,
            attempts: ATTEMPTS_MAX,
        }
    }
}

/// Enlarge the margin of grains pushed beyond it; the worst of them.
fn enlarge<const D: usize>(
    system: &System<D>,
    free: &[Vector<D>],
    dt: f64,
    push: &mut [f64],
) -> Option<Pushed>
where
    Dim<D>: Dimension<D>,
{
    let mut worst: Option<Pushed> = None;
    for (grain, push) in push.iter_mut().enumerate() {
        let moved = dt * norm(&(system.bodies[grain].velocity - free[grain]));
        if moved > *push {
            let margin = *push;
            if worst.is_none_or(|worst| moved - margin > worst.moved - worst.margin) {
                worst = Some(Pushed {
                    grain,
                    moved,
                    margin,
                });
            }
            *push = HEAD_ROOM * moved;
        }
    }
    worst
}
