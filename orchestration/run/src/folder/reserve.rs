//! Room that is kept for the last word of a run, on a disk that may be full by then.

use std::fs::OpenOptions;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use scene::Error;

const FILE: &str = ".reserve";

/// A file that takes room until it is spent or dropped.
#[derive(Debug)]
pub struct Reserve {
    path: PathBuf,
}

impl Reserve {
    /// Take room for so many bytes on the disk of this folder.
    pub fn take(folder: &Path, bytes: usize) -> Result<Reserve, Error> {
        let path = folder.join(FILE);
        let reserve = Reserve { path };
        // Written, since a hole in a file takes no room.
        std::fs::write(&reserve.path, vec![b' '; bytes])
            .map_err(Error::file("cannot write", &reserve.path))?;
        Ok(reserve)
    }

    /// Write a file of the same folder in one move, in the room that is kept: where the content fits in, no
    /// more of the disk is needed.
    pub fn spend(self, target: &Path, content: &str) -> Result<(), Error> {
        let file = OpenOptions::new().write(true).open(&self.path);
        let written = file.and_then(|file| {
            file.write_all_at(content.as_bytes(), 0)?;
            file.set_len(content.len() as u64)?;
            std::fs::rename(&self.path, target)
        });
        written.map_err(Error::file("cannot write", target))
    }
}

impl Drop for Reserve {
    fn drop(&mut self) {
        // Spent, it has another name.
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::MetadataExt;

    use super::*;

    #[test]
    fn what_is_spent_is_the_room_that_was_taken() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, target) = (folder.path().join(FILE), folder.path().join("run.json"));
        std::fs::write(&target, "old").expect("written");
        let about = |path: &Path| path.metadata().expect("there");
        let reserve = Reserve::take(folder.path(), 10_000).expect("room");
        let taken = about(&path);
        println!("{} bytes in {} blocks", taken.len(), taken.blocks());
        assert!(taken.blocks() * 512 >= 10_000);
        reserve.spend(&target, "new").expect("spent");
        assert_eq!(about(&target).ino(), taken.ino());
        assert_eq!(std::fs::read_to_string(&target).expect("read"), "new");
        assert!(!path.exists());
        drop(Reserve::take(folder.path(), 10).expect("room"));
        assert!(!path.exists());
    }
}
