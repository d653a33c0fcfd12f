//! One population: how many grains, which radii, where.

use space::Dim;

use super::arrange::{self, Region};
use super::lattice::Frame;
use super::neighbours::Neighbours;
use super::random::Random;
use super::table::Grain;
use crate::dimensions::Scenic;
use crate::keys::{Arrangement, Cloud, FilledBox, Grains, Lattice, Pattern, Radius};
use crate::memory;
use crate::walls::GrainRoom;

/// Key and message of what cannot be placed.
pub type Refusal = (String, String);

/// Place a population that does not come from a file.
pub fn place<const D: usize>(
    key: &str,
    grains: &Grains<D>,
    room: Option<&GrainRoom<D>>,
    neighbours: &Neighbours<D>,
) -> Result<Vec<Grain<D>>, Refusal>
where
    Dim<D>: Scenic<D>,
{
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
    let (velocity, fixed) = (grains.velocity.0, grains.fixed);
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

type Spot<const D: usize> = ([f64; D], f64);

fn place_cloud<const D: usize>(
    key: &str,
    cloud: &Cloud<D>,
    radius: Radius,
    fixed: bool,
    neighbours: &Neighbours<D>,
) -> Result<Vec<Spot<D>>, Refusal>
where
    Dim<D>: Scenic<D>,
{
    let mut random = Random::new(cloud.seed);
    let content = Dim::<D>::grain(cloud.radius);
    let radii = radii::<D>(
        key,
        content,
        cloud.solid_fraction,
        cloud.count,
        radius,
        &mut random,
    )?;
    match cloud.arrangement {
        Arrangement::Sunflower => Ok(arrange::sunflower(&cloud.centre, cloud.radius, &radii)),
        Arrangement::Random => {
            let region = Region::Ball {
                centre: cloud.centre,
                radius: cloud.radius,
            };
            place_at_random(key, &region, content, radii, fixed, &mut random, neighbours)
        }
    }
}

fn place_box<const D: usize>(
    key: &str,
    filled: &FilledBox<D>,
    radius: Radius,
    fixed: bool,
    room: Option<&GrainRoom<D>>,
    neighbours: &Neighbours<D>,
) -> Result<Vec<Spot<D>>, Refusal>
where
    Dim<D>: Scenic<D>,
{
    let mut random = Random::new(filled.seed);
    let side: [f64; D] = std::array::from_fn(|axis| filled.upper[axis] - filled.lower[axis]);
    let content = side.iter().product();
    let radii = radii::<D>(
        key,
        content,
        filled.solid_fraction,
        filled.count,
        radius,
        &mut random,
    )?;
    let wraps = spans_period(&filled.lower, &filled.upper, room);
    let narrowest = (0..D)
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
    place_at_random(key, &region, content, radii, fixed, &mut random, neighbours)
}

/// Does a rectangle or box span a whole period along each axis? It has no edge there.
fn spans_period<const D: usize>(
    lower: &[f64; D],
    upper: &[f64; D],
    room: Option<&GrainRoom<D>>,
) -> [bool; D] {
    std::array::from_fn(|axis| {
        let side = upper[axis] - lower[axis];
        let period = room.and_then(|room| room.period[axis]);
        period.is_some_and(|period| (period - side).abs() <= 1e-9 * period)
    })
}

fn place_lattice<const D: usize>(
    key: &str,
    lattice: &Lattice<D>,
    radius: Radius,
    room: Option<&GrainRoom<D>>,
) -> Result<Vec<Spot<D>>, Refusal>
where
    Dim<D>: Scenic<D>,
{
    let mut random = Random::new(lattice.seed);
    let wraps = spans_period(&lattice.lower, &lattice.upper, room);
    let frame = Frame {
        lattice,
        radius: radius.max(),
        wraps,
    };
    let rows = match (lattice.spacing, lattice.solid_fraction) {
        (Some(spacing), _) => frame.with_spacing(spacing),
        (None, fraction) => frame.with_fraction(fraction.unwrap_or(0.0), mean_grain::<D>(radius)),
    };
    let refuse = |why: String| Err((key.to_string(), why));
    if rows.count() < 1.0 {
        return refuse("not one grain fits into this place".into());
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
fn looser<const D: usize>(lattice: &Lattice<D>) -> &'static str {
    match (lattice.spacing.is_some(), lattice.pattern) {
        (true, _) => "raise the spacing, or make the grains smaller",
        (false, Pattern::Square | Pattern::Cubic) => {
            "lower the solid fraction, or use pattern = \"hexagonal\""
        }
        (false, Pattern::Hexagonal) => "lower the solid fraction",
    }
}

fn place_at_random<const D: usize>(
    key: &str,
    region: &Region<D>,
    content: f64,
    mut radii: Vec<f64>,
    fixed: bool,
    random: &mut Random,
    neighbours: &Neighbours<D>,
) -> Result<Vec<Spot<D>>, Refusal>
where
    Dim<D>: Scenic<D>,
{
    let grains = radii.iter().map(|radius| Dim::<D>::grain(*radius));
    let fraction = grains.sum::<f64>() / content;
    let most = Dim::<D>::RANDOM_FRACTION_MAX;
    if fraction > most {
        let why = format!(
            "a solid fraction of {fraction:.4} cannot be placed at random without overlap, at most \
             {most}: use a lattice, or let grains settle in a dry run first"
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

/// The radii of a population: as many as were asked for, or as fill the fraction of the content.
fn radii<const D: usize>(
    key: &str,
    content: f64,
    fraction: Option<f64>,
    count: Option<usize>,
    radius: Radius,
    random: &mut Random,
) -> Result<Vec<f64>, Refusal>
where
    Dim<D>: Scenic<D>,
{
    let count = match (count, fraction) {
        (Some(count), _) => count,
        (None, fraction) => {
            (fraction.unwrap_or(0.0) * content / mean_grain::<D>(radius)).round() as usize
        }
    };
    if count == 0 {
        return Err((
            key.to_string(),
            format!(
                "this fraction of this {} is less than one grain",
                Dim::<D>::CONTENT
            ),
        ));
    }
    if let Some(why) = memory::refusal("grains", count as f64, memory::GRAIN) {
        return Err((key.to_string(), why));
    }
    let mut radii: Vec<f64> = (0..count).map(|_| draw(radius, random)).collect();
    // What is drawn scatters around its mean; dropping or adding grains meets the fraction.
    if let (Some(fraction), Radius::Range(_)) = (fraction, radius) {
        let last = |radii: &[f64]| radii.last().map_or(0.0, |radius| Dim::<D>::grain(*radius));
        let target = fraction * content;
        let mut filled: f64 = radii.iter().map(|radius| Dim::<D>::grain(*radius)).sum();
        while filled < target {
            radii.push(draw(radius, random));
            filled += last(&radii);
        }
        while radii.len() > 1 && filled - last(&radii) >= target {
            filled -= last(&radii);
            radii.pop();
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

/// Mean content of a grain of the distribution \[m²; m³\].
fn mean_grain<const D: usize>(radius: Radius) -> f64
where
    Dim<D>: Scenic<D>,
{
    Dim::<D>::mean_grain(radius.min(), radius.max())
}
