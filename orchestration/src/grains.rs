//! Where the grains are at t = 0: populations placed one after the other, without overlap.

mod arrange;
mod file;
mod lattice;
mod neighbours;
mod place;
mod random;

use std::fmt::Write;
use std::path::Path;

use crate::scene::check::Checker;
use crate::scene::population_keys::Grains;
use crate::scene::walls::GrainRoom;
use neighbours::Neighbours;

/// The grains of a scene, a line per array.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GrainTable {
    /// Centres \[m\].
    pub position: Vec<[f64; 2]>,
    /// Radii \[m\].
    pub radius: Vec<f64>,
    /// Densities \[kg/m³\].
    pub density: Vec<f64>,
    /// Velocities \[m/s\].
    pub velocity: Vec<[f64; 2]>,
    /// Grains that never move.
    pub fixed: Vec<bool>,
}

impl GrainTable {
    /// Number of grains.
    pub fn len(&self) -> usize {
        self.radius.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.radius.is_empty()
    }

    /// Is there a grain, and does none move?
    pub fn all_fixed(&self) -> bool {
        !self.is_empty() && self.fixed.iter().all(|&fixed| fixed)
    }

    /// Area of all disks \[m²\].
    pub fn area(&self) -> f64 {
        self.radius
            .iter()
            .map(|radius| std::f64::consts::PI * radius * radius)
            .sum()
    }

    /// The table as CSV: x,y,radius,density,vx,vy,fixed; numbers read back to the same bits.
    pub fn to_csv(&self) -> String {
        let mut text = String::from("x,y,radius,density,vx,vy,fixed\n");
        for index in 0..self.len() {
            let ([x, y], [vx, vy]) = (self.position[index], self.velocity[index]);
            let (radius, density) = (self.radius[index], self.density[index]);
            let fixed = u8::from(self.fixed[index]);
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{x:e},{y:e},{radius:e},{density:e},{vx:e},{vy:e},{fixed}"
            );
        }
        text
    }

    fn push(&mut self, grain: Grain) {
        self.position.push(grain.position);
        self.radius.push(grain.radius);
        self.density.push(grain.density);
        self.velocity.push(grain.velocity);
        self.fixed.push(grain.fixed);
    }
}

/// One grain.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grain {
    position: [f64; 2],
    radius: f64,
    density: f64,
    velocity: [f64; 2],
    fixed: bool,
}

/// Overlap of two grains that is tolerated, of the smaller radius: what a file of a previous
/// contact computation may contain.
const OVERLAP_MAX: f64 = 0.01;

/// Place every population; what cannot be placed is a problem of its key.
pub fn generate(
    populations: &[Grains],
    folder: &Path,
    room: Option<&GrainRoom>,
    checker: &mut Checker<'_>,
) -> GrainTable {
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
    let period = room.map_or([None, None], |room| room.period);
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
                if let Some(why) = misplaced(&rows, room, &mut neighbours) {
                    checker.refuse(&key, why);
                }
                rows.into_iter().for_each(|grain| table.push(grain));
            }
        }
    }
    table
}

/// The first grain that overlaps another one or lies outside; adds the grains to `neighbours`.
fn misplaced(
    rows: &[Grain],
    room: Option<&GrainRoom>,
    neighbours: &mut Neighbours,
) -> Option<String> {
    let mut first = None;
    for (number, grain) in rows.iter().enumerate() {
        let [x, y] = grain.position;
        let overlap = neighbours.deepest_overlap(grain.position, grain.radius, grain.fixed);
        if first.is_none() && overlap > OVERLAP_MAX * grain.radius {
            let radius = grain.radius;
            first = Some(format!(
                "grain {number} of this population, at ({x:e}, {y:e}) m with radius {radius:e} m, \
                 overlaps another grain by {overlap:e} m; at most {OVERLAP_MAX} of the radius is allowed"
            ));
        }
        if let (None, Some(room)) = (&first, room)
            && let Some(side) = outside(grain, room)
        {
            let radius = grain.radius;
            first = Some(format!(
                "grain {number} of this population, at ({x:e}, {y:e}) m with radius {radius:e} m, \
                 reaches beyond the {side} side of the domain"
            ));
        }
        neighbours.insert(grain.position, grain.radius, grain.fixed);
    }
    first
}

/// The side that a grain crosses; fixed grains may stand in a wall, open sides stop centres only.
fn outside(grain: &Grain, room: &GrainRoom) -> Option<&'static str> {
    let sides = crate::scene::boundaries::SIDES;
    (0..4).find_map(|side| {
        let axis = side / 2;
        let reach = if room.closed[side] && !grain.fixed {
            grain.radius
        } else {
            0.0
        };
        let allowed = reach - OVERLAP_MAX * grain.radius;
        let distance = match side % 2 {
            0 => grain.position[axis] - room.lower[axis],
            _ => room.upper[axis] - grain.position[axis],
        };
        (distance < allowed).then_some(sides[side])
    })
}
