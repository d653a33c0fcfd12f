//! What the page shows, as one JSON document.

use std::path::Path;

use scene::Error;
use serde_json::{Value, json};

use super::states::{Reader, dimension};
use crate::table::{Table, spread};

/// What a study writes: where it is, the folder is that of a study.
pub const STUDY_FILE: &str = "study.json";

/// Rows of `steps.csv` that the page draws at most.
const ROWS: usize = 1500;

/// What a page shows of a run, states included.
pub fn document(folder: &Path, most: usize) -> Result<Value, Error> {
    let mut document = head(folder)?;
    let scene = document["run"]["scene"]["resolved"].clone();
    let mut reader = Reader::open(folder, &scene);
    let entries = reader.entries()?;
    let mut frames = Vec::new();
    for index in spread(entries.len(), most) {
        frames.push(reader.frame(&entries[index], &scene["particles"]["walls"])?);
    }
    document["stage"] = reader.stage;
    document["frames"] = json!(frames);
    Ok(document)
}

/// All but the states: run.json, the scene as written, and the steps.
pub fn head(folder: &Path) -> Result<Value, Error> {
    let path = folder.join("run.json");
    if !path.is_file() {
        return Err(Error::Usage(format!(
            "{} is the folder of no run and no study: it has no run.json and no {}",
            folder.display(),
            STUDY_FILE
        )));
    }
    let text = std::fs::read_to_string(&path).map_err(Error::file("cannot read", &path))?;
    let run: Value = serde_json::from_str(&text)
        .map_err(|error| Error::Usage(format!("{}: {error}", path.display())))?;
    let steps = folder.join("steps.csv");
    let table = match steps.is_file() {
        true => Table::read(&steps)?,
        false => Table::default(),
    };
    let table = table.thinned(ROWS);
    let columns: serde_json::Map<String, Value> = table
        .columns
        .iter()
        .enumerate()
        .map(|(place, name)| {
            let column: Vec<f64> = table.rows.iter().map(|row| row[place]).collect();
            (name.clone(), json!(column))
        })
        .collect();
    let scene = std::fs::read_to_string(folder.join("scene.toml")).unwrap_or_default();
    let dimension = dimension(&run["scene"]["resolved"]);
    Ok(
        json!({ "dimension": dimension, "run": run, "steps": columns, "scene": scene, "live": false }),
    )
}
