//! Numbers out of run folders, and the reference they are held against.

use std::path::Path;

use serde_json::Value;

use crate::analysis::straight;
use crate::keys::{Measure, Reference};
use scene::Error;
use show::table::Table;

/// The measure of a run that is over.
pub fn measure(measure: &Measure, folder: &Path, run: &Value) -> Result<f64, Error> {
    let refuse = |why: String| Error::Usage(format!("{}: {why}", folder.display()));
    let raw = match (&measure.column, &measure.json) {
        (Some(column), _) => {
            let table = Table::read(&folder.join("steps.csv"))?;
            from_steps(measure, column, &table).map_err(refuse)?
        }
        (None, Some(pointer)) => {
            let number = |pointer: &str| {
                run.pointer(pointer)
                    .and_then(Value::as_f64)
                    .ok_or_else(|| refuse(format!("run.json has no number at {pointer}")))
            };
            match &measure.per {
                Some(per) => number(pointer)? / number(per)?,
                None => number(pointer)?,
            }
        }
        (None, None) => f64::NAN,
    };
    let value = measure.factor * raw + measure.offset;
    if value.is_finite() {
        return Ok(value);
    }
    Err(refuse(format!("{} is {value}", measure.name)))
}

fn from_steps(measure: &Measure, column: &str, table: &Table) -> Result<f64, String> {
    let values = table.column(column).ok_or_else(|| {
        format!(
            "steps.csv has no column {column} (it has: {})",
            table.columns.join(", ")
        )
    })?;
    let time = table.column("time").ok_or("steps.csv has no column time")?;
    let within = |window: [f64; 2]| -> Result<Vec<(f64, f64)>, String> {
        let slack = 1e-9 * window[1];
        let found: Vec<(f64, f64)> = time
            .iter()
            .copied()
            .zip(values.iter().copied())
            .filter(|(t, _)| (window[0] - slack..=window[1] + slack).contains(t))
            .collect();
        match found.len() {
            0 => Err(format!("no step between {} and {} s", window[0], window[1])),
            _ => Ok(found),
        }
    };
    if let Some(at) = measure.time {
        return table
            .at("time", at, column)
            .ok_or_else(|| format!("the run does not reach t = {at} s"));
    }
    if let Some(window) = measure.mean {
        let found = within(window)?;
        return Ok(found.iter().map(|p| p.1).sum::<f64>() / found.len() as f64);
    }
    if let Some(window) = measure.largest {
        return Ok(within(window)?.iter().map(|p| p.1).fold(f64::MIN, f64::max));
    }
    if let Some(window) = measure.rise {
        let (mut lowest, mut rise) = (f64::INFINITY, 0.0_f64);
        for (_, value) in within(window)? {
            rise = rise.max(value - lowest);
            lowest = lowest.min(value);
        }
        return Ok(rise);
    }
    if let Some(window) = measure.slope {
        return straight(&within(window)?)
            .ok_or_else(|| format!("fewer than two steps in {window:?} s"));
    }
    values.last().copied().ok_or("no steps".into())
}

/// The reference's number; none when it is a finer run.
pub fn truth(reference: &Reference, folder: &Path) -> Result<Option<f64>, Error> {
    if let Some(value) = reference.value {
        return Ok(Some(reference.factor * value));
    }
    let (Some(file), Some(column)) = (&reference.file, &reference.column) else {
        return Ok(None);
    };
    let path = folder.join(file);
    let table = Table::read(&path)?;
    let refuse = |why: String| Error::Usage(format!("{}: {why}", path.display()));
    for name in reference.at.keys().chain([column]) {
        if table.place(name).is_none() {
            let known = table.columns.join(", ");
            return Err(refuse(format!("has no column {name} (it has: {known})")));
        }
    }
    let is_row = |row: &&Vec<f64>| {
        reference.at.iter().all(|(name, at)| {
            let place = table.place(name);
            place.is_some_and(|place| (row[place] - at).abs() <= 1e-9 * at.abs())
        })
    };
    let place = table.place(column).unwrap_or(0);
    let between = || match reference.at.iter().next() {
        Some((name, at)) if reference.at.len() == 1 => table.at(name, *at, column),
        _ => None,
    };
    table
        .rows
        .iter()
        .find(is_row)
        .map(|row| row[place])
        .or_else(between)
        .filter(|value| value.is_finite())
        .map(|value| Some(reference.factor * value))
        .ok_or_else(|| refuse(format!("has no {column} at {:?}", reference.at)))
}
