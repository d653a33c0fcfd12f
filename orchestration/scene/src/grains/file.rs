//! Grains from a CSV file: x, y, radius[, density][, vx, vy][, fixed]; units in brackets are
//! allowed in the header, as in `x [m]`.

use std::path::Path;

use super::table::Grain;
use crate::keys::Grains;

const COLUMNS: [&str; 7] = ["x", "y", "radius", "density", "vx", "vy", "fixed"];

/// Read the file of a population.
pub fn read(path: &Path, population: &Grains) -> Result<Vec<Grain>, String> {
    let at = path.display();
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("{at} cannot be read: {error}"))?;
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (_, header) = lines.next().ok_or_else(|| format!("{at} is empty"))?;
    let header = columns(header).map_err(|why| format!("{at}: {why}"))?;
    if population.density.is_none() && !header.contains(&"density") {
        return Err(format!(
            "{at} has no column density: add it, or write density beside file"
        ));
    }
    let mut grains = Vec::new();
    for (number, line) in lines {
        grains.push(
            row(line, &header, population).map_err(|why| format!("{at}:{}: {why}", number + 1))?,
        );
    }
    if grains.is_empty() {
        return Err(format!("{at} has a header and no grain"));
    }
    Ok(grains)
}

fn columns(header: &str) -> Result<Vec<&'static str>, String> {
    let mut found = Vec::new();
    for word in header.split(',') {
        let word = word.split('[').next().unwrap_or_default().trim();
        let known = COLUMNS
            .into_iter()
            .find(|name| *name == word)
            .ok_or_else(|| format!("unknown column {word} (columns: {})", COLUMNS.join(", ")))?;
        if found.contains(&known) {
            return Err(format!("column {known} appears twice"));
        }
        found.push(known);
    }
    match ["x", "y", "radius"]
        .iter()
        .find(|name| !found.contains(name))
    {
        Some(name) => Err(format!("column {name} is missing")),
        None => Ok(found),
    }
}

fn row(line: &str, header: &[&str], population: &Grains) -> Result<Grain, String> {
    let words: Vec<&str> = line.split(',').map(str::trim).collect();
    if words.len() != header.len() {
        return Err(format!(
            "{} values in {} columns",
            words.len(),
            header.len()
        ));
    }
    let mut grain = Grain {
        position: [0.0; 2],
        radius: 0.0,
        density: population.density.unwrap_or(0.0),
        velocity: population.velocity,
        fixed: population.fixed,
    };
    for (name, word) in header.iter().zip(words) {
        let value: f64 = word
            .parse()
            .map_err(|_| format!("{name} = {word} is not a number"))?;
        if !value.is_finite() {
            return Err(format!("{name} = {word} is not finite"));
        }
        match *name {
            "x" => grain.position[0] = value,
            "y" => grain.position[1] = value,
            "radius" => grain.radius = value,
            "density" => grain.density = value,
            "vx" => grain.velocity[0] = value,
            "vy" => grain.velocity[1] = value,
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
