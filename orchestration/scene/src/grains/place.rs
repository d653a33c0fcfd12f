//! One population: how many grains, which radii, where.

use std::f64::consts::PI;

use super::arrange::{self, Region};
use super::lattice::Frame;
use super::neighbours::Neighbours;
use super::random::Random;
use super::table::Grain;
use crate::keys::{Arrangement, Cloud, FilledBox, Grains, Lattice, Pattern, Radius};
use crate::memory;
use crate::walls::GrainRoom;

/// Key and message of what cannot be placed.
pub type Refusal = (String, String);

/// Solid fraction above which random placing of equal disks becomes hopeless (it jams at 0.547).
const RANDOM_FRACTION_MAX: f64 = 0.5;

/// Place a population that does not come from a file.
pub fn place(
    key: &str,
    grains: &Grains,
    room: Option<&GrainRoom>,
    neighbours: &Neighbours,
) -> Result<Vec<Grain>, Refusal> {
    let missing = |what: &str| (format!("{key}.{what}"), "missing".to_string());
    let radius = grains.radius.ok_or_else(|| missing("radius"))?;
    let density = grains.density.ok_or_else(|| missing("density"))?;
    let placed = if let Some(cloud) = &grains.cloud {
        place_cloud(
            &format!("{key}.cloud"),
            cloud,
            radius,
            grains.fixed,
            neighbours,
        )?
    } else if let Some(filled) = &grains.filled_box {
        place_box(
            &format!("{key}.box"),
            filled,
            radius,
            grains.fixed,
            room,
            neighbours,
        )?
    } else if let Some(lattice) = &grains.lattice {
        place_lattice(&format!("{key}.lattice"), lattice, radius, room)?
    } else {
        Vec::new()
    };
    let (velocity, fixed) = (grains.velocity, grains.fixed);
    Ok(placed
        .into_iter()
        .map(|(position, radius)| Grain {
            position,
            radius,
            density,
            velocity,
            fixed,
        })
        .collect())
}

type Spot = ([f64; 2], f64);

fn place_cloud(
    key: &str,
    cloud: &Cloud,
    radius: Radius,
    fixed: bool,
    neighbours: &Neighbours,
) -> Result<Vec<Spot>, Refusal> {
    let mut random = Random::new(cloud.seed);
    let area = PI * cloud.radius * cloud.radius;
    let radii = radii(
        key,
        area,
        cloud.solid_fraction,
        cloud.count,
        radius,
        &mut random,
    )?;
    match cloud.arrangement {
        Arrangement::Sunflower => Ok(arrange::sunflower(cloud.centre, cloud.radius, &radii)),
        Arrangement::Random => {
            let region = Region::Disk {
                centre: cloud.centre,
                radius: cloud.radius,
            };
            place_at_random(key, &region, area, radii, fixed, &mut random, neighbours)
        }
    }
}

fn place_box(
    key: &str,
    filled: &FilledBox,
    radius: Radius,
    fixed: bool,
    room: Option<&GrainRoom>,
    neighbours: &Neighbours,
) -> Result<Vec<Spot>, Refusal> {
    let mut random = Random::new(filled.seed);
    let side: [f64; 2] = std::array::from_fn(|axis| filled.upper[axis] - filled.lower[axis]);
    let area = side[0] * side[1];
    let radii = radii(
        key,
        area,
        filled.solid_fraction,
        filled.count,
        radius,
        &mut random,
    )?;
    let wraps = spans_period(filled.lower, filled.upper, room);
    let narrowest = (0..2)
        .filter(|&axis| !wraps[axis])
        .map(|axis| side[axis])
        .fold(f64::MAX, f64::min);
    if 2.0 * radius.max() > narrowest {
        let diameter = 2.0 * radius.max();
        let why = format!("a grain of diameter {diameter:e} m does not fit into {narrowest:e} m");
        return Err((key.to_string(), why));
    }
    let region = Region::Box {
        lower: filled.lower,
        upper: filled.upper,
        wraps,
    };
    place_at_random(key, &region, area, radii, fixed, &mut random, neighbours)
}

/// Does a rectangle span a whole period in x and y? It has no edge there.
fn spans_period(lower: [f64; 2], upper: [f64; 2], room: Option<&GrainRoom>) -> [bool; 2] {
    std::array::from_fn(|axis| {
        let side = upper[axis] - lower[axis];
        let period = room.and_then(|room| room.period[axis]);
        period.is_some_and(|period| (period - side).abs() <= 1e-9 * period)
    })
}

