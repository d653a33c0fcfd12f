//! The lock of a run's folder: who joins, leaves or removes holds it. Nobody waits for it without limit.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;

use super::{awake, limits, private};

/// Between two tries.
const PAUSE: Duration = Duration::from_millis(2);

/// Folder of the seats of a run.
pub(crate) fn seats(root: &Path) -> PathBuf {
    root.join("members")
}

/// Lock the folder of a run, which is made when there is none.
pub(crate) fn lock(root: &Path) -> io::Result<File> {
    let since = awake::now();
    loop {
        let locked = make(root).and_then(|()| lock_existing(root));
        match locked {
            // Removed in between by the last one out of an earlier run of this name.
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            other => return other,
        }
        if awake::now() - since > limits::LOCK.duration() {
            return Err(held_for_long(root));
        }
    }
}

fn make(root: &Path) -> io::Result<()> {
    private::folder(root)?;
    private::folder(&seats(root))?;
    private::open(
        private::options().create(true).append(true),
        &root.join("lock"),
    )?;
    Ok(())
}

/// The same without making the folder of a run that is gone, or that goes meanwhile.
pub(crate) fn lock_if_there(root: &Path) -> io::Result<Option<File>> {
    match lock_existing(root) {
        // Whoever made it was killed before it had a lock.
        Err(error) if error.kind() == ErrorKind::NotFound && root.exists() => lock(root).map(Some),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        other => other.map(Some),
    }
}

/// Lock a folder that is there.
pub(crate) fn lock_existing(root: &Path) -> io::Result<File> {
    private::ours(root)?;
    let since = awake::now();
    loop {
        if let Some(file) = try_lock(root)? {
            return Ok(file);
        }
        if awake::now() - since > limits::LOCK.duration() {
            return Err(held_for_long(root));
        }
        std::thread::sleep(PAUSE);
    }
}

/// The same without waiting; nothing when another process holds it.
pub(crate) fn try_lock(root: &Path) -> io::Result<Option<File>> {
    let path = root.join("lock");
    let file = private::open(private::options().append(true), &path)?;
    match flock(&file, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => {}
        Err(Errno::WOULDBLOCK) => return Ok(None),
        Err(error) => return Err(error.into()),
    }
    // Whoever held it before may have removed the run.
    if fs::symlink_metadata(&path)?.ino() != file.metadata()?.ino() {
        return Err(ErrorKind::NotFound.into());
    }
    Ok(Some(file))
}

fn held_for_long(root: &Path) -> io::Error {
    let seconds = limits::LOCK.duration().as_secs_f64();
    let why = format!(
        "{} is held by another process of this user for more than {seconds} s",
        root.join("lock").display()
    );
    io::Error::new(ErrorKind::TimedOut, why)
}
