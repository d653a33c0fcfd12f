//! Isolation of one run in shared memory, and its removal.
//!
//! A run owns the files `/dev/shm/sillage<id>_*` and the folder `/dev/shm/sillage-<id>`. Every
//! process of the run takes a seat in the folder's `members/`; the last one to leave removes both,
//! so nothing stays behind while one process is left to notice.

use std::collections::BTreeMap;
use std::fs;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use super::place::{SHARED_MEMORY, leave, preflight, remove_run, root, size_of};
use crate::language::error::Error;
use crate::run::liveness::{Board, OnLoss, Watch};
use crate::run::members::{self, Member};

/// Environment: identity of the run.
pub const ENV_RUN: &str = "SILLAGE_RUN";
/// Environment: process id of the orchestrator; absent when processes are started by hand.
pub const ENV_ORCHESTRATOR: &str = "SILLAGE_ORCHESTRATOR";

/// One run's corner of shared memory. Clones share one membership; when the last clone is dropped
/// this process leaves the run, and removes it when nobody is left.
#[derive(Debug, Clone)]
pub struct RunSpace {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    id: String,
    orchestrator: Option<u32>,
    presence: Mutex<Presence>,
}

#[derive(Debug, Default)]
struct Presence {
    seats: BTreeMap<String, Member>,
    watch: Option<Watch>,
}

/// What a run left behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Leftover {
    /// Identity of the run.
    pub id: String,
    /// Files left in shared memory, those in the run's folder included.
    pub files: usize,
    /// Bytes of memory they occupy.
    pub bytes: u64,
}

impl RunSpace {
    /// A new run, owned by this process (the orchestrator).
    pub fn create() -> Result<RunSpace, Error> {
        let runspace = RunSpace::with(fresh_id(), Some(std::process::id()));
        runspace.take_seat("orchestrator")?;
        Ok(runspace)
    }

    /// A run without an orchestrator, under a name of one's own choice (processes started by hand).
    pub fn named(id: &str) -> Result<RunSpace, Error> {
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit();
        if id.is_empty() || id.len() > 16 || !id.chars().all(plain) {
            let why = format!("`{id}` is not 1 to 16 characters of a-z and 0-9");
            return Err(Error::memory(format!("name of a run ({ENV_RUN})"), why));
        }
        Ok(RunSpace::with(id.to_owned(), None))
    }

    /// The run that the environment names (`SILLAGE_RUN`, `SILLAGE_ORCHESTRATOR`).
    pub fn from_environment() -> Result<RunSpace, Error> {
        let id = std::env::var(ENV_RUN).map_err(|_| Error::Handshake {
            who: "run".to_owned(),
            why: format!(
                "{ENV_RUN} is not set; start this process through `sillage run`, or give all \
                 processes of a run the same name in it"
            ),
        })?;
        let named = RunSpace::named(&id)?;
        let Ok(text) = std::env::var(ENV_ORCHESTRATOR) else {
            return Ok(named);
        };
        let pid = text.parse().map_err(|_| {
            Error::memory(ENV_ORCHESTRATOR, format!("`{text}` is not a process id"))
        })?;
        Ok(RunSpace::with(id, Some(pid)))
    }

    fn with(id: String, orchestrator: Option<u32>) -> RunSpace {
        RunSpace {
            shared: Arc::new(Shared {
                id,
                orchestrator,
                presence: Mutex::default(),
            }),
        }
    }

    /// What a child process needs in its environment to join this run.
    pub fn to_environment(&self) -> Vec<(String, String)> {
        let mut variables = vec![(ENV_RUN.to_owned(), self.shared.id.clone())];
        if let Some(pid) = self.shared.orchestrator {
            variables.push((ENV_ORCHESTRATOR.to_owned(), pid.to_string()));
        }
        variables
    }

    /// Identity of the run.
    pub fn id(&self) -> &str {
        &self.shared.id
    }

    /// Process id of the orchestrator, when there is one.
    pub fn orchestrator(&self) -> Option<u32> {
        self.shared.orchestrator
    }

