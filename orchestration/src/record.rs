//! The recording of a run, as the orchestrator sees it: asked for, passed on, told about.

use std::path::{Path, PathBuf};

use protocol::messages::Diagnostic;
use serde_json::{Value, json};

use crate::error::Error;
use crate::scene::Scene;
use crate::scene::keys::Record;

/// Ask for a recording on the command line; an empty name leaves it to the scene.
pub fn request(scene: &mut Scene, file: &str) -> Result<(), Error> {
    let record = scene.record.get_or_insert_with(Record::default);
    if !file.is_empty() {
        check_file(file).map_err(|why| Error::Usage(format!("--record={file}: {why}")))?;
        record.file = file.to_string();
    }
    Ok(())
}

/// A name that cannot be that of another file of the run folder.
pub fn check_file(file: &str) -> Result<(), String> {
    if Path::new(file).extension().is_some_and(|end| end == "mcap") {
        return Ok(());
    }
    Err("must name a file that ends in .mcap, e.g. \"exchange.mcap\"".to_string())
}

/// What the coupler is told.
pub fn arguments(record: &Record, folder: &Path) -> Vec<String> {
    let path = folder.join(&record.file);
    let mut arguments = vec!["--record".to_string(), path.to_string_lossy().into_owned()];
    let compression = json!(record.compression);
    if record.compression != Default::default() {
        arguments.push("--record-compression".to_string());
        arguments.push(compression.as_str().unwrap_or_default().to_string());
    }
    arguments
}

/// The recording in `run.json`: complete only when the coupler says so.
pub fn report(record: &Record, totals: &[Diagnostic], why: Option<&str>) -> Value {
    let total = |name: &str| {
        let found = totals.iter().find(|total| total.name == name);
        found.map(|total| total.value)
    };
    let count = |name: &str| total(name).map(|value| value as u64);
    json!({
        "file": record.file,
        "compression": record.compression,
        "complete": total("recording_complete") == Some(1.0),
        "why": why,
        "messages": count("recording_messages"),
        "bytes": count("recording_bytes"),
    })
}

/// The recording of an earlier run in this folder, as its `run.json` names it.
pub fn in_folder(folder: &Path) -> Option<PathBuf> {
    let text = std::fs::read_to_string(folder.join("run.json")).ok()?;
    let document: Value = serde_json::from_str(&text).ok()?;
    let file = document["recording"]["file"].as_str()?;
    check_file(file).ok()?;
    Some(folder.join(file))
}

/// The recording that a path means: the file itself, or that of a run folder.
pub fn find(path: &Path) -> Result<PathBuf, Error> {
    if !path.is_dir() {
        return Ok(path.to_path_buf());
    }
    in_folder(path).ok_or_else(|| {
        Error::Usage(format!(
            "{} has no recording: run the scene with --record",
            path.display()
        ))
    })
}
