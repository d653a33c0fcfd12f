//! The recording of a run: its file, and what the coupler is told.

use std::path::Path;

use serde_json::json;

use crate::keys::Record;

/// A name that cannot be that of another file of the run folder.
pub fn check_file(file: &str) -> Result<(), String> {
    if Path::new(file).extension().is_some_and(|end| end == "mcap") {
        return Ok(());
    }
    Err("must name a file that ends in .mcap, e.g. \"exchange.mcap\"".to_string())
}

/// What the coupler is told of its recording.
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
