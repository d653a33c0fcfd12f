//! Checkpoints of a run: completed, found again, and looked at before they are trusted.
//!
//! ```text
//!   draft of the coupler ──outputs, manifest, fsync──► complete in one move ──► all but the newest go
//! ```

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use protocol::checkpoints::{FOLDER, complete as name_of, draft, step_of};
use protocol::message::{Hello, Role};
use scene::Error;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::outputs::Outputs;
use crate::file::{self, remove, sync};
use crate::version;

/// Layout of a checkpoint.
const FORMAT: u32 = 1;
const MANIFEST: &str = "manifest.json";
const OUTPUTS: &str = "outputs";

/// What a checkpoint is, and a checksum of each of its files.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Manifest {
    format: u32,
    versions: Value,
    step: u64,
    time: f64,
    engines: Vec<Engine>,
    parts: BTreeMap<String, Part>,
    /// Of the text of all before.
    checksum: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Engine {
    role: Role,
    engine: String,
    version: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Part {
    bytes: u64,
    crc32: u32,
}

/// A checkpoint that can be trusted.
#[derive(Debug)]
pub struct Checkpoint {
    /// Its folder.
    pub folder: PathBuf,
    /// The step it was made after.
    pub step: u64,
    /// The time of that \[s\].
    pub time: f64,
    /// What had been put out.
    pub outputs: Outputs,
}

/// The folder of the checkpoint of a step.
pub fn folder(run: &Path, step: u64) -> PathBuf {
    run.join(FOLDER).join(name_of(step))
}

/// Is there a draft of this step?
pub fn is_drafted(run: &Path, step: u64) -> bool {
    run.join(FOLDER).join(draft(step)).is_dir()
}

/// Complete the draft of a step; of the checkpoints of this run only the newest `keep` stay.
pub fn complete(
    run: &Path,
    (step, time): (u64, f64),
    engines: &[Hello],
    outputs: &Outputs,
    keep: u32,
) -> Result<(), Error> {
    let all = run.join(FOLDER);
    let (folder, target) = (all.join(draft(step)), all.join(name_of(step)));
    outputs.write(&folder.join(OUTPUTS))?;
    let mut parts = BTreeMap::new();
    for path in files(&folder)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name != MANIFEST {
            sync(&path)?;
            parts.insert(name.into_owned(), part(&path)?);
        }
    }
    let engine = |hello: &Hello| Engine {
        role: hello.role,
        engine: hello.engine.clone(),
        version: hello.version.clone(),
    };
    let mut manifest = Manifest {
        format: FORMAT,
        versions: version::all(),
        step,
        time,
        engines: engines.iter().map(engine).collect(),
        parts,
        checksum: 0,
    };
    manifest.checksum = checksum(&manifest);
    let path = folder.join(MANIFEST);
    let text = serde_json::to_string_pretty(&manifest).unwrap_or_default() + "\n";
    file::write(&path, text)?;
    sync(&path)?;
    sync(&folder)?;
    remove(&target)?;
    std::fs::rename(&folder, &target).map_err(Error::file("cannot complete", &target))?;
    sync(&all)?;
    let steps = steps(run);
    let old = steps.len().saturating_sub(keep as usize);
    steps[..old]
        .iter()
        .try_for_each(|&step| remove(&all.join(name_of(step))))
}

/// Steps of which there are complete checkpoints, in ascending order.
pub fn steps(run: &Path) -> Vec<u64> {
    let entries = std::fs::read_dir(run.join(FOLDER)).into_iter().flatten();
    let names = entries.flatten().map(|entry| entry.file_name());
    let mut steps: Vec<u64> = names.filter_map(|name| step_of(name.to_str()?)).collect();
    steps.sort_unstable();
    steps
}

