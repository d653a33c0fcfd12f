//! The recording of a run: asked for, and passed on to the coupler.

use std::path::Path;

use serde_json::json;

use crate::error::Error;
use crate::keys::Record;
use crate::scene::Scene;

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
