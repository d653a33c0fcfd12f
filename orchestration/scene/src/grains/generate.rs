//! Populations placed one after the other, without overlap.

use std::path::Path;

use space::Dim;

use super::neighbours::Neighbours;
use super::table::{Grain, GrainTable};
use super::{file, place};
use crate::check::Checker;
use crate::dimensions::{Scenic, sides, words};
use crate::keys::Grains;
use crate::outline::Outline;
use crate::walls::GrainRoom;

/// Overlap of two grains that is tolerated, of the smaller radius: what a file of a previous
/// contact computation may contain.
const OVERLAP_MAX: f64 = 0.01;

/// Place every population; what cannot be placed is a problem of its key.
pub fn generate<const D: usize>(
    populations: &[Grains<D>],
    folder: &Path,
    (room, fluid): (Option<&GrainRoom<D>>, Option<&Outline<D>>),
    checker: &mut Checker<'_>,
) -> GrainTable
where
    Dim<D>: Scenic<D>,
{
    let mut table = GrainTable::default();
    let files: Vec<_> = populations
        .iter()
        .map(|grains| {
            grains
                .file
                .as_ref()
                .map(|name| file::read(&folder.join(name), grains))
        })
        .collect();
    let largest = populations
        .iter()
        .zip(&files)
        .map(|(grains, file)| match file {
            Some(Ok(rows)) => rows.iter().map(|grain| grain.radius).fold(0.0, f64::max),
            _ => grains.radius.map_or(0.0, |radius| radius.max()),
        })
        .fold(0.0, f64::max);
    let period = room.map_or([None; D], |room| room.period);
    let mut neighbours = Neighbours::new(2.0 * largest, period);
    for (index, (grains, file)) in populations.iter().zip(files).enumerate() {
        let key = format!("grains[{index}]");
        let placed = match file {
            Some(rows) => rows.map_err(|why| (format!("{key}.file"), why)),
            None => place::place(&key, grains, room, &neighbours),
        };
        match placed {
            Err((key, why)) => checker.refuse(&key, why),
            Ok(rows) => {
                let wide = too_wide(&rows, room, fluid);
                let why = wide.or_else(|| misplaced(&rows, room, &mut neighbours));
                if let Some(why) = why.or_else(|| beside(&rows, fluid?)) {
                    checker.refuse(&key, why);
                }
                rows.into_iter().for_each(|grain| table.push(grain));
            }
        }
    }
    table
}

/// The first grain that is wider than its domain or the fluid's, also where their sides are open or periodic.
fn too_wide<const D: usize>(
    rows: &[Grain<D>],
    room: Option<&GrainRoom<D>>,
    fluid: Option<&Outline<D>>,
) -> Option<String>
where
    Dim<D>: Scenic<D>,
{
    let of_room = |room: &GrainRoom<D>| -> [f64; D] {
        std::array::from_fn(|axis| room.upper[axis] - room.lower[axis])
    };
    let sides = room
        .map(of_room)
        .into_iter()
        .chain(fluid.map(Outline::size));
    let narrowest = sides.flatten().fold(f64::INFINITY, f64::min);
    let is_wide = |grain: &Grain<D>| 2.0 * grain.radius > narrowest * (1.0 + OVERLAP_MAX);
    let number = rows.iter().position(is_wide)?;
    let diameter = 2.0 * rows[number].radius;
    Some(format!(
        "grain {number} of this population is {diameter:e} m wide and the domain only {narrowest:e} m: \
         make the grain smaller or the domain larger"
    ))
}

/// The first grain that overlaps another one or lies outside; adds those before it to `neighbours`.
fn misplaced<const D: usize>(
    rows: &[Grain<D>],
    room: Option<&GrainRoom<D>>,
    neighbours: &mut Neighbours<D>,
) -> Option<String> {
    rows.iter().enumerate().find_map(|(number, grain)| {
        let why = wrong_place(grain, room, neighbours);
        neighbours.insert(&grain.position, grain.radius, grain.fixed);
        let (place, radius) = (words(&grain.position), grain.radius);
        why.map(|why| {
            format!(
                "grain {number} of this population, at {place} m with radius {radius:e} m, {why}"
            )
        })
    })
}

/// What is wrong with the place of a grain.
fn wrong_place<const D: usize>(
    grain: &Grain<D>,
    room: Option<&GrainRoom<D>>,
    neighbours: &Neighbours<D>,
) -> Option<String> {
    let allowed = OVERLAP_MAX * grain.radius;
    if let Some(overlap) = neighbours.overlap(&grain.position, grain.radius, grain.fixed, allowed) {
        return Some(format!(
            "overlaps another grain by {overlap:e} m; at most {OVERLAP_MAX} of the radius is allowed"
        ));
    }
    let side = outside(grain, room?)?;
    Some(format!("reaches beyond the {side} side of the domain"))
}

/// The first grain that is not in the fluid.
fn beside<const D: usize>(rows: &[Grain<D>], fluid: &Outline<D>) -> Option<String>
where
    Dim<D>: Scenic<D>,
{
    let number = rows
        .iter()
        .position(|grain| !fluid.contains(&grain.position))?;
    let place = words(&rows[number].position);
    Some(format!(
        "grain {number} of this population, at {place} m, is outside the fluid's domain, or in a hole \
         of it"
    ))
}

/// The side that a grain crosses; fixed grains may stand in a wall, open sides stop centres only.
fn outside<const D: usize>(grain: &Grain<D>, room: &GrainRoom<D>) -> Option<&'static str> {
    sides::<D>().iter().enumerate().find_map(|(side, name)| {
        let axis = side / 2;
        let reach = if room.sides[side].closed && !grain.fixed {
            grain.radius
        } else {
            0.0
        };
        let allowed = reach - OVERLAP_MAX * grain.radius;
        let distance = match side % 2 {
            0 => grain.position[axis] - room.lower[axis],
            _ => room.upper[axis] - grain.position[axis],
        };
        (distance < allowed).then_some(*name)
    })
}
