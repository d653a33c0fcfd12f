//! From the text of a scene to the scene, or to all its problems at once.

use std::path::Path;

use space::Dim;

use crate::check::Checker;
use crate::dimensions::Scenic;
use crate::document::Document;
use crate::error::Error;
use crate::keys::SceneFile;
use crate::problem::{Problem, Problems};
use crate::scene::Scene;
use crate::{read, resolve};

/// Load a scene with `--set` settings; `threads` is what each engine may use.
pub fn load(path: &Path, settings: &[String], threads: usize) -> Result<Scene, Error> {
    let document = Document::load(path, settings)?;
    from_document(&document, threads)
}

/// The same from a document in memory.
pub fn from_document(document: &Document, threads: usize) -> Result<Scene, Error> {
    match read::dimension(document) {
        3 => load_in::<3>(document, threads),
        _ => load_in::<2>(document, threads),
    }
}

/// Problems of the keys of a document, one by one, before anything is made of them; an error where it cannot be
/// read at all.
pub fn problems_of_keys(document: &Document) -> Result<Vec<Problem>, Error> {
    fn of<const D: usize>(document: &Document) -> Result<Vec<Problem>, Error>
    where
        Dim<D>: Scenic<D>,
    {
        let mut checker = Checker::new(document);
        checker.scene(&read::read::<D>(document)?);
        Ok(checker.problems)
    }
    match read::dimension(document) {
        3 => of::<3>(document),
        _ => of::<2>(document),
    }
}

fn load_in<const D: usize>(document: &Document, threads: usize) -> Result<Scene, Error>
where
    Dim<D>: Scenic<D>,
{
    let keys: SceneFile<D> = read::read(document)?;
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
