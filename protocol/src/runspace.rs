//! Isolation of one run in shared memory, and its removal.

use crate::error::Error;

/// One run's corner of shared memory: files `/dev/shm/sillage<id>_*` and the folder
/// `/dev/shm/sillage-<id>`.
#[derive(Debug, Clone)]
pub struct RunSpace {
    id: String,
    orchestrator: Option<u32>,
}

/// What a run left behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Leftover {
    /// Identity of the run.
    pub id: String,
    /// Files left, the root folder not counted.
    pub files: usize,
    /// Bytes of memory they occupy.
    pub bytes: u64,
}

fn not_yet() -> Error {
    Error::transport("protocol", "not connected in this build")
}

impl RunSpace {
    /// A new run, owned by this process (the orchestrator).
    pub fn create() -> Result<RunSpace, Error> {
        Err(not_yet())
    }
    /// The run that the environment names (`SILLAGE_RUN`, `SILLAGE_ORCHESTRATOR`).
    pub fn from_environment() -> Result<RunSpace, Error> {
        Err(not_yet())
    }
    /// What a child process needs in its environment to join this run.
    pub fn to_environment(&self) -> Vec<(String, String)> {
        vec![("SILLAGE_RUN".into(), self.id.clone())]
    }
    /// Identity of the run.
    pub fn id(&self) -> &str {
        &self.id
    }
    /// Process id of the orchestrator, when there is one.
    pub fn orchestrator(&self) -> Option<u32> {
        self.orchestrator
    }
    /// Refuse when shared memory has less than `bytes` left.
    pub fn preflight(&self, _bytes: u64) -> Result<(), Error> {
        Err(not_yet())
    }
    /// Remove everything of this run; returns the number of files removed.
    pub fn sweep(&self) -> Result<usize, Error> {
        Err(not_yet())
    }
    /// Tell the others that a process (seat "fluid", "particles", "coupler") will never come.
    pub fn mark_lost(&self, _seat: &str) -> Result<(), Error> {
        Err(not_yet())
    }
    /// Runs of which no process is alive.
    pub fn leftovers() -> Result<Vec<Leftover>, Error> {
        Err(not_yet())
    }
}

impl Leftover {
    /// Remove it; returns the number of files removed.
    pub fn sweep(&self) -> Result<usize, Error> {
        Err(not_yet())
    }
}
