//! Grains from a CSV file: x, y, radius[, density][, vx, vy][, fixed], in space z and vz too, in SI units or in those that
//! the header gives in brackets, as in `x [mm]`; between commas, or semicolons.

use std::path::Path;

use super::table::{Grain, GrainTable};
use crate::dimensions::AXES;
use crate::keys::{Grains, Numbers};
use crate::memory;

/// Names of the columns of velocities.
const VELOCITY: [&str; 3] = ["vx", "vy", "vz"];

/// Names of all columns in a scene of this dimension.
fn known(dimension: usize) -> Vec<&'static str> {
    let (places, speeds) = (&AXES[..dimension], &VELOCITY[..dimension]);
    [places, &["radius", "density"], speeds, &["fixed"]].concat()
}

/// Read the file of a population.
pub fn read<const D: usize>(path: &Path, population: &Grains<D>) -> Result<Vec<Grain<D>>, String> {
    let at = path.display();
    let unreadable = |error: std::io::Error| format!("{at} cannot be read: {error}");
    let about = std::fs::metadata(path).map_err(unreadable)?;
    if !about.is_file() {
        return Err(format!("{at} is not a file"));
    }
    if let Some(why) = memory::refusal("bytes of text", about.len() as f64, 2.0) {
        return Err(format!("{at}: {why}"));
    }
    let text = std::fs::read_to_string(path).map_err(unreadable)?;
    if let Some(why) = memory::refusal("lines", text.lines().count() as f64, memory::GRAIN) {
        return Err(format!("{at}: {why}"));
    }
    // Spreadsheets begin a file with a mark of its encoding.
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (_, header) = lines.next().ok_or_else(|| format!("{at} is empty"))?;
    let separator = separator(header);
    let header = columns::<D>(header).map_err(|why| format!("{at}: {why}"))?;
    if population.density.is_none() && !header.iter().any(|column| column.name == "density") {
        return Err(format!(
            "{at} has no column density: add it, or write density beside file"
        ));
    }
    let mut grains = Vec::new();
    for (number, line) in lines {
        grains.push(
            row(line, separator, &header, population)
                .map_err(|why| format!("{at}:{}: {why}", number + 1))?,
        );
    }
    if grains.is_empty() {
        return Err(format!("{at} has a header and no grain"));
    }
    Ok(grains)
}

/// Read the grains that a run folder keeps.
pub fn of_run(path: &Path, dimension: usize) -> Result<GrainTable, String> {
    match dimension {
        3 => table::<3>(path),
        _ => table::<2>(path),
    }
}

fn table<const D: usize>(path: &Path) -> Result<GrainTable, String> {
    let population = Grains::<D> {
        density: None,
        radius: None,
        velocity: Numbers::default(),
        fixed: false,
        cloud: None,
        lattice: None,
        filled_box: None,
        file: None,
    };
    let mut table = GrainTable::default();
    for grain in read(path, &population)? {
        table.push(grain);
    }
    Ok(table)
}

/// A column of the file: what it is, and what a number there is worth in SI units.
struct Column {
    name: &'static str,
    factor: f64,
}

/// Units that a length, a density and a velocity may have, with what they are worth in SI units.
const LENGTHS: [(&str, f64); 6] = [
    ("m", 1.0),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("um", 1e-6),
    ("µm", 1e-6),
    ("μm", 1e-6),
];
const DENSITIES: [(&str, f64); 4] = [
    ("kg/m3", 1.0),
    ("kg/m³", 1.0),
    ("g/cm3", 1e3),
    ("g/cm³", 1e3),
];
const VELOCITIES: [(&str, f64); 3] = [("m/s", 1.0), ("cm/s", 1e-2), ("mm/s", 1e-3)];

/// The units of a column.
fn units(name: &str) -> &'static [(&'static str, f64)] {
    match name {
        "x" | "y" | "z" | "radius" => &LENGTHS,
        "density" => &DENSITIES,
        "vx" | "vy" | "vz" => &VELOCITIES,
        _ => &[],
    }
}

/// What stands between values: commas, or semicolons where the header has them.
fn separator(header: &str) -> char {
    if header.contains(';') { ';' } else { ',' }
}

fn column<const D: usize>(word: &str) -> Result<Column, String> {
    let (name, unit) = match word.split_once('[') {
        Some((name, rest)) => {
            let unit = rest.trim_end().strip_suffix(']');
            let unit = unit.ok_or_else(|| format!("`{}` has no closing ]", word.trim()))?;
            (name.trim(), Some(unit.trim()))
        }
        None => (word.trim(), None),
    };
    let names = known(D);
    let known = names.iter().find(|known| **known == name).copied();
    let name =
        known.ok_or_else(|| format!("unknown column {name} (columns: {})", names.join(", ")))?;
    let Some(unit) = unit.filter(|unit| !matches!(*unit, "" | "-" | "–" | "1")) else {
        return Ok(Column { name, factor: 1.0 });
    };
    let known = units(name).iter().find(|(known, _)| *known == unit);
    let Some((_, factor)) = known else {
        let allowed: Vec<&str> = units(name).iter().map(|(unit, _)| *unit).collect();
        let allowed = match allowed.is_empty() {
            true => "it has none".to_owned(),
            false => format!("allowed: {}", allowed.join(", ")),
        };
        return Err(format!("unit [{unit}] of {name} is not known ({allowed})"));
    };
    Ok(Column {
        name,
        factor: *factor,
    })
}

fn columns<const D: usize>(header: &str) -> Result<Vec<Column>, String> {
    let mut found: Vec<Column> = Vec::new();
    for word in header.split(separator(header)) {
        let new = column::<D>(word)?;
        if found.iter().any(|old| old.name == new.name) {
            return Err(format!("column {} appears twice", new.name));
        }
        found.push(new);
    }
    let missing = |name: &&&str| !found.iter().any(|old| old.name == **name);
    match AXES[..D].iter().chain(&["radius"]).find(missing) {
        Some(name) => Err(format!("column {name} is missing")),
        None => Ok(found),
    }
}

fn row<const D: usize>(
    line: &str,
    separator: char,
    header: &[Column],
    population: &Grains<D>,
) -> Result<Grain<D>, String> {
    let words: Vec<&str> = line.split(separator).map(str::trim).collect();
    if words.len() != header.len() {
        return Err(format!(
            "{} values in {} columns",
            words.len(),
            header.len()
        ));
    }
    let mut grain = Grain {
        position: [0.0; D],
        radius: 0.0,
        density: population.density.unwrap_or(0.0),
        velocity: population.velocity.0,
        fixed: population.fixed,
    };
    for (Column { name, factor }, word) in header.iter().zip(words) {
        let value: f64 = word
            .parse()
            .map_err(|_| format!("{name} = {word} is not a number"))?;
        if !value.is_finite() {
            return Err(format!("{name} = {word} is not finite"));
        }
        let value = value * factor;
        let along = |names: [&str; 3]| names.iter().position(|axis| axis == name);
        match (*name, along(AXES), along(VELOCITY)) {
            (_, Some(axis), _) => grain.position[axis] = value,
            (_, _, Some(axis)) => grain.velocity[axis] = value,
            ("radius", ..) => grain.radius = value,
            ("density", ..) => grain.density = value,
            _ => grain.fixed = value != 0.0,
        }
    }
    for (name, value) in [("radius", grain.radius), ("density", grain.density)] {
        if value <= 0.0 {
            return Err(format!("{name} = {value:e} must be greater than 0"));
        }
    }
    Ok(grain)
}