/// The newest checkpoint that is whole, or that of the step `from`; those that are not are told of. None when
/// there is none at all.
pub fn newest(
    run: &Path,
    from: Option<u64>,
    mut tell: impl FnMut(&str),
) -> Result<Option<Checkpoint>, Error> {
    let steps = steps(run);
    if let Some(from) = from.filter(|from| !steps.contains(from)) {
        let there: Vec<String> = steps.iter().map(u64::to_string).collect();
        return Err(Error::Usage(format!(
            "--from {from}: there is no checkpoint of this step (there are: {})",
            match there.is_empty() {
                true => "none".to_owned(),
                false => there.join(", "),
            }
        )));
    }
    let wanted = steps
        .iter()
        .rev()
        .filter(|step| from.is_none_or(|from| **step == from));
    let mut broken = Vec::new();
    for &step in wanted {
        match open(run, step) {
            Ok(checkpoint) => return Ok(Some(checkpoint)),
            Err(why) => {
                tell(&format!(
                    "the checkpoint of step {step} cannot be used: {why}"
                ));
                broken.push(why);
            }
        }
    }
    match broken.pop() {
        None => Ok(None),
        Some(why) => Err(Error::Usage(format!(
            "{}: no checkpoint can be used ({why}); `sillage run` begins again",
            run.display()
        ))),
    }
}

/// Remove the drafts, and the checkpoints of later steps.
pub fn forget_after(run: &Path, step: u64) -> Result<(), Error> {
    let all = run.join(FOLDER);
    for later in steps(run).into_iter().filter(|later| *later > step) {
        remove(&all.join(name_of(later)))?;
    }
    let entries = std::fs::read_dir(&all).into_iter().flatten().flatten();
    let drafts = entries.map(|entry| entry.path());
    drafts
        .filter(|path| path.extension().is_some_and(|end| end == "part"))
        .try_for_each(|path| remove(&path))
}

fn open(run: &Path, step: u64) -> Result<Checkpoint, String> {
    let folder = folder(run, step);
    let text = std::fs::read_to_string(folder.join(MANIFEST))
        .map_err(|error| format!("{MANIFEST} cannot be read: {error}"))?;
    let document: Value =
        serde_json::from_str(&text).map_err(|error| format!("{MANIFEST} is damaged: {error}"))?;
    if let Some(format) = document["format"]
        .as_u64()
        .filter(|format| *format != u64::from(FORMAT))
    {
        let by = document["versions"]["sillage"]
            .as_str()
            .unwrap_or("another version");
        return Err(format!(
            "its format is {format}, this sillage reads {FORMAT}: take the one that wrote it, {by}"
        ));
    }
    let manifest: Manifest =
        serde_json::from_value(document).map_err(|e| format!("{MANIFEST} is damaged: {e}"))?;
    if manifest.checksum != checksum(&manifest) || manifest.step != step {
        return Err(format!("{MANIFEST} is damaged: its checksum does not fit"));
    }
    for (name, expected) in &manifest.parts {
        let found = part(&folder.join(name)).map_err(|error| error.to_string())?;
        if found != *expected {
            return Err(format!(
                "`{name}` is damaged: {} bytes with the checksum {:08x}, expected {} with {:08x}",
                found.bytes, found.crc32, expected.bytes, expected.crc32
            ));
        }
    }
    let outputs = Outputs::read(&folder.join(OUTPUTS))?;
    Ok(Checkpoint {
        folder,
        step,
        time: manifest.time,
        outputs,
    })
}

/// Of a manifest, whatever checksum it names.
fn checksum(manifest: &Manifest) -> u32 {
    let bare = Manifest {
        checksum: 0,
        ..manifest.clone()
    };
    crc32fast::hash(&serde_json::to_vec(&bare).unwrap_or_default())
}

fn part(path: &Path) -> Result<Part, Error> {
    let unreadable = || Error::file("cannot read", path);
    let mut reader = BufReader::new(File::open(path).map_err(unreadable())?);
    let (mut hasher, mut bytes) = (crc32fast::Hasher::new(), 0);
    let mut piece = vec![0; 1 << 16];
    loop {
        match reader.read(&mut piece).map_err(unreadable())? {
            0 => break,
            read => {
                hasher.update(&piece[..read]);
                bytes += read as u64;
            }
        }
    }
    let crc32 = hasher.finalize();
    Ok(Part { bytes, crc32 })
}

fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = std::fs::read_dir(folder).map_err(Error::file("cannot read", folder))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    Ok(files)
}
