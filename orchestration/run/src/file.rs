//! Files that others may be reading.

use std::path::Path;

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
