//! How many files this process may have open at the same time.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::language::error::Error;

/// Files that a process of a run may have open at the same time, at least.
pub const OPEN_FILES_MIN: u64 = 512;
/// What is asked for where the system allows it: many runs at the same time need more.
const OPEN_FILES: u64 = 65_536;

/// Raise the number of open files, for this process and those it starts, as far as that is allowed; what it
/// is then.
pub fn open_files() -> u64 {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let soft = current.unwrap_or(u64::MAX);
    let wanted = OPEN_FILES.min(maximum.unwrap_or(u64::MAX));
    let raised = Rlimit {
        current: Some(wanted),
        maximum,
    };
    if soft >= wanted || setrlimit(Resource::Nofile, raised).is_err() {
        return soft;
    }
    wanted
}

/// Refuse to take part where too few files may be open.
pub(crate) fn require() -> Result<(), Error> {
    let allowed = open_files();
    if allowed < OPEN_FILES_MIN {
        let why = format!(
            "a process may open {allowed} files, and a run needs {OPEN_FILES_MIN}: ulimit -n 1024, or ask who \
             set the hard limit"
        );
        return Err(Error::transport("open files", why));
    }
    Ok(())
}
