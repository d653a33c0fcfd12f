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

use space::grid::Grid;
use space::{Dim, Dimension, Linear, Vector, dot, norm};

use crate::contact::pairs::Margin;
use crate::error::Error;
use crate::search::neighbours::{Neighbours, limited};
use crate::search::place::Place;

/// Artificial gap allowed for the worst pair in a sub-step, of the smaller radius.
const OPENING: f64 = 1e-2;
/// Pairs closer than this part of R count as touching, whatever their velocity.
const TOUCHING: f64 = 0.02;
/// Distances a grain that the search may cost in the plane; more and it looks less far ahead.
const WORK_MAX: f64 = 100.0;
/// As many times that in space.
const WORK_OF_SPACE: f64 = 13.5;
/// Parts of the step that the search may be cut into.
const PARTS_MAX: f64 = 64.0;

/// The count, at least 1; an error above `sub_steps_max`.
pub fn count<const D: usize>(
    neighbours: &mut Neighbours<D>,
    place: &Place<'_, D>,
    free_velocity: &[Vector<D>],
    dt: f64,
    sub_steps_max: u32,
) -> Result<u32, Error>
where
    Dim<D>: Dimension<D>,
{
    if place.grains.fixed.iter().all(|&fixed| fixed) {
        return Ok(1);
    }
    let (reach, grid, parts) = search(neighbours, place, free_velocity, dt)?;
    let mut worst = Worst {
        needed: parts,
        pair: (0, 0),
    };
    let between = |i: usize, j: usize, apart: Vector<D>, _| {
        worst.grains(place, free_velocity, dt, (i, j), &apart);
    };
    match grid {
        Some(grid) => limited(&grid, place.grains.count(), between)?,
        None => neighbours.for_each_pair(place, &reach, between)?,
    }
    worst.walls(neighbours, place, free_velocity, dt);
    let needed = worst.needed.ceil().max(1.0);
    if needed > f64::from(sub_steps_max) {
        let (first, second) = worst.pair;
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

/// The pair that needs most sub-steps.
struct Worst {
    needed: f64,
    pair: (usize, usize),
}

impl Worst {
    fn note(&mut self, needed: f64, first: usize, second: usize) {
        if needed > self.needed {
            (self.needed, self.pair) = (needed, (first, second));
        }
    }

    /// Look at two grains.
    fn grains<const D: usize>(
        &mut self,
        place: &Place<'_, D>,
        free_velocity: &[Vector<D>],
        dt: f64,
        (i, j): (usize, usize),
        apart: &Vector<D>,
    ) where
        Dim<D>: Dimension<D>,
    {
        let grains = place.grains;
        if grains.fixed[i] && grains.fixed[j] {
            return;
        }
        let moved = (free_velocity[i] - free_velocity[j]) * dt;
        let (r_i, r_j) = (grains.radius[i], grains.radius[j]);
        let needed = of_meeting(apart, &moved, r_i + r_j, r_i.min(r_j));
        self.note(needed, i, j);
    }

    /// Look at all grains and the walls that they may meet.
    fn walls<const D: usize>(
        &mut self,
        neighbours: &mut Neighbours<D>,
        place: &Place<'_, D>,
        free_velocity: &[Vector<D>],
        dt: f64,
    ) where
        Dim<D>: Dimension<D>,
    {
        let grains = place.grains;
        for grain in (0..grains.count()).filter(|&grain| !grains.fixed[grain]) {
            let moved = free_velocity[grain] * dt;
            let radius = grains.radius[grain];
            neighbours.walls_near(place, grain, norm(&moved), |wall| {
                let needed = match wall.over {
                    Some(over) if wall.gap + dot(&moved, &wall.normal) < 0.0 => {
                        of_leaving(&moved, &wall.normal, over.leaves(&moved), radius)
                    }
                    Some(_) => 0.0,
                    None => {
                        let apart = wall.normal * (radius + wall.gap);
                        of_meeting(&apart, &moved, radius, radius)
                    }
                };
                self.note(needed, grain, grains.count() + wall.feature);
            });
        }
    }
}

/// Reach and cells for everything that may meet within the step, or within the part of it that the
/// work allows, and the number of such parts; no cells where what is known of the neighbours will do.
fn search<const D: usize>(
    neighbours: &mut Neighbours<D>,
    place: &Place<'_, D>,
    free_velocity: &[Vector<D>],
    dt: f64,
) -> Result<(Vec<f64>, Option<Grid<D>>, f64), Error>
where
    Dim<D>: Dimension<D>,
{
    let grains = place.grains;
    let push: Vec<f64> = grains
        .radius
        .iter()
        .map(|radius| TOUCHING * radius)
        .collect();
    let work_max = WORK_MAX * WORK_OF_SPACE.powi(D as i32 - 2);
    let mut parts = 1.0;
    loop {
        let margin = Margin {
            dt: dt / parts,
            free_velocity,
            push: &push,
        };
        let reach = margin.reach(grains);
        if parts == 1.0 && neighbours.replaces_limited_search(place, &reach)? {
            return Ok((reach, None, parts));
        }
        neighbours.searches += 1;
        let grid = Grid::build(place.position, &reach, &place.period);
        if grid.works_within(work_max * grains.count() as f64) || parts >= PARTS_MAX {
            return Ok((reach, Some(grid), parts));
        }
        parts *= 2.0;
    }
}

/// Sub-steps for a pair `apart` whose relative displacement over the step is `moved`.
pub fn of_meeting<const D: usize>(
    apart: &Vector<D>,
    moved: &Vector<D>,
    size: f64,
    smaller: f64,
) -> f64
where
    Dim<D>: Dimension<D>,
{
    let path = norm(moved);
    if path == 0.0 {
        return 0.0;
    }
    let distance = norm(apart);
    let approach = -dot(apart, moved) / (path * path);
    let across = Dim::<D>::cross_length(apart, moved) / path;
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
    let closest = norm(&(apart + moved * approach.min(1.0)));
    let by_hit = if across > 0.0 {
        hit * size / across
    } else {
        f64::INFINITY
    };
    let by_miss = (2.0 * closest * (closest - size).max(0.0)).sqrt();
    path / by_hit.max(by_miss)
}

/// Sub-steps for a grain that reaches a face and may leave it over an end within the step.
fn of_leaving<const D: usize>(
    moved: &Vector<D>,
    normal: &Vector<D>,
    leaves: bool,
    radius: f64,
) -> f64
where
    Dim<D>: Dimension<D>,
{
    if leaves {
        Dim::<D>::tangential(moved, normal).length() / (0.25 * radius)
    } else {
        0.0
    }
}
