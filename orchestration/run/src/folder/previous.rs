//! An earlier run in the same folder: set aside until the new one has started, so that a start that fails
//! costs nothing.
//!
//! ```text
//!   earlier run ──set aside──► .previous/ ──the new one started──► gone
//!                                   └──it did not──► back again; what that one left: not-started/
//! ```
//!
//! A process that is killed in between leaves `.previous/`; the next run begins by taking it back.

use std::path::{Path, PathBuf};

use scene::Error;

use super::recorded;
use crate::file::remove;

/// What a run writes to its folder, beside its recording.
const WRITTEN: [&str; 15] = [
    "run.json",
    "scene.toml",
    "scene.json",
    "grains.csv",
    "steps.csv",
    "steps.units.csv",
    "fluid.pvd",
    "grains.pvd",
    "overview.png",
    "report.html",
    "vtu",
    "frames",
    "logs",
    "checkpoints",
    "failed-step.mcap",
];
const ASIDE: &str = ".previous";
const DISCARDED: &str = ".discarded";
/// What a run left that did not start, where an earlier one was kept.
pub const NOT_STARTED: &str = "not-started";

/// An earlier run that is set aside.
pub struct Previous {
    folder: PathBuf,
}

impl Previous {
    /// Set the run in this folder aside; none when there is none.
    pub fn set_aside(folder: &Path) -> Result<Option<Previous>, Error> {
        remove(&folder.join(DISCARDED))?;
        let (previous, aside) = (
            Previous {
                folder: folder.to_path_buf(),
            },
            folder.join(ASIDE),
        );
        if aside.exists() {
            previous.take_back()?;
        }
        if !folder.join("run.json").exists() {
            return Ok(None);
        }
        make(&aside)?;
        for name in written(folder) {
            rename(&folder.join(&name), &aside.join(&name))?;
        }
        Ok(Some(previous))
    }

    /// The new run has started: the earlier one goes.
    pub fn discard(self) -> Result<(), Error> {
        let discarded = self.folder.join(DISCARDED);
        // In one move, so that nobody takes half of it back.
        rename(&self.folder.join(ASIDE), &discarded)?;
        remove(&discarded)
    }

    /// The new run has not started: the earlier one comes back, and what the new one left goes to a folder
    /// of its own.
    pub fn restore(self) -> Result<(), Error> {
        let left = self.folder.join(NOT_STARTED);
        remove(&left)?;
        make(&left)?;
        for name in written(&self.folder) {
            rename(&self.folder.join(&name), &left.join(&name))?;
        }
        self.take_back()
    }

    /// Move all that is set aside back, over what is there.
    fn take_back(&self) -> Result<(), Error> {
        let aside = self.folder.join(ASIDE);
        for name in written(&aside) {
            let target = self.folder.join(&name);
            remove(&target)?;
            rename(&aside.join(&name), &target)?;
        }
        remove(&aside)
    }
}

/// What a run has written to this folder.
fn written(folder: &Path) -> Vec<PathBuf> {
    let recording = recorded::in_folder(folder).and_then(|file| {
        let name = file.strip_prefix(folder).ok()?;
        Some(name.to_path_buf())
    });
    let all = WRITTEN.iter().map(PathBuf::from).chain(recording);
    all.filter(|name| folder.join(name).exists()).collect()
}

fn make(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(Error::file("cannot create", folder))
}

fn rename(from: &Path, to: &Path) -> Result<(), Error> {
    if let Some(parent) = to.parent() {
        make(parent)?;
    }
    std::fs::rename(from, to).map_err(Error::file("cannot move", from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_earlier_run_comes_back_when_the_new_one_does_not_start_and_goes_when_it_does() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path();
        let write = |name: &str, text: &str| {
            std::fs::create_dir_all(folder.join("logs")).expect("made");
            std::fs::write(folder.join(name), text).expect("written");
        };
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap_or_default();
        for name in ["run.json", "steps.csv", "logs/fluid.log", "notes.txt"] {
            write(name, "old");
        }
        let previous = Previous::set_aside(folder).expect("moved").expect("a run");
        assert!(!folder.join("run.json").exists());
        write("run.json", "new");
        write("logs/fluid.log", "new");
        previous.restore().expect("moved back");
        for name in ["run.json", "steps.csv", "logs/fluid.log", "notes.txt"] {
            assert_eq!(read(name), "old", "{name}");
        }
        assert_eq!(read("not-started/logs/fluid.log"), "new");

        // killed between the two: the next one finds the earlier run where it was
        let forgotten = Previous::set_aside(folder).expect("moved");
        write("run.json", "new");
        drop(forgotten);
        let previous = Previous::set_aside(folder).expect("moved").expect("a run");
        assert_eq!(read(".previous/run.json"), "old");
        write("run.json", "new");
        previous.discard().expect("gone");
        assert_eq!(
            (read("run.json"), read("steps.csv")),
            ("new".into(), String::new())
        );
        assert!(!folder.join(ASIDE).exists() && !folder.join(DISCARDED).exists());
    }
}
