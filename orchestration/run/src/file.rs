//! Files that others may be reading.

use std::path::Path;

use scene::Error;

/// Write a file in one move, so that a reader never sees half of it.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
    let draft = path.with_extension("part");
    std::fs::write(&draft, content).map_err(Error::file("cannot write", &draft))?;
    std::fs::rename(&draft, path).map_err(Error::file("cannot write", path))
}
