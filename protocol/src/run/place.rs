//! A run's place in shared memory: room, files that are made there, and their removal.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use crate::language::error::Error;

use super::names::{SHARED_MEMORY, files_of, removed, root};
use super::{members, private, strays};

/// Shared memory that every process needs at least, for its messages \[bytes\].
pub(crate) const SMALLEST: u64 = 4 << 20;

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

/// Give up all seats of this process; the last one out removes the run. What processes of the run started
/// ends with it, also when nobody is left to do it but a process that lost its orchestrator.
pub(crate) fn leave(id: &str) {
    let root = root(id);
    let orchestrator = "orchestrator";
    let orphan =
        members::all(&root).contains_key(orchestrator) && !members::is_held(&root, orchestrator);
    if orphan {
        // A member that is stopped will not notice by itself.
        let mut spared = members::ever(&root);
        spared.retain(|process| !strays::is_stopped(*process));
        strays::end(id, &spared);
    }
    members::leave(&root, || {
        strays::end(id, &members::ever(&root));
        let _ = remove_run(id);
    });
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

/// Take from others what the transport gives them: one segment of a node, which it makes for everybody.
pub(crate) fn close_shared(prefix: &str) -> Result<(), Error> {
    const SHARED_BY_ALL: &str = ".global_mgmt";
    let entries = fs::read_dir(SHARED_MEMORY).map_err(|e| Error::memory(SHARED_MEMORY, e))?;
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(prefix) && name.ends_with(SHARED_BY_ALL) {
            let closed = private::close_to_others(&entry.path());
            closed.map_err(|e| Error::memory(name.into_owned(), e))?;
        }
    }
    Ok(())
}

/// Remove segments that have no size yet: the transport waits without end for one whose maker was killed
/// before it had. A run that lost somebody needs none of them any more.
pub(crate) fn remove_unfinished(id: &str) {
    let unfinished = |path: &PathBuf| {
        fs::symlink_metadata(path).is_ok_and(|about| about.is_file() && about.len() == 0)
    };
    for path in files_of(id).iter().filter(|path| unfinished(path)) {
        let _ = fs::remove_file(path);
    }
}

/// Files first, the folder with the members last, under another name: an interrupted removal is found
/// again, and a run of the same name that begins meanwhile makes a folder of its own. Returns the number
/// of files removed; the lock of the run is held.
pub(crate) fn remove_run(id: &str) -> Result<usize, Error> {
    let (mut count, mut trouble) = (0, None);
    let root = root(id);
    for path in files_of(id).into_iter().filter(|path| *path != root) {
        let (files, _) = size_of(&path);
        let gone = match path.is_dir() {
            true => fs::remove_dir_all(&path),
            false => fs::remove_file(&path),
        };
        match gone {
            Ok(()) => count += files,
            Err(error) => {
                trouble = Some(Error::memory(
                    format!("removal of {}", path.display()),
                    error,
                ))
            }
        }
    }
    if fs::symlink_metadata(&root).is_ok() {
        let (files, _) = size_of(&root);
        match remove_folder(id) {
            Ok(()) => count += files,
            Err(error) => {
                trouble = Some(Error::memory(
                    format!("removal of {}", root.display()),
                    error,
                ))
            }
        }
    }
    trouble.map_or(Ok(count), Err)
}

fn remove_folder(id: &str) -> std::io::Result<()> {
    let aside = format!("{}{}", removed(id), private::random()?);
    let aside = Path::new(SHARED_MEMORY).join(aside);
    fs::rename(root(id), &aside)?;
    fs::remove_dir_all(&aside)
}