fn place_lattice(
    key: &str,
    lattice: &Lattice,
    radius: Radius,
    room: Option<&GrainRoom>,
) -> Result<Vec<Spot>, Refusal> {
    let mut random = Random::new(lattice.seed);
    let wraps = spans_period(lattice.lower, lattice.upper, room);
    let frame = Frame {
        lattice,
        radius: radius.max(),
        wraps,
    };
    let rows = match (lattice.spacing, lattice.solid_fraction) {
        (Some(spacing), _) => frame.with_spacing(spacing),
        (None, fraction) => frame.with_fraction(fraction.unwrap_or(0.0), mean_area(radius)),
    };
    let refuse = |why: String| Err((key.to_string(), why));
    if rows.count() < 1.0 {
        return refuse("not one grain fits into this rectangle".into());
    }
    let (nearest, diameter) = (rows.nearest(), 2.0 * radius.max());
    if nearest < diameter * (1.0 - 1e-9) {
        return refuse(format!(
            "neighbours would be {nearest:e} m apart and grains are {diameter:e} m wide: {}",
            looser(lattice)
        ));
    }
    if let Some(why) = memory::refusal("grains", rows.count(), memory::GRAIN) {
        return refuse(why);
    }
    let positions = rows.points();
    Ok(positions
        .into_iter()
        .map(|position| (position, draw(radius, &mut random)))
        .collect())
}

/// What makes a lattice less dense, and is not so yet.
fn looser(lattice: &Lattice) -> &'static str {
    match (lattice.spacing.is_some(), lattice.pattern) {
        (true, _) => "raise the spacing, or make the grains smaller",
        (false, Pattern::Square) => "lower the solid fraction, or use pattern = \"hexagonal\"",
        (false, Pattern::Hexagonal) => "lower the solid fraction",
    }
}

fn place_at_random(
    key: &str,
    region: &Region,
    area: f64,
    mut radii: Vec<f64>,
    fixed: bool,
    random: &mut Random,
    neighbours: &Neighbours,
) -> Result<Vec<Spot>, Refusal> {
    let fraction = radii.iter().map(|radius| PI * radius * radius).sum::<f64>() / area;
    if fraction > RANDOM_FRACTION_MAX {
        let why = format!(
            "a solid fraction of {fraction:.4} cannot be placed at random without overlap, at most \
             {RANDOM_FRACTION_MAX}: use a lattice, or let grains settle in a dry run first"
        );
        return Err((key.to_string(), why));
    }
    // The large ones first: they no longer fit where small ones are.
    radii.sort_by(|a, b| b.total_cmp(a));
    arrange::at_random(region, &radii, fixed, random, neighbours).map_err(|placed| {
        let count = radii.len();
        let why = format!(
            "only {placed} of {count} grains found a place without overlap; lower the amount"
        );
        (key.to_string(), why)
    })
}

/// The radii of a population: as many as were asked for, or as fill the fraction of the area.
fn radii(
    key: &str,
    area: f64,
    fraction: Option<f64>,
    count: Option<usize>,
    radius: Radius,
    random: &mut Random,
) -> Result<Vec<f64>, Refusal> {
    let count = match (count, fraction) {
        (Some(count), _) => count,
        (None, fraction) => (fraction.unwrap_or(0.0) * area / mean_area(radius)).round() as usize,
    };
    if count == 0 {
        return Err((
            key.to_string(),
            "this fraction of this area is less than one grain".into(),
        ));
    }
    if let Some(why) = memory::refusal("grains", count as f64, memory::GRAIN) {
        return Err((key.to_string(), why));
    }
    let mut radii: Vec<f64> = (0..count).map(|_| draw(radius, random)).collect();
    // The drawn areas scatter around their mean; dropping or adding grains meets the fraction.
    if let (Some(fraction), Radius::Range(_)) = (fraction, radius) {
        let target = fraction * area;
        let mut filled: f64 = radii.iter().map(|radius| PI * radius * radius).sum();
        while filled < target {
            radii.push(draw(radius, random));
            filled += radii.last().map_or(0.0, |radius| PI * radius * radius);
        }
        while radii.len() > 1 && filled - radii.last().map_or(0.0, |r| PI * r * r) >= target {
            filled -= radii.pop().map_or(0.0, |radius| PI * radius * radius);
        }
    }
    Ok(radii)
}

fn draw(radius: Radius, random: &mut Random) -> f64 {
    match radius {
        Radius::One(radius) => radius,
        Radius::Range(range) => random.between(range.min, range.max),
    }
}

/// π⟨r²⟩ of the distribution \[m²\].
fn mean_area(radius: Radius) -> f64 {
    let (low, high) = (radius.min(), radius.max());
    PI * (low * low + low * high + high * high) / 3.0
}
