//! How many sub-steps a step needs, from relative motion and neighbour gaps.
//!
//! The contact law keeps the normal of the start of a sub-step. That is exact for motion along
//! the normal; a relative displacement w across it opens an artificial gap w²/(2R), R = r_i + r_j,
//! and a pair that passes by may be stopped by the tangent line of a grain it misses. Over the
//! step the free velocities bring a pair within b of each other, on a line at distance p:
//!
//! ```text
//!   w ≤ w_hit R/p,   w_hit² = 2 R ε r,   ε = 1e-2       a hit (equal grains: w ≤ 0.2 r)      (N1)
//!   w² ≤ 2 b (b − R)                                     a miss is not stopped                (N2)
//! ```
//!
//! The larger of the two is allowed; the count is the largest |u|Δt/w. Only velocities relative
//! to each other enter. A straight wall has no curvature and asks for nothing, except where a
//! grain may leave its end: there the motion along it is limited to r/4 a sub-step.

use crate::contact::Margin;
use crate::detect::Grid;
use crate::error::Error;
use crate::neighbours::{Neighbours, Place};
use crate::vector::{Vector, add, cross, dot, left, norm, scale, sub};

/// Artificial gap allowed for the worst pair in a sub-step, of the smaller radius.
const OPENING: f64 = 1e-2;
/// Pairs closer than this part of R count as touching, whatever their velocity.
const TOUCHING: f64 = 0.02;
/// Distances a grain that the search may cost; more and the search looks less far ahead.
const WORK_MAX: f64 = 100.0;
/// Parts of the step that the search may be cut into.
const PARTS_MAX: f64 = 64.0;

/// The count, at least 1; an error above `sub_steps_max`.
pub fn count(
    neighbours: &mut Neighbours,
    place: &Place<'_>,
    free_velocity: &[Vector],
    dt: f64,
    sub_steps_max: u32,
) -> Result<u32, Error> {
    let grains = place.grains;
    if grains.fixed.iter().all(|&fixed| fixed) {
        return Ok(1);
    }
    let (reach, grid, mut worst) = search(neighbours, place, free_velocity, dt);
    let mut pair = (0, 0);
    let mut ask = |needed: f64, first: usize, second: usize| {
        if needed > worst {
            (worst, pair) = (needed, (first, second));
        }
    };
    let mut look = |i: usize, j: usize, apart: Vector, _| {
        if !(grains.fixed[i] && grains.fixed[j]) {
            let relative = sub(free_velocity[i], free_velocity[j]);
            let (r_i, r_j) = (grains.radius[i], grains.radius[j]);
            ask(
                needed(apart, scale(dt, relative), r_i + r_j, r_i.min(r_j)),
                i,
                j,
            );
        }
    };
    match grid {
        Some(grid) => grid.for_each_pair(&mut look),
        None => neighbours.for_each_pair(place, &reach, &mut look),
    }
    for grain in (0..grains.count()).filter(|&grain| !grains.fixed[grain]) {
        let moved = scale(dt, free_velocity[grain]);
        let radius = grains.radius[grain];
        neighbours.walls_near(place, grain, norm(moved), |wall| {
            let needed = match wall.along {
                Some(along) => leaving(moved, wall.normal, wall.gap, along, radius),
                None => needed(scale(radius + wall.gap, wall.normal), moved, radius, radius),
            };
            ask(needed, grain, grains.count() + wall.feature);
        });
    }
    let needed = worst.ceil().max(1.0);
    if needed > f64::from(sub_steps_max) {
        let (first, second) = pair;
        return Err(Error::SubSteps {
            needed: needed as u64,
            sub_steps_max,
            dt,
            first,
            second,
        });
    }
    Ok(needed as u32)
}

/// Reach and cells for everything that may meet within the step, or within the part of it that the
/// work allows, and the number of such parts; no cells where what is known of the neighbours will do.
fn search(
    neighbours: &mut Neighbours,
    place: &Place<'_>,
    free_velocity: &[Vector],
    dt: f64,
) -> (Vec<f64>, Option<Grid>, f64) {
    let grains = place.grains;
    let push: Vec<f64> = grains
        .radius
        .iter()
        .map(|radius| TOUCHING * radius)
        .collect();
    let mut parts = 1.0;
    loop {
        let margin = Margin {
            dt: dt / parts,
            free_velocity,
            push: &push,
        };
        let reach = margin.reach(grains);
        if parts == 1.0 && neighbours.stand_for_search(place, &reach) {
            return (reach, None, parts);
        }
        neighbours.searches += 1;
        let grid = Grid::build(place.position, &reach, place.period);
        if grid.work() <= WORK_MAX * grains.count() as f64 || parts >= PARTS_MAX {
            return (reach, Some(grid), parts);
        }
        parts *= 2.0;
    }
}

/// Sub-steps for a pair `apart` whose relative displacement over the step is `moved`.
fn needed(apart: Vector, moved: Vector, size: f64, smaller: f64) -> f64 {
    let path = norm(moved);
    if path == 0.0 {
        return 0.0;
    }
    let distance = norm(apart);
    let approach = -dot(apart, moved) / (path * path);
    let across = (cross(apart, moved) / path).abs();
    let hit = (2.0 * size * OPENING * smaller).sqrt();
    if distance < (1.0 + TOUCHING) * size {
        let sideways = if distance > 0.0 {
            path * across / distance
        } else {
            path
        };
        return if approach < 0.0 && sideways < path * 0.5 {
            0.0
        } else {
            sideways / hit
        };
    }
    if approach <= 0.0 {
        return 0.0;
    }
    let closest = norm(add(apart, scale(approach.min(1.0), moved)));
    let by_hit = if across > 0.0 {
        hit * size / across
    } else {
        f64::INFINITY
    };
    let by_miss = (2.0 * closest * (closest - size).max(0.0)).sqrt();
    path / by_hit.max(by_miss)
}

/// Sub-steps for a grain that may reach a face and leave it over an end within the step.
fn leaving(moved: Vector, normal: Vector, gap: f64, along: [f64; 2], radius: f64) -> f64 {
    let reaches = gap + dot(moved, normal) < 0.0;
    // The tangent of a wall is its normal turned to the right.
    let forward = -dot(moved, left(normal));
    let beyond = forward > along[1] || -forward > along[0];
    if reaches && beyond {
        forward.abs() / (0.25 * radius)
    } else {
        0.0
    }
}
