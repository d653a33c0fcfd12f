//! Which contacts may act before the end of a step.
//!
//! A pair is a candidate when
//!
//! ```text
//!   gap + min(0, T n·(v_i − v_j)) < push (r_i + r_j)                                      (M1)
//! ```
//!
//! with the velocities v that the grains would have after the rest T of the step without contacts. The gap of two
//! balls is a convex function of the time along straight paths, so nothing else can touch as long as
//!
//! ```text
//!   |x_i − X_i − t v_i| ≤ push r_i   for every grain                                      (M2)
//! ```
//!
//! X where it was when candidates were looked for. That is watched in every sub-step; where it fails they are looked
//! for again.

use std::collections::BTreeMap;

use space::vector::from_fn;
use space::{Dim, Dimension, Period, Vector, dot, norm, periodic};

use crate::contact::impulses::Key;
use crate::contact::pairs::{Margin, direction, mean_velocity, not_above, sort};
use crate::error::Error;
use crate::grains::Grains;
use crate::search::neighbours::Neighbours;
use crate::search::place::Place;
use crate::step::sub_steps::of_meeting;

/// Distance from its straight path that a grain is allowed, of its radius: in space less, as a ball has more neighbours.
pub const fn push<const D: usize>() -> f64 {
    if D == 2 { 0.2 } else { 0.1 }
}

/// A contact that may act.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    /// Which.
    pub key: Key,
    /// Number of the shift by whole periods from the first to the second.
    pub shift: u32,
}

/// What was found.
#[derive(Debug)]
pub struct Found<const D: usize> {
    /// Velocities that the grains were thought to have \[m/s\].
    pub velocity: Vec<Vector<D>>,
    /// The contacts, sorted by key.
    pub near: Vec<Near>,
    /// What a shift adds to the first position less the second \[m\]; number 0 is none.
    pub shifts: Vec<Vector<D>>,
    /// Sub-steps that the motion asks for until the end of the step.
    pub needed: f64,
    /// Largest overlap, of the smaller radius.
    pub overlap: f64,
}

/// Shifts by whole periods, numbered as they come.
#[derive(Debug)]
struct Shifts<const D: usize> {
    period: Period<D>,
    known: BTreeMap<[i64; D], u32>,
    vectors: Vec<Vector<D>>,
}

impl<const D: usize> Shifts<D> {
    fn new(period: Period<D>) -> Shifts<D> {
        Shifts {
            period,
            known: BTreeMap::from([([0; D], 0)]),
            vectors: vec![Vector::zeros()],
        }
    }

    /// Number of the shift that makes `image` of `apart`.
    fn number(&mut self, apart: &Vector<D>, image: &Vector<D>) -> u32 {
        if !periodic::is_periodic(&self.period) {
            return 0;
        }
        let whole = std::array::from_fn(|axis| {
            let length = self.period[axis].unwrap_or(f64::INFINITY);
            ((image[axis] - apart[axis]) / length).round() as i64
        });
        if let Some(&number) = self.known.get(&whole) {
            return number;
        }
        let number = self.vectors.len() as u32;
        self.known.insert(whole, number);
        let vector = |axis: usize| whole[axis] as f64 * self.period[axis].unwrap_or(0.0);
        self.vectors.push(from_fn(vector));
        number
    }
}