    /// Refuse when shared memory has less than `bytes` left.
    pub fn preflight(&self, bytes: u64) -> Result<(), Error> {
        preflight(bytes)
    }

    /// Remove everything of this run; returns the number of files removed. Refused while another
    /// process of the run lives.
    pub fn sweep(&self) -> Result<usize, Error> {
        let root = root(self.id());
        if let Some((seat, member)) = members::alive(&root)
            .into_iter()
            .find(|(_, m)| m.pid != std::process::id())
        {
            let why = format!("the {seat} (process {}) still runs", member.pid);
            return Err(Error::memory(format!("sweep of run {}", self.id()), why));
        }
        Ok(remove_run(self.id()))
    }

    /// Tell the others that the process of this seat will never come (it could not be started, or
    /// ended before it joined). Without effect when it had joined.
    pub fn mark_lost(&self, seat: &str) -> Result<(), Error> {
        members::mark_lost(&root(self.id()), seat)
    }

    /// Runs in shared memory of which no process is alive.
    pub fn leftovers() -> Result<Vec<Leftover>, Error> {
        let mut found: BTreeMap<String, Leftover> = BTreeMap::new();
        let entries = fs::read_dir(SHARED_MEMORY).map_err(|e| Error::memory(SHARED_MEMORY, e))?;
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let Some(id) = run_of(&name) else { continue };
            let left = found.entry(id.to_owned()).or_insert_with(|| Leftover {
                id: id.to_owned(),
                files: 0,
                bytes: 0,
            });
            let (files, bytes) = size_of(&entry.path());
            left.files += files;
            left.bytes += bytes;
        }
        Ok(found
            .into_values()
            .filter(|left| members::alive(&root(&left.id)).is_empty())
            .collect())
    }

    /// Does the orchestrator that the environment names live and have its seat?
    pub(crate) fn has_orchestrator(&self) -> bool {
        let alive = members::alive(&root(self.id()));
        alive
            .get("orchestrator")
            .is_some_and(|member| Some(member.pid) == self.orchestrator())
    }

    /// Take a seat of this run ("orchestrator", "coupler", "fluid", "particles").
    pub(crate) fn take_seat(&self, seat: &str) -> Result<(), Error> {
        let mut presence = self.presence();
        if !presence.seats.contains_key(seat) {
            let member = members::join(&root(self.id()), seat)?;
            presence.seats.insert(seat.to_owned(), member);
        }
        Ok(())
    }

    /// Watch all other processes of this run; one watch a process.
    pub(crate) fn watch(&self, on_loss: OnLoss) -> Result<Arc<Board>, Error> {
        let mut presence = self.presence();
        if presence.watch.is_none() {
            presence.watch = Some(Watch::start(self.id(), &root(self.id()), on_loss)?);
        }
        Ok(presence
            .watch
            .as_ref()
            .map(Watch::board)
            .unwrap_or_default())
    }

    fn presence(&self) -> MutexGuard<'_, Presence> {
        self.shared
            .presence
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        let presence = self
            .presence
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        presence.watch = None;
        if !presence.seats.is_empty() {
            leave(&self.id);
        }
    }
}

impl Leftover {
    /// Remove it; returns the number of files removed.
    pub fn sweep(&self) -> Result<usize, Error> {
        RunSpace::with(self.id.clone(), None).sweep()
    }
}

fn fresh_id() -> String {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |d| d.as_nanos() as u64);
    static COUNTER: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
    let count = COUNTER.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let pid = u64::from(std::process::id());
    let mixed =
        (now ^ pid.rotate_left(32) ^ count.rotate_left(56)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    format!("{:010x}", mixed >> 24)
}

fn run_of(name: &str) -> Option<&str> {
    match name.strip_prefix("sillage-") {
        Some(id) => Some(id),
        None => name
            .strip_prefix("sillage")
            .and_then(|rest| rest.split_once('_'))
            .map(|(id, _)| id),
    }
}
