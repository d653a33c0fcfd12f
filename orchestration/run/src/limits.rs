//! What the system allows a run: files that are open at the same time, and threads.

use nix::sys::resource::{Resource, getrlimit, setrlimit};
use scene::Error;

/// Files that a process of a run may have open at the same time, at least.
pub const OPEN_FILES_MIN: u64 = 512;
/// What is asked for where the system allows it: many runs at the same time need more.
const OPEN_FILES: u64 = 65_536;
/// Threads that an engine may be given on any machine.
const THREADS_MAX: usize = 64;

/// Raise the number of open files, for this process and those it starts, as far as that is allowed; what it
/// is then.
pub fn open_files() -> u64 {
    let Ok((soft, hard)) = getrlimit(Resource::RLIMIT_NOFILE) else {
        return 0;
    };
    let wanted = OPEN_FILES.min(hard);
    if soft >= wanted || setrlimit(Resource::RLIMIT_NOFILE, wanted, hard).is_err() {
        return soft;
    }
    wanted
}

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
