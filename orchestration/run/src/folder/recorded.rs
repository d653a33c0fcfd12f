//! The recording of a run, in its folder: told about and found again.

use std::path::{Path, PathBuf};

use protocol::message::Diagnostic;
use scene::Error;
use scene::keys::Record;
use scene::record::check_file;
use serde_json::{Value, json};

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
