//! Isolation of one run in shared memory, and its removal.
//!
//! A run owns the files `/dev/shm/sillage<key>_*` (key: the id, its first part where it is long) and the
//! private folder `/dev/shm/sillage-<id>`. Every
//! process of the run takes a seat in the folder's `members/`; the last one to leave removes both,
//! so nothing stays behind while one process is left to notice.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::leftovers::survey;
use super::lock::lock_if_there;
use super::names::root;
use super::place::{SMALLEST, leave, preflight, remove_run};
use super::{private, strays};
use crate::language::error::Error;
use crate::run::liveness::{Board, OnLoss, Watch};
use crate::run::members::{self, Member};

pub use super::leftovers::{Foreign, Leftover};
pub use super::names::{ENV_ORCHESTRATOR, ENV_RUN, ENV_TOKEN, files_of};

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
    /// The token that the environment handed to this process.
    handed: Option<Secret>,
    presence: Mutex<Presence>,
}

#[derive(Debug, Default)]
struct Presence {
    seats: BTreeMap<String, Member>,
    watch: Option<Watch>,
}

/// What a run hands to those that may join it; never printed.
struct Secret(String);

impl fmt::Debug for Secret {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("…")
    }
}

impl RunSpace {
    /// A new run, owned by this process (the orchestrator); what dead runs left is removed first.
    pub fn create() -> Result<RunSpace, Error> {
        preflight(SMALLEST)?;
        for left in RunSpace::leftovers()? {
            if let Err(error) = left.sweep() {
                tracing::debug!("what run {} left is still there: {error}", left.id);
            }
        }
        let id = private::random().map_err(|e| Error::memory("name of a run", e))?;
        let runspace = RunSpace::with(id, Some(std::process::id()), None);
        runspace.take_seat("orchestrator")?;
        Ok(runspace)
    }

    /// A run without an orchestrator, under a name of one's own choice (processes started by hand).
    pub fn named(id: &str) -> Result<RunSpace, Error> {
        check_name(id, 16)?;
        Ok(RunSpace::with(id.to_owned(), None, None))
    }

    /// The run that the environment names (`SILLAGE_RUN`, `SILLAGE_ORCHESTRATOR`, `SILLAGE_TOKEN`).
    pub fn from_environment() -> Result<RunSpace, Error> {
        let id = std::env::var(ENV_RUN).map_err(|_| Error::Handshake {
            who: "run".to_owned(),
            why: format!(
                "{ENV_RUN} is not set; start this process through `sillage run`, or give all \
                 processes of a run the same name in it"
            ),
        })?;
        let token = std::env::var(ENV_TOKEN).ok().map(Secret);
        let Ok(text) = std::env::var(ENV_ORCHESTRATOR) else {
            check_name(&id, 16)?;
            return Ok(RunSpace::with(id, None, token));
        };
        check_name(&id, private::RANDOM_LENGTH)?;
        let pid = text.parse().map_err(|_| {
            Error::memory(ENV_ORCHESTRATOR, format!("`{text}` is not a process id"))
        })?;
        Ok(RunSpace::with(id, Some(pid), token))
    }

    fn with(id: String, orchestrator: Option<u32>, handed: Option<Secret>) -> RunSpace {
        RunSpace {
            shared: Arc::new(Shared {
                id,
                orchestrator,
                handed,
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
        if let Ok(token) = self.token() {
            variables.push((ENV_TOKEN.to_owned(), token));
        }
        variables
    }

    /// What tells who may join this run: handed to this process by the environment, or read in the run's
    /// folder, which is there once a seat is taken.
    pub(crate) fn token(&self) -> Result<String, Error> {
        if let Some(Secret(token)) = &self.shared.handed {
            return Ok(token.clone());
        }
        let path = members::token_file(&root(self.id()));
        let token = private::read(&path);
        token.map_err(|e| Error::memory(format!("token of the run, {}", path.display()), e))
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

    /// Remove everything of this run, and end what its processes started and left; returns the number of
    /// files removed. Refused while another process of the run lives.
    pub fn sweep(&self) -> Result<usize, Error> {
        if self.orchestrator() == Some(std::process::id()) {
            // Also one that keeps a seat locked which it inherited.
            strays::end(self.id(), &members::ever(&root(self.id())));
        }
        clear(self.id(), members::others)
    }

    /// The other processes of this run that are stopped by a signal, by seat.
    pub fn stopped(&self) -> BTreeMap<String, u32> {
        let others = members::others(&root(self.id())).into_iter();
        let processes = others.map(|(seat, member)| (seat, member.pid));
        processes
            .filter(|(_, process)| strays::is_stopped(*process))
            .collect()
    }

    /// A folder of this name that only this user can enter, and that goes when the run goes; a seat is
    /// taken.
    pub fn folder(&self, name: &str) -> Result<PathBuf, Error> {
        let path = root(self.id()).join(name);
        private::folder(&path).map_err(|e| Error::memory(path.display().to_string(), e))?;
        Ok(path)
    }

    /// Tell the others that the process of this seat will never come (it could not be started, or
    /// ended before it joined). Without effect when it had joined.
    pub fn mark_lost(&self, seat: &str) -> Result<(), Error> {
        members::mark_lost(&root(self.id()), seat)
    }

    /// Runs of this user in shared memory of which no process is alive.
    pub fn leftovers() -> Result<Vec<Leftover>, Error> {
        Ok(survey()?.0)
    }

    /// Runs of other users in shared memory, which this user cannot look into.
    pub fn of_others() -> Result<Vec<Foreign>, Error> {
        Ok(survey()?.1)
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
        if let Some(watch) = &presence.watch {
            return Ok(watch.board());
        }
        let watch = Watch::start(self.id(), &root(self.id()), on_loss)?;
        let board = watch.board();
        presence.watch = Some(watch);
        Ok(board)
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
        clear(&self.id, members::alive)
    }
}

/// Remove a run of which nobody lives that counts.
fn clear(id: &str, living: impl FnOnce(&Path) -> BTreeMap<String, Member>) -> Result<usize, Error> {
    let root = root(id);
    let what = || format!("sweep of run {id}");
    let lock = lock_if_there(&root).map_err(|e| Error::memory(what(), e))?;
    // Without its folder a run is being removed, or was: whoever does so has ended what it started, may be
    // a process of the run itself, and is not known to be one any more.
    if lock.is_some() {
        if let Some((seat, member)) = living(&root).into_iter().next() {
            let why = format!("the {seat} (process {}) still runs", member.pid);
            return Err(Error::memory(what(), why));
        }
        strays::end(id, &members::ever(&root));
    }
    remove_run(id)
}

fn check_name(id: &str, longest: usize) -> Result<(), Error> {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit();
    if id.is_empty() || id.len() > longest || !id.chars().all(plain) {
        let why = format!("`{id}` is not 1 to {longest} characters of a-z and 0-9");
        return Err(Error::memory(format!("name of a run ({ENV_RUN})"), why));
    }
    Ok(())
}
