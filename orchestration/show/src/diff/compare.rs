//! Two recordings, or two run folders by their steps and recordings.

use std::path::{Path, PathBuf};

use recording::compare::Difference;
use recording::{Reader, diff};
use run::folder::recorded;
use scene::Error;
use serde_json::{Value, json};

use super::steps::{self, Columns};

/// Differences of two runs, held against a tolerance.
pub struct Comparison {
    tolerance: f64,
    columns: Option<Columns>,
    exchange: Option<Exchange>,
}

/// Compare two recordings or run folders.
pub fn compare(first: &Path, second: &Path, tolerance: f64) -> Result<Comparison, Error> {
    for path in [first, second] {
        if !path.exists() {
            return Err(Error::Usage(format!("{} does not exist", path.display())));
        }
    }
    let folders = first.is_dir() && second.is_dir();
    let columns = match folders {
        true => Some(steps::diff(first, second)?),
        false => None,
    };
    let exchange = match recordings(first, second, folders)? {
        Some([one, other]) => Some(exchange(&one, &other, tolerance)?),
        None => None,
    };
    Ok(Comparison {
        tolerance,
        columns,
        exchange,
    })
}

impl Comparison {
    /// Is every difference within the tolerance?
    pub fn within(&self) -> bool {
        let columns = self.columns.as_ref();
        columns.is_none_or(|columns| columns.within(self.tolerance))
            && self
                .exchange
                .as_ref()
                .is_none_or(|exchange| exchange.within)
    }

    /// As JSON.
    pub fn document(&self) -> Value {
        let columns = self.columns.as_ref();
        json!({
            "ok": self.within(),
            "tolerance": self.tolerance,
            "steps": columns.map(|columns| columns.to_json(self.tolerance)),
            "recordings": self.exchange.as_ref().map(|exchange| &exchange.document),
        })
    }

    /// As tables, one after the other.
    pub fn tables(&self) -> Vec<String> {
        let mut tables = Vec::new();
        if let Some(columns) = &self.columns {
            let text = columns.text(self.tolerance);
            tables.push(format!("steps.csv (times left out)\n{text}"));
        }
        tables.push(match &self.exchange {
            Some(exchange) => format!("recordings\n{}", exchange.text),
            None => "no recordings to compare".to_string(),
        });
        let verdict = if self.within() { "within" } else { "OUTSIDE" };
        tables.push(format!("{verdict} the tolerance {:e}", self.tolerance));
        tables
    }
}

/// The recordings to compare: those named, or those of the folders when both have one.
fn recordings(first: &Path, second: &Path, folders: bool) -> Result<Option<[PathBuf; 2]>, Error> {
    if !folders {
        return Ok(Some([recorded::find(first)?, recorded::find(second)?]));
    }
    let there = |folder: &Path| recorded::in_folder(folder).filter(|file| file.exists());
    Ok(match (there(first), there(second)) {
        (Some(one), Some(other)) => Some([one, other]),
        _ => None,
    })
}

/// What comparing two recordings gave.
struct Exchange {
    within: bool,
    text: String,
    document: Value,
}

fn exchange(first: &Path, second: &Path, tolerance: f64) -> Result<Exchange, Error> {
    let (mut one, mut other) = (Reader::open(first)?, Reader::open(second)?);
    let differences = diff::diff(&mut one, &mut other)?;
    for reader in [&one, &other] {
        if let Some(warning) = reader.ending().warning() {
            run::tell!("sillage: warning: {}: {warning}", reader.path().display());
        }
    }
    let fields: serde_json::Map<String, Value> = differences
        .fields
        .iter()
        .map(|(name, row): (&String, &Difference)| (name.clone(), row.to_json(tolerance)))
        .collect();
    let mut document = json!(differences);
    document["fields"] = json!(fields);
    document["complete"] = json!([&one, &other].map(|reader| reader.ending().warning().is_none()));
    Ok(Exchange {
        within: differences.within(tolerance),
        text: diff::text(&differences, tolerance),
        document,
    })
}
