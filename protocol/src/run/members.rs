//! Who takes part in a run: a file a seat in the run's folder, with process id and start time.
//!
//! The file is there from before the first message until the process leaves, and the process holds a
//! lock on it (`flock`) as long as it lives: the kernel's, so that it means the same to every process that
//! sees the folder, also from another container. A process that ended while its file is still there was
//! lost.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rustix::fs::{FlockOperation, flock};

use super::lock::{lock, lock_existing, seats as folder};
use super::private;
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
    fn parse(text: &str) -> Option<Member> {
        let (pid, start) = text.trim().split_once(' ')?;
        Some(Member {
            pid: pid.parse().ok()?,
            start: start.parse().ok()?,
        })
    }
}

/// A seat that this process holds: as long as the file is open, its lock says so.
struct Held {
    path: PathBuf,
    _lock: File,
}

static HELD: Mutex<Vec<Held>> = Mutex::new(Vec::new());

fn held() -> MutexGuard<'static, Vec<Held>> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// File with the token of a run, which whoever comes first makes.
pub(crate) fn token_file(root: &Path) -> PathBuf {
    root.join("token")
}

/// Take a seat; refused while another living process has it.
pub(crate) fn join(root: &Path, seat: &str) -> Result<Member, Error> {
    let trouble =
        |e: std::io::Error| Error::memory(format!("seat {seat} in {}", root.display()), e);
    let _lock = lock(root).map_err(trouble)?;
    private::secret(&token_file(root)).map_err(trouble)?;
    let path = folder(root).join(seat);
    if is_held(root, seat) {
        let other = read(&path).map_or(0, |other| other.pid);
        let why = format!("process {other} has this seat in the run already");
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
    let file = write(&path, member).map_err(trouble)?;
    held().push(Held { path, _lock: file });
    Ok(member)
}

/// Leave all seats of this process; `last` is called when no living process is left.
pub(crate) fn leave(root: &Path, last: impl FnOnce()) {
    let lock = lock_existing(root);
    let mine = |held: &Held| held.path.parent() == Some(&folder(root));
    let seats: Vec<Held> = held().extract_if(.., |held| mine(held)).collect();
    for Held { path, .. } in &seats {
        let seat = path.file_name().unwrap_or_default().to_string_lossy();
        // Kept under another name: see `mark_lost`.
        let _ = fs::rename(path, folder(root).join(format!(".{seat}.left")));
    }
    drop(seats);
    if lock.is_ok() && alive(root).is_empty() {
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
    write(&path, Member { pid: 0, start: 0 })
        .map(drop)
        .map_err(trouble)
}

/// All seats taken, dead processes included.
pub(crate) fn all(root: &Path) -> BTreeMap<String, Member> {
    files(root)
        .filter(|name| !name.starts_with('.'))
        .filter_map(|seat| {
            let member = read(&folder(root).join(&seat))?;
            Some((seat, member))
        })
        .collect()
}

/// Process ids that have, or had, a seat.
pub(crate) fn ever(root: &Path) -> Vec<u32> {
    files(root)
        .filter_map(|name| Some(read(&folder(root).join(name))?.pid))
        .collect()
}

fn files(root: &Path) -> impl Iterator<Item = String> {
    let entries = fs::read_dir(folder(root)).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().into_string().ok())
}

/// The seats of living processes.
pub(crate) fn alive(root: &Path) -> BTreeMap<String, Member> {
    let mut seats = all(root);
    seats.retain(|seat, _| is_held(root, seat));
    seats
}

/// The seats of other living processes.
pub(crate) fn others(root: &Path) -> BTreeMap<String, Member> {
    let mut seats = alive(root);
    let held = held();
    seats.retain(|seat, _| held.iter().all(|own| own.path != folder(root).join(seat)));
    seats
}

/// Does a living process hold this seat?
pub(crate) fn is_held(root: &Path, seat: &str) -> bool {
    let path = folder(root).join(seat);
    let Ok(file) = private::options().read(true).open(path) else {
        return false;
    };
    let free = flock(&file, FlockOperation::NonBlockingLockShared);
    free == Err(rustix::io::Errno::WOULDBLOCK)
}

fn read(path: &Path) -> Option<Member> {
    Member::parse(&private::read(path).ok()?)
}

/// The file of a seat, complete and locked before it has its name.
fn write(path: &Path, member: Member) -> std::io::Result<File> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let hidden = path.with_file_name(format!(".{name}.part"));
    match fs::remove_file(&hidden) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut file = private::open(private::options().write(true).create_new(true), &hidden)?;
    flock(&file, FlockOperation::NonBlockingLockExclusive)?;
    writeln!(file, "{} {}", member.pid, member.start)?;
    fs::rename(&hidden, path)?;
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
