//! What the system allows a run: files that are open at the same time, and threads.

use scene::Error;

pub use protocol::process::{OPEN_FILES_MIN, open_files};

/// Threads that an engine may be given on any machine.
const THREADS_MAX: usize = 64;

/// Refuse to run where too few files may be open.
pub fn require_open_files() -> Result<(), Error> {
    let allowed = open_files();
    if allowed < OPEN_FILES_MIN {
        return Err(Error::Usage(format!(
            "a process may open {allowed} files, and a run needs {OPEN_FILES_MIN}: ulimit -n 1024, or ask who \
             set the hard limit"
        )));
    }
    Ok(())
}

/// The most threads that an engine may be given here.
pub fn threads_max() -> usize {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
    cores.max(THREADS_MAX)
}
