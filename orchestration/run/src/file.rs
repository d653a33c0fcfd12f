//! Files that others may be reading.

use std::fs::File;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use scene::Error;

/// Write a file in one move, so that a reader never sees half of it.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    let draft = path.with_extension("part");
    let written = std::fs::write(&draft, content).and_then(|()| std::fs::rename(&draft, path));
    written.map_err(|error| {
        // Half a file takes room that others may need.
        let _ = std::fs::remove_file(&draft);
        Error::file("cannot write", path)(error)
    })
}

/// Remove a file, or a folder with all that is in it; nothing where there is none.
pub fn remove(path: &Path) -> Result<(), Error> {
    let removed = match path.symlink_metadata() {
        Err(_) => return Ok(()),
        Ok(about) if about.is_dir() => std::fs::remove_dir_all(path),
        Ok(_) => std::fs::remove_file(path),
    };
    removed.map_err(Error::file("cannot remove", path))
}

/// Wait until a file or a folder is on the disk.
pub fn sync(path: &Path) -> Result<(), Error> {
    let synced = File::open(path).and_then(|file| file.sync_all());
    synced.map_err(Error::file("cannot bring to the disk", path))
}

/// Now, as files say it.
pub fn seconds_since_1970() -> u64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |elapsed| elapsed.as_secs())
}
