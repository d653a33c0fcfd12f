//! What dead runs left in shared memory, and whose runs this user cannot look into.

use std::collections::BTreeMap;
use std::fs::{self, Metadata};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::names::{REMOVED, SHARED_MEMORY, key, root};
use super::place::size_of;
use super::{lock, members, private};
use crate::language::error::Error;

/// What a run left behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Leftover {
    /// Identity of the run.
    pub id: String,
    /// Files left in shared memory, those in the run's folder included.
    pub files: usize,
    /// Bytes of memory they occupy.
    pub bytes: u64,
}

/// A run of another user, alive or not: only that user can say.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Foreign {
    /// Identity of the run, or the part of it that its files tell.
    pub id: String,
    /// The user's number.
    pub user: u32,
}

/// Everything that calls itself a run in shared memory.
pub(crate) fn survey() -> Result<(Vec<Leftover>, Vec<Foreign>), Error> {
    // A run has its folder before it has other files, and loses it after them.
    let files = entries(|name| segment_of(name).map(String::from))?;
    let mut folders = entries(|name| folder_of(name).map(String::from))?;
    for (id, places) in files {
        let own = folders.keys().find(|folder| key(folder) == id).cloned();
        folders.entry(own.unwrap_or(id)).or_default().extend(places);
    }
    let (mut left, mut foreign) = (Vec::new(), Vec::new());
    for (id, places) in folders {
        match places.iter().find(|(_, about)| !private::is_ours(about)) {
            Some((_, about)) => {
                let user = about.uid();
                foreign.push(Foreign { id, user });
            }
            None if is_over(&root(&id)) => left.extend(leftover(id, &places)),
            None => {}
        }
    }
    Ok((left, foreign))
}

/// Has every process of this run ended?
fn is_over(root: &Path) -> bool {
    let busy = matches!(lock::try_lock(root), Ok(None));
    !busy && members::alive(root).is_empty()
}

type Places = Vec<(PathBuf, Metadata)>;

fn leftover(id: String, places: &Places) -> Option<Leftover> {
    let sizes = places.iter().map(|(path, _)| size_of(path));
    let (files, bytes) = sizes.fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    let there = places.iter().any(|(path, _)| path.exists());
    there.then_some(Leftover { id, files, bytes })
}

/// What is in shared memory under names that are somebody's.
fn entries(whose: impl Fn(&str) -> Option<String>) -> Result<BTreeMap<String, Places>, Error> {
    let mut found: BTreeMap<String, Places> = BTreeMap::new();
    let entries = fs::read_dir(SHARED_MEMORY).map_err(|e| Error::memory(SHARED_MEMORY, e))?;
    for entry in entries.flatten() {
        let whose = entry.file_name().to_str().and_then(&whose);
        if let (Some(id), Ok(about)) = (whose, entry.metadata()) {
            found.entry(id).or_default().push((entry.path(), about));
        }
    }
    Ok(found)
}

fn folder_of(name: &str) -> Option<&str> {
    let hidden = name.strip_prefix(REMOVED);
    let hidden = hidden.and_then(|rest| rest.split('.').next());
    hidden.or_else(|| name.strip_prefix("sillage-"))
}

fn segment_of(name: &str) -> Option<&str> {
    let (id, _) = name.strip_prefix("sillage")?.split_once('_')?;
    (!id.starts_with('-')).then_some(id)
}
