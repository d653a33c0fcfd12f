//! What a finished step says about contacts: who touches, who is held, how deep.

use rapier2d_f64::prelude::ContactPair;

use crate::world::{Model, World};

/// Contacts of a candidate.
#[derive(Debug, Default)]
pub struct Contacts {
    /// 0 free, 1 touches, 2 held by a wall or a fixed grain through contacts that push.
    pub state: Vec<f64>,
    /// Contacts that push.
    pub active: usize,
    /// Largest overlap, of the smaller radius.
    pub penetration: f64,
}

impl Contacts {
    /// Look at the pairs of the last sub-step.
    pub fn of(world: &World, model: &Model) -> Contacts {
        let count = model.radius.len();
        let mut found = Contacts {
            state: vec![0.0; count],
            ..Contacts::default()
        };
        let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); count];
        let mut held: Vec<usize> = (0..count).filter(|&grain| model.fixed[grain]).collect();
        for pair in world.narrow_phase.contact_pairs() {
            let [i, j] = ends(world, pair);
            found.penetration = found.penetration.max(overlap(world, model, i, j));
            if pair.total_impulse_magnitude() <= 0.0 {
                continue;
            }
            found.active += 1;
            match (i < count, j < count) {
                (true, true) => {
                    neighbours[i].push(j);
                    neighbours[j].push(i);
                }
                (true, false) => held.push(i),
                (false, true) => held.push(j),
                (false, false) => {}
            }
        }
        for (grain, touching) in neighbours.iter().enumerate() {
            found.state[grain] = f64::from(u8::from(!touching.is_empty()));
        }
        while let Some(grain) = held.pop() {
            if found.state[grain] < 2.0 {
                found.state[grain] = 2.0;
                held.extend(&neighbours[grain]);
            }
        }
        found
    }
}

/// Grains (below the number of grains) or walls of a pair.
fn ends(world: &World, pair: &ContactPair) -> [usize; 2] {
    [pair.collider1, pair.collider2].map(|handle| world.colliders[handle].user_data as usize)
}

/// Overlap of two grains, or of a grain and a wall, of the smaller radius; negative when apart.
fn overlap(world: &World, model: &Model, i: usize, j: usize) -> f64 {
    let count = model.radius.len();
    let apart = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
    let (grain, other) = (i.min(j), i.max(j));
    if grain >= count {
        return 0.0;
    }
    let (at, radius) = (world.position(grain), model.radius[grain]);
    if other < count {
        let size = radius + model.radius[other];
        return (size - apart(at, world.position(other))) / radius.min(model.radius[other]);
    }
    let wall = &model.walls[other - count];
    let along = [wall.b[0] - wall.a[0], wall.b[1] - wall.a[1]];
    let from = [at[0] - wall.a[0], at[1] - wall.a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let share = ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0);
    let nearest = [wall.a[0] + share * along[0], wall.a[1] + share * along[1]];
    (radius - apart(at, nearest)) / radius
}

/// The first grain that crossed a wall from one place to another, and the wall.
pub fn crossing(model: &Model, before: &[f64], after: &[f64]) -> Option<(usize, usize)> {
    let side = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    let place = |of: &[f64], grain: usize| [of[2 * grain], of[2 * grain + 1]];
    (0..model.radius.len()).find_map(|grain| {
        let (p, q) = (place(before, grain), place(after, grain));
        let crosses = |wall: &crate::world::Segment| {
            let (a, b) = (wall.a, wall.b);
            side(a, b, p) >= 0.0
                && side(a, b, q) < 0.0
                && (side(p, q, a) > 0.0) != (side(p, q, b) > 0.0)
        };
        model
            .walls
            .iter()
            .position(crosses)
            .map(|wall| (grain, wall))
    })
}
