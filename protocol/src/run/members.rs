//! Who takes part in a run: a file a seat in the run's folder, with process id and start time.
//!
//! The file is there from before the first message until the process leaves; a process that ended
//! while its file is still there was lost.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};

use crate::language::error::Error;

/// A process in a seat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Member {
    /// Process id.
    pub pid: u32,
    /// Start time in clock ticks since boot: tells a process from a later one with the same id.
    pub start: u64,
}

impl Member {
    /// Is this very process alive (and not only unreaped)?
    pub(crate) fn is_alive(self) -> bool {
        start_time(self.pid) == Some(self.start)
    }

    fn parse(text: &str) -> Option<Member> {
        let (pid, start) = text.trim().split_once(' ')?;
        Some(Member {
            pid: pid.parse().ok()?,
            start: start.parse().ok()?,
        })
    }
}

/// Folder of the seats.
pub(crate) fn folder(root: &Path) -> PathBuf {
    root.join("members")
}

/// Take a seat; refused while another living process has it.
pub(crate) fn join(root: &Path, seat: &str) -> Result<Member, Error> {
    let trouble =
        |e: std::io::Error| Error::memory(format!("seat {seat} in {}", root.display()), e);
    let _lock = lock(root).map_err(trouble)?;
    let path = folder(root).join(seat);
    if let Some(other) = read(&path).filter(|other| other.is_alive()) {
        let why = format!("process {} has this seat in the run already", other.pid);
        return Err(Error::Handshake {
            who: seat.to_owned(),
            why,
        });
    }
    let pid = std::process::id();
    let member = Member {
        pid,
        start: start_time(pid).unwrap_or(0),
    };
    write(&path, member).map_err(trouble)?;
    Ok(member)
}

/// Leave all seats of this process; `last` is called when no living process is left.
pub(crate) fn leave(root: &Path, last: impl FnOnce()) {
    let Ok(_lock) = lock_existing(root) else {
        return;
    };
    for (seat, member) in all(root) {
        if member.pid == std::process::id() {
            let path = folder(root).join(&seat);
            // Kept under another name: see `mark_lost`.
            let _ = fs::rename(&path, folder(root).join(format!(".{seat}.left")));
        }
    }
    if alive(root).is_empty() {
        last();
    }
}

/// Write a seat that nobody will take, unless it was taken before.
pub(crate) fn mark_lost(root: &Path, seat: &str) -> Result<(), Error> {
    let trouble =
        |e: std::io::Error| Error::memory(format!("seat {seat} in {}", root.display()), e);
    let _lock = lock(root).map_err(trouble)?;
    let path = folder(root).join(seat);
    if path.exists() || folder(root).join(format!(".{seat}.left")).exists() {
        return Ok(());
    }
    write(&path, Member { pid: 0, start: 0 }).map_err(trouble)
}

/// All seats taken, dead processes included.
pub(crate) fn all(root: &Path) -> BTreeMap<String, Member> {
    let entries = fs::read_dir(folder(root)).into_iter().flatten().flatten();
    entries
        .filter_map(|entry| {
            let seat = entry
                .file_name()
                .into_string()
                .ok()
                .filter(|name| !name.starts_with('.'))?;
            Some((seat, read(&entry.path())?))
        })
        .collect()
}

/// The seats of living processes.
pub(crate) fn alive(root: &Path) -> BTreeMap<String, Member> {
    all(root)
        .into_iter()
        .filter(|(_, member)| member.is_alive())
        .collect()
}

fn read(path: &Path) -> Option<Member> {
    Member::parse(&fs::read_to_string(path).ok()?)
}

fn write(path: &Path, member: Member) -> std::io::Result<()> {
    let part = path.with_extension("part");
    let hidden = part.with_file_name(format!(
        ".{}",
        part.file_name().unwrap_or_default().to_string_lossy()
    ));
    fs::write(&hidden, format!("{} {}\n", member.pid, member.start))?;
    fs::rename(&hidden, path)
}

fn lock(root: &Path) -> std::io::Result<File> {
    loop {
        fs::create_dir_all(folder(root))?;
        File::options()
            .create(true)
            .append(true)
            .open(root.join("lock"))?;
        match lock_existing(root) {
            // Removed between the two lines by the last one out of an earlier run of this name.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            other => return other,
        }
    }
}

fn lock_existing(root: &Path) -> std::io::Result<File> {
    let file = File::options().append(true).open(root.join("lock"))?;
    flock(&file, FlockOperation::LockExclusive)?;
    // Whoever held it before may have removed the run.
    if file.metadata()?.nlink() == 0 {
        return Err(std::io::ErrorKind::NotFound.into());
    }
    Ok(file)
}

/// Start time of a living process from /proc (field 22 of `stat`); zombies count as ended.
fn start_time(pid: u32) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace();
    let state = fields.next()?;
    if matches!(state, "Z" | "X" | "x") {
        return None;
    }
    fields.nth(18)?.parse().ok()
}
