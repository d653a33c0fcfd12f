//! One run a folder at a time.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::Path;

use nix::fcntl::{Flock, FlockArg};
use scene::Error;

const FILE: &str = ".lock";

/// Held while a run writes to its folder. It is the kernel's, so that a process that died holds none.
pub struct Lock {
    _file: Flock<File>,
}

impl Lock {
    /// Make the folder if there is none, and take it, or say who has it; nothing in it is touched.
    pub fn take(folder: &Path) -> Result<Lock, Error> {
        std::fs::create_dir_all(folder).map_err(Error::file("cannot create", folder))?;
        let path = folder.join(FILE);
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(Error::file("cannot open", &path))?;
        match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
            Ok(mut file) => {
                file.set_len(0)
                    .and_then(|()| write!(file, "{}", std::process::id()))
                    .map_err(Error::file("cannot write", &path))?;
                Ok(Lock { _file: file })
            }
            Err((mut file, _)) => {
                let mut owner = String::new();
                // Who it is only helps: without it the folder is in use all the same.
                let _ = file.read_to_string(&mut owner);
                Err(Error::Usage(format!(
                    "{} is in use by process {}: wait for it, or choose another --out",
                    folder.display(),
                    owner.trim()
                )))
            }
        }
    }
}
