//! What a run is called: in the environment of its processes, and in shared memory.

use std::path::{Path, PathBuf};

use super::private;

/// Where all of it is.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// Environment: identity of the run.
pub const ENV_RUN: &str = "SILLAGE_RUN";
/// Environment: process id of the orchestrator; absent when processes are started by hand.
pub const ENV_ORCHESTRATOR: &str = "SILLAGE_ORCHESTRATOR";
/// Environment: the run's token; without it, it is read in the run's folder.
pub const ENV_TOKEN: &str = "SILLAGE_TOKEN";

/// How the name of a folder that is being removed begins.
pub(crate) const REMOVED: &str = ".sillage-";

/// Folder of a run.
pub(crate) fn root(id: &str) -> PathBuf {
    Path::new(SHARED_MEMORY).join(format!("sillage-{id}"))
}

/// The part of a run's name that its files have: paths of sockets must not be long.
pub(crate) fn key(id: &str) -> &str {
    const LENGTH: usize = 10;
    match id.len() {
        private::RANDOM_LENGTH => id.get(..LENGTH).unwrap_or(id),
        _ => id,
    }
}

/// Prefix of a run's files in shared memory.
pub(crate) fn prefix(id: &str) -> String {
    format!("sillage{}_", key(id))
}

/// How names of the run's folders begin that are being removed.
pub(crate) fn removed(id: &str) -> String {
    format!("{REMOVED}{id}.")
}

/// Files in shared memory that are a run's, its folder among them.
pub fn files_of(id: &str) -> Vec<PathBuf> {
    let (prefix, folder, removed) = (prefix(id), format!("sillage-{id}"), removed(id));
    let entries = std::fs::read_dir(SHARED_MEMORY)
        .into_iter()
        .flatten()
        .flatten();
    let named = entries.filter(|entry| {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        name.starts_with(&prefix) || name == folder || name.starts_with(&removed)
    });
    named.map(|entry| entry.path()).collect()
}
