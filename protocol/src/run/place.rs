//! Where a run is in shared memory: its folder, its files, and their removal.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use crate::language::error::Error;

use super::members;

pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// Held while this process makes files in shared memory: a watching thread that ends the process
/// takes it first, so that nothing is made after the removal.
static MAKING_FILES: Mutex<()> = Mutex::new(());

/// Hold it while files are made (ports, first or larger buffers).
pub(crate) fn making_files() -> MutexGuard<'static, ()> {
    MAKING_FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The same with a limit, for a process that is about to end.
pub(crate) fn stop_making_files() -> Option<MutexGuard<'static, ()>> {
    const ATTEMPTS: u32 = 100;
    for _ in 0..ATTEMPTS {
        match MAKING_FILES.try_lock() {
            Ok(guard) => return Some(guard),
            Err(TryLockError::Poisoned(guard)) => return Some(guard.into_inner()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(10)),
        }
    }
    None
}

/// Give up all seats of this process; the last one out removes the run.
pub(crate) fn leave(id: &str) {
    members::leave(&root(id), || {
        remove_run(id);
    });
}

/// Folder of a run.
pub(crate) fn root(id: &str) -> PathBuf {
    Path::new(SHARED_MEMORY).join(format!("sillage-{id}"))
}

/// Prefix of a run's files in shared memory.
pub(crate) fn prefix(id: &str) -> String {
    format!("sillage{id}_")
}

/// Refuse when shared memory has less than `bytes` left: a page that does not fit kills with SIGBUS.
pub(crate) fn preflight(bytes: u64) -> Result<(), Error> {
    let status = rustix::fs::statvfs(SHARED_MEMORY).map_err(|e| Error::memory(SHARED_MEMORY, e))?;
    let free = status.f_bavail.saturating_mul(status.f_frsize);
    if free < bytes {
        let megabytes = |b: u64| b as f64 / 1e6;
        let why = format!(
            "{:.1} MB are free and {:.1} MB needed; enlarge it (container: --shm-size=1g) or see `sillage doctor`",
            megabytes(free),
            megabytes(bytes)
        );
        return Err(Error::memory(SHARED_MEMORY, why));
    }
    Ok(())
}

/// Files and bytes at a path, folders with what is in them.
pub(crate) fn size_of(path: &Path) -> (usize, u64) {
    use std::os::unix::fs::MetadataExt;
    let Ok(meta) = fs::symlink_metadata(path) else {
        return (0, 0);
    };
    if !meta.is_dir() {
        return (1, meta.blocks() * 512);
    }
    let entries = fs::read_dir(path).into_iter().flatten().flatten();
    entries
        .map(|entry| size_of(&entry.path()))
        .fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
}

/// Files first, the folder with the members last: an interrupted removal is found again.
pub(crate) fn remove_run(id: &str) -> usize {
    let prefix = prefix(id);
    let mut removed = 0;
    for entry in fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(&prefix) {
            removed += usize::from(fs::remove_file(entry.path()).is_ok());
        }
    }
    let (files, _) = size_of(&root(id));
    if fs::remove_dir_all(root(id)).is_ok() {
        removed += files;
    }
    removed
}
