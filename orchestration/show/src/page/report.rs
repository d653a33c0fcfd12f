//! `sillage report`: the page of a run or a study as a file.

use std::path::{Path, PathBuf};

use run::file;
use scene::Error;

use super::document::{STUDY_FILE, document};
use super::html::page;

/// A report that was written.
pub struct Written {
    /// The file.
    pub file: PathBuf,
    /// Its size \[bytes\].
    pub bytes: usize,
    /// States in its animation.
    pub states: usize,
}

/// Write the report of a run folder or of a study's folder; `most` bounds the states in it.
pub fn write(folder: &Path, out: Option<&Path>, most: usize) -> Result<Written, Error> {
    let target = out.map_or_else(|| folder.join("report.html"), Path::to_path_buf);
    if folder.join(STUDY_FILE).is_file() {
        return copy_of_study(folder, target);
    }
    let document = document(folder, most)?;
    let states = document["frames"].as_array().map_or(0, Vec::len);
    let name = document["run"]["scene"]["name"].as_str().unwrap_or("run");
    let page = page(name, &document);
    let bytes = page.len();
    file::write(&target, page)?;
    Ok(Written {
        file: target,
        bytes,
        states,
    })
}

/// A study writes its page with its table, each time.
fn copy_of_study(folder: &Path, target: PathBuf) -> Result<Written, Error> {
    let own = folder.join("report.html");
    let page = std::fs::read_to_string(&own).map_err(Error::file("cannot read", &own))?;
    let bytes = page.len();
    if target != own {
        file::write(&target, page)?;
    }
    Ok(Written {
        file: target,
        bytes,
        states: 0,
    })
}
