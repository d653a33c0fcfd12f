//! `sillage diff`: compares two recordings, or two run folders by their steps and recordings.

pub mod steps;

use std::path::Path;

use recording::{Reader, compare, diff};
use serde_json::{Value, json};

use crate::cli::DiffArgs;
use crate::error::Error;
use crate::record;
use crate::say;
use steps::Columns;

/// The command: the tables, or with `--json` a document, on standard output.
pub fn command(args: &DiffArgs) -> Result<(), Error> {
    let (first, second) = (args.first.as_path(), args.second.as_path());
    for path in [first, second] {
        if !path.exists() {
            return Err(Error::Usage(format!("{} does not exist", path.display())));
        }
    }
    let folders = first.is_dir() && second.is_dir();
    let columns = if folders {
        Some(steps::diff(first, second)?)
    } else {
        None
    };
    let recordings = recordings(first, second, folders)?;
    let exchange = match &recordings {
        Some([one, other]) => Some(exchange(one, other, args.tolerance)?),
        None => None,
    };
    let within = columns
        .as_ref()
        .is_none_or(|columns| columns.within(args.tolerance))
        && exchange.as_ref().is_none_or(|exchange| exchange.within);
    if args.json {
        let document = json!({
            "ok": within,
            "tolerance": args.tolerance,
            "steps": columns.map(|columns| columns.to_json(args.tolerance)),
            "recordings": exchange.map(|exchange| exchange.document),
        });
        say!("{document:#}");
    } else {
        if let Some(columns) = &columns {
            say!(
                "steps.csv (times left out)\n{}",
                columns.text(args.tolerance)
            );
        }
        if let Some(exchange) = &exchange {
            say!("recordings\n{}", exchange.text);
        } else {
            say!("no recordings to compare");
        }
        let verdict = if within { "within" } else { "OUTSIDE" };
        say!("{verdict} the tolerance {:e}", args.tolerance);
    }
    if within {
        Ok(())
    } else {
        Err(Error::Different)
    }
}

/// The recordings to compare: those named, or those of the folders when both have one.
fn recordings(
    first: &Path,
    second: &Path,
    folders: bool,
) -> Result<Option<[std::path::PathBuf; 2]>, Error> {
    if !folders {
        return Ok(Some([record::find(first)?, record::find(second)?]));
    }
    let there = |folder: &Path| record::in_folder(folder).filter(|file| file.exists());
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
            eprintln!("sillage: warning: {}: {warning}", reader.path().display());
        }
    }
    let fields: serde_json::Map<String, Value> = differences
        .fields
        .iter()
        .map(|(name, row): (&String, &compare::Difference)| (name.clone(), row.to_json(tolerance)))
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

impl Columns {
    fn to_json(&self, tolerance: f64) -> Value {
        let columns: serde_json::Map<String, Value> = self
            .columns
            .iter()
            .map(|(name, row)| (name.clone(), row.to_json(tolerance)))
            .collect();
        json!({ "rows": self.rows, "columns": columns, "only_in_one": self.only_in_one })
    }
}
