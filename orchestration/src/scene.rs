//! One TOML file → validated scene → what the coupler and the engines receive.
//!
//! Read in four steps: text (`document`), keys (`keys`, `read`), ranges (`check`), and resolution
//! of what is relative or left out (`boundaries`, `walls`, `resolve`). Problems carry file, line,
//! key and what is allowed; all range problems of a scene are reported at once.

pub mod boundaries;
pub mod check;
pub mod document;
pub mod keys;
pub mod mesh_names;
pub mod population_keys;
pub mod problem;
pub mod read;
pub mod resolve;
pub mod schema;
pub mod walls;

use std::path::{Path, PathBuf};

use protocol::configure::CouplerScene;

use crate::error::Error;
use crate::grains::GrainTable;
use check::Checker;
use document::Document;
use keys::{Engines, Output, Record};
use problem::Problems;

/// A scene that can be run.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Its file name without `.toml`.
    pub name: String,
    /// Folder of its file; engine commands start there.
    pub folder: PathBuf,
    /// Text of its file, as read.
    pub text: String,
    /// What the coupler receives.
    pub coupler: CouplerScene,
    /// The grains at t = 0.
    pub grains: GrainTable,
    /// Engines other than the built-in ones.
    pub engines: Engines,
    /// What is written.
    pub output: Output,
    /// The recording, when one is asked for.
    pub record: Option<Record>,
    /// May engines leave out what their bounds allow?
    pub leave_out: bool,
    /// What was asked for and will not happen, or may surprise.
    pub warnings: Vec<String>,
}

/// Load a scene with `--set` settings; `threads` is what each engine may use.
pub fn load(path: &Path, settings: &[String], threads: usize) -> Result<Scene, Error> {
    let document = Document::load(path, settings)?;
    from_document(&document, threads)
}

/// The same from a document in memory.
pub fn from_document(document: &Document, threads: usize) -> Result<Scene, Error> {
    let keys = read::read(document)?;
    let mut checker = Checker::new(document);
    checker.scene(&keys);
    stop_at_problems(&mut checker)?;
    let scene = resolve::resolve(document, keys, threads, &mut checker);
    stop_at_problems(&mut checker)?;
    Ok(scene)
}

fn stop_at_problems(checker: &mut Checker<'_>) -> Result<(), Error> {
    match std::mem::take(&mut checker.problems) {
        problems if problems.is_empty() => Ok(()),
        problems => Err(Error::Scene(Problems(problems))),
    }
}
