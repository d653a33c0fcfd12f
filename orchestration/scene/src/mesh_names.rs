//! Names of the boundaries of a Gmsh 4.1 text file: its physical curves.

use std::collections::BTreeMap;
use std::path::Path;

/// Names of the physical curves, in the order of their numbers.
pub fn boundary_names(path: &Path) -> Result<Vec<String>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("cannot be read: {error}"))?;
    let format = section(&text, "MeshFormat").ok_or("is not a Gmsh file: no $MeshFormat")?;
    let words: Vec<&str> = format.split_whitespace().collect();
    if words.first() != Some(&"4.1") || words.get(1) != Some(&"0") {
        let found = words.first().unwrap_or(&"none");
        return Err(format!(
            "must be a Gmsh 4.1 text file, found version {found}"
        ));
    }
    let names = physical_curves(section(&text, "PhysicalNames").unwrap_or_default());
    if names.is_empty() {
        return Err("names no physical curve, so no boundary can be addressed".into());
    }
    refuse_shared_curves(section(&text, "Entities").unwrap_or_default(), &names)?;
    Ok(names.into_values().collect())
}

/// Text between $Name and $EndName.
pub(crate) fn section<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let start = text.find(&format!("${name}"))? + name.len() + 1;
    let length = text[start..].find(&format!("$End{name}"))?;
    Some(&text[start..start + length])
}

/// Number and name of each physical group of dimension 1: lines `1 7 "inlet"`.
pub(crate) fn physical_curves(section: &str) -> BTreeMap<i64, String> {
    section
        .lines()
        .filter_map(|line| {
            let (numbers, name) = line.trim().split_once('"')?;
            let mut numbers = numbers.split_whitespace();
            if numbers.next()? != "1" {
                return None;
            }
            Some((
                numbers.next()?.parse().ok()?,
                name.trim_end_matches('"').to_string(),
            ))
        })
        .collect()
}

/// A curve in two named groups would have two conditions.
fn refuse_shared_curves(section: &str, names: &BTreeMap<i64, String>) -> Result<(), String> {
    let mut lines = section.trim().lines();
    let counts: Vec<usize> = lines
        .next()
        .unwrap_or_default()
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect();
    let (Some(&points), Some(&curves)) = (counts.first(), counts.get(1)) else {
        return Ok(());
    };
    for line in lines.skip(points).take(curves) {
        // tag, six bounds, number of physical groups, the groups, …
        let words: Vec<&str> = line.split_whitespace().collect();
        let count: usize = words.get(7).and_then(|word| word.parse().ok()).unwrap_or(0);
        let groups: Vec<&String> = words
            .iter()
            .skip(8)
            .take(count)
            .filter_map(|word| names.get(&word.parse::<i64>().ok()?.abs()))
            .collect();
        if let [first, second, ..] = groups[..] {
            let curve = words[0];
            return Err(format!(
                "curve {curve} belongs to both '{first}' and '{second}'"
            ));
        }
    }
    Ok(())
}
