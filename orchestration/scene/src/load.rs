//! From the text of a scene to the scene, or to all its problems at once.

use std::path::Path;

use crate::check::Checker;
use crate::document::Document;
use crate::error::Error;
use crate::problem::Problems;
use crate::scene::Scene;
use crate::{read, resolve};

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
