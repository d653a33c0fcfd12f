//! What may be written to a folder that somebody names: nothing of another origin is touched.

use std::path::Path;

use scene::Error;
use serde_json::Value;

/// What a command writes to a folder, and how it knows it again.
pub struct Claim {
    /// "run", "study", …
    pub what: &'static str,
    /// The file that every complete folder of this kind has.
    pub mark: &'static str,
    /// What an incomplete one may consist of.
    pub parts: &'static [&'static str],
}

/// A run folder.
pub const RUN: Claim = Claim {
    what: "run",
    mark: "run.json",
    parts: &[
        ".lock",
        ".reserve",
        ".previous",
        ".discarded",
        "not-started",
        "point.json",
        "logs",
    ],
};

impl Claim {
    /// Refuse a folder that holds something of another origin, before anything in it is touched. A folder
    /// that is not there, or is empty, is free.
    pub fn check(&self, folder: &Path) -> Result<(), Error> {
        let refuse = |why: String| Err(Error::Usage(format!("--out {}: {why}", folder.display())));
        if folder.as_os_str().is_empty() {
            return Err(Error::Usage("--out is empty: name a folder".to_owned()));
        }
        if folder.exists() && !folder.is_dir() {
            return refuse("is not a folder".to_owned());
        }
        let Ok(entries) = std::fs::read_dir(folder) else {
            // What cannot be listed, and is there, fails when it is written to.
            return Ok(());
        };
        if self.is_marked(folder) {
            return Ok(());
        }
        let mut names = entries.flatten().map(|entry| entry.file_name());
        match names.find(|name| !self.parts.iter().any(|part| name == part)) {
            None => Ok(()),
            Some(name) => refuse(format!(
                "holds {} and no {} of sillage, which would be replaced: choose another folder",
                name.to_string_lossy(),
                self.what
            )),
        }
    }

    /// Does the folder have the file of its kind? That of a run is looked into: others have a run.json too.
    fn is_marked(&self, folder: &Path) -> bool {
        let mark = folder.join(self.mark);
        if self.mark != RUN.mark || folder.join("point.json").is_file() {
            return mark.is_file();
        }
        let text = std::fs::read_to_string(mark).unwrap_or_default();
        let document: Value = serde_json::from_str(&text).unwrap_or_default();
        document["versions"]["sillage"].is_string()
    }
}

/// Refuse the folder of a scene: its own files would be replaced.
pub fn is_not_of_scene(folder: &Path, scene: &Path) -> Result<(), Error> {
    let same = match (folder.canonicalize(), scene.canonicalize()) {
        (Ok(folder), Ok(scene)) => folder == scene,
        _ => false,
    };
    match same {
        false => Ok(()),
        true => Err(Error::Usage(format!(
            "--out {}: the scene itself lies there, and its files would be replaced: choose another folder",
            folder.display()
        ))),
    }
}
