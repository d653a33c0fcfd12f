//! What was found: JSON, CSV and text.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;
use serde_json::{Value, json};

use crate::maps::{Axis, Map};
use crate::schemes::{DEFAULT, SCHEMES};
use crate::verdict::{BALANCE, Finding, GROWTH, SECONDS, Verdict};
use run::file;
use scene::Error;

/// A map with what was found of it.
#[derive(Debug, Clone, Serialize)]
pub struct MapResult {
    /// Its name.
    pub name: &'static str,
    /// What was run.
    pub title: &'static str,
    /// 2 or 3.
    pub dimension: usize,
    /// From left to right.
    pub across: AxisResult,
    /// From bottom to top.
    pub up: AxisResult,
    /// Do schemes differ?
    pub coupled: bool,
    /// Cells by row, column and scheme.
    pub cells: Vec<Cell>,
}

/// An axis as it is shown.
#[derive(Debug, Clone, Serialize)]
pub struct AxisResult {
    /// What varies.
    pub name: &'static str,
    /// How each value is written.
    pub labels: Vec<String>,
    /// The values; the place in the list where they are names.
    pub values: Vec<f64>,
    /// Places that were run.
    #[serde(skip)]
    pub places: Vec<usize>,
}

/// One scheme at one point.
#[derive(Debug, Clone, Serialize)]
pub struct Cell {
    /// Place on the axis across.
    pub across: usize,
    /// Place on the axis up.
    pub up: usize,
    /// The scheme.
    pub scheme: &'static str,
    /// What the closed form says.
    pub limit: f64,
    /// Steps of the scene.
    pub steps_asked: usize,
    /// What was found.
    #[serde(flatten)]
    pub finding: Finding,
}

impl MapResult {
    /// Of a map that nothing is known of yet.
    pub fn new(map: &Map, quick: bool) -> MapResult {
        let axis = |axis: &Axis| AxisResult {
            name: axis.name,
            labels: axis.labels.clone(),
            values: axis.values.clone(),
            places: axis.places(quick),
        };
        MapResult {
            name: map.name,
            title: map.title,
            dimension: map.dimension.axes(),
            across: axis(&map.across),
            up: axis(&map.up),
            coupled: map.coupled,
            cells: Vec::new(),
        }
    }

    /// Schemes that this map has.
    pub fn schemes(&self) -> Vec<&'static str> {
        let names = SCHEMES.iter().map(|(name, _)| *name);
        names
            .filter(|name| self.coupled || *name == DEFAULT)
            .collect()
    }

    /// Cells of a scheme.
    pub fn of(&self, scheme: &str) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(move |cell| cell.scheme == scheme)
    }

    fn count(&self, scheme: &str, verdict: Verdict) -> usize {
        self.of(scheme)
            .filter(|cell| cell.finding.verdict == verdict)
            .count()
    }
}

/// Cells in which the default is neither stable nor refused.
pub fn failed(results: &[MapResult]) -> usize {
    let cells = results.iter().flat_map(|map| map.of(DEFAULT));
    cells.filter(|cell| !cell.finding.verdict.allowed()).count()
}

/// `stability.json`.
pub fn document(results: &[MapResult], quick: bool, complete: bool) -> Value {
    let counts: serde_json::Map<String, Value> = SCHEMES
        .iter()
        .map(|(scheme, _)| {
            let of = |verdict| {
                results
                    .iter()
                    .map(|map| map.count(scheme, verdict))
                    .sum::<usize>()
            };
            let table: serde_json::Map<String, Value> = Verdict::ALL
                .iter()
                .map(|verdict| (verdict.name().to_string(), of(*verdict).into()))
                .collect();
            (scheme.to_string(), table.into())
        })
        .collect();
    json!({
        "quick": quick,
        "complete": complete,
        "default": DEFAULT,
        "default_failed": failed(results),
        "thresholds": { "growth": GROWTH, "balance": BALANCE, "seconds_of_a_step": SECONDS },
        "counts": counts,
        "maps": results,
    })
}

/// Write `stability.json` and `stability.csv`.
pub fn write(folder: &Path, document: &Value, results: &[MapResult]) -> Result<(), Error> {
    file::write(&folder.join("stability.json"), format!("{document:#}\n"))?;
    file::write(&folder.join("stability.csv"), csv(results))
}

fn csv(results: &[MapResult]) -> String {
    let mut text = String::from(
        "map,across,up,scheme,verdict,value,limit,error,passes_mean,passes_max,sub_steps_max,steps,steps_asked,why\n",
    );
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:e}"));
    for map in results {
        for cell in &map.cells {
            let finding = &cell.finding;
            let why = finding
                .why
                .as_deref()
                .unwrap_or("")
                .replace('"', "'")
                .replace('\n', " ");
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{},{},\"{}\",{},{},{},{:e},{},{},{},{},{},{},\"{why}\"",
                map.name,
                map.across.labels[cell.across],
                map.up.labels[cell.up],
                cell.scheme,
                finding.verdict.name(),
                number(finding.value),
                cell.limit,
                number(finding.error),
                number(finding.passes_mean),
                number(finding.passes_max),
                number(finding.sub_steps_max),
                finding.steps,
                cell.steps_asked,
            );
        }
    }
    text
}

/// Counts by map and scheme; then every cell in which the default fails, with its numbers.
pub fn text(results: &[MapResult]) -> String {
    let mut text = String::new();
    let mut line = |words: String| {
        text += words.trim_end();
        text.push('\n');
    };
    line(format!(
        "{:<19} {:<14} {:>5} {:>7}  {}",
        "map", "scheme", "cells", "stable", "otherwise"
    ));
    for map in results {
        for scheme in map.schemes() {
            let rest: Vec<String> = Verdict::ALL[1..]
                .iter()
                .map(|verdict| (map.count(scheme, *verdict), verdict.name()))
                .filter(|(count, _)| *count > 0)
                .map(|(count, name)| format!("{count} {name}"))
                .collect();
            line(format!(
                "{:<19} {scheme:<14} {:>5} {:>7}  {}",
                map.name,
                map.of(scheme).count(),
                map.count(scheme, Verdict::Stable),
                rest.join(", ")
            ));
        }
    }
    for map in results {
        for cell in map
            .of(DEFAULT)
            .filter(|cell| cell.finding.verdict != Verdict::Stable)
        {
            line(format!(
                "{}: {} = {}, {} = {}: {}: {}",
                map.name,
                map.across.name,
                map.across.labels[cell.across],
                map.up.name,
                map.up.labels[cell.up],
                cell.finding.verdict.name(),
                cell.finding.why.as_deref().unwrap_or("")
            ));
        }
    }
    text
}