/// Look for contacts of the grains of `place` within the time `rest` \[s\] at these velocities.
pub fn find<const D: usize>(
    neighbours: &mut Neighbours<D>,
    place: &Place<'_, D>,
    velocity: Vec<Vector<D>>,
    rest: f64,
) -> Result<Found<D>, Error>
where
    Dim<D>: Dimension<D>,
{
    let grains = place.grains;
    let push: Vec<f64> = grains
        .radius
        .iter()
        .map(|radius| push::<D>() * radius)
        .collect();
    let margin = Margin {
        dt: rest,
        free_velocity: &velocity,
        push: &push,
    };
    let mut found = Found {
        velocity: Vec::new(),
        near: Vec::new(),
        shifts: Vec::new(),
        needed: 1.0,
        overlap: 0.0,
    };
    let mut shifts = Shifts::new(place.period);
    of_grains(neighbours, place, &margin, &mut shifts, &mut found)?;
    not_above::<D>(found.near.len(), grains.count(), false)?;
    of_walls(neighbours, place, &margin, &mut shifts, &mut found);
    not_above::<D>(found.near.len(), grains.count(), true)?;
    found.near = sort(found.near, grains.count(), |near| near.key);
    found.shifts = shifts.vectors;
    found.velocity = velocity;
    Ok(found)
}

fn of_grains<const D: usize>(
    neighbours: &mut Neighbours<D>,
    place: &Place<'_, D>,
    margin: &Margin<'_, D>,
    shifts: &mut Shifts<D>,
    found: &mut Found<D>,
) -> Result<(), Error>
where
    Dim<D>: Dimension<D>,
{
    let Grains { radius, fixed, .. } = place.grains;
    neighbours.for_each_pair(place, &margin.reach(place.grains), |i, j, apart, image| {
        if fixed[i] && fixed[j] {
            return;
        }
        let size = radius[i] + radius[j];
        let (normal, distance) = direction(&apart, size, i, j);
        let moved = (margin.free_velocity[i] - margin.free_velocity[j]) * margin.dt;
        let gap = distance - size;
        if gap + dot(&moved, &normal).min(0.0) >= push::<D>() * size {
            return;
        }
        let smaller = radius[i].min(radius[j]);
        found.overlap = found.overlap.max(-gap / smaller);
        let meeting = of_meeting(&apart, &moved, size, smaller);
        let closing = -dot(&moved, &normal);
        let head_on = if closing > gap {
            closing / smaller
        } else {
            0.0
        };
        found.needed = found.needed.max(meeting).max(head_on);
        let key = Key {
            first: i as u32,
            second: j as u32,
            image,
        };
        let shift = shifts.number(&(place.position[i] - place.position[j]), &apart);
        found.near.push(Near { key, shift });
    })
}

fn of_walls<const D: usize>(
    neighbours: &mut Neighbours<D>,
    place: &Place<'_, D>,
    margin: &Margin<'_, D>,
    shifts: &mut Shifts<D>,
    found: &mut Found<D>,
) where
    Dim<D>: Dimension<D>,
{
    let grains = place.grains;
    for grain in (0..grains.count()).filter(|&grain| !grains.fixed[grain]) {
        let (centre, radius) = (&place.position[grain], grains.radius[grain]);
        let path = margin.dt * norm(&margin.free_velocity[grain]);
        let reach = path + margin.push[grain];
        neighbours.walls_around(place, grain, reach, |feature, offset, image| {
            let key = Key {
                first: grain as u32,
                second: (grains.count() + feature) as u32,
                image,
            };
            let apart = centre - place.walls.middle(feature);
            let shift = shifts.number(&apart, &offset);
            found.near.push(Near { key, shift });
            if let Some((gap, _)) = place.walls.touched_by(feature, &offset, radius, reach) {
                found.overlap = found.overlap.max(-gap / radius);
                found.needed = found.needed.max(path / radius);
            }
        });
    }
}

/// Velocity relative to the mean, root mean square over the grains that move \[m/s\].
pub fn relative_speed<const D: usize>(grains: &Grains, velocity: &[Vector<D>]) -> f64 {
    let mean = mean_velocity(velocity, &grains.fixed);
    let moving = velocity.iter().zip(&grains.fixed);
    let moving = moving.filter(|(_, fixed)| !**fixed);
    let (sum, count) = moving.fold((0.0, 0.0), |(sum, count), (velocity, _)| {
        let own = velocity - mean;
        (sum + dot(&own, &own), count + 1.0)
    });
    (sum / f64::max(count, 1.0)).sqrt()
}
