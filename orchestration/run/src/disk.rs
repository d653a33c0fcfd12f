//! Writing to a disk that may be full for a while: the first failure is told at once, the write is tried
//! again, and only what fails for a minute is given up.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use protocol::awake;
use scene::Error;

use crate::file;

/// How long a write may fail before it is given up.
pub const PATIENCE: Duration = Duration::from_secs(60);
/// Between two tries.
const PAUSE: Duration = Duration::from_millis(100);

/// How writing goes.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Trouble {
    /// Well.
    #[default]
    None,
    /// Something cannot be written, and is tried again: what, why, and for how long.
    Waiting(String),
    /// Something could not be written for too long, or nobody waits any more: nothing more is written. The
    /// exit code that follows, and why.
    GivenUp(i32, String),
}

/// The disk of one folder. Clones share their trouble.
#[derive(Debug, Clone)]
pub struct Disk {
    patience: Duration,
    trouble: Arc<Mutex<Trouble>>,
}

impl Disk {
    /// A disk that is waited for so long.
    pub fn new(patience: Duration) -> Disk {
        Disk {
            patience,
            trouble: Arc::default(),
        }
    }

    /// How writing goes.
    pub fn trouble(&self) -> Trouble {
        self.state().clone()
    }

    /// Nobody waits any more: what is being tried fails.
    pub fn abandon(&self, code: i32, why: &str) {
        *self.state() = Trouble::GivenUp(code, why.to_owned());
    }

    /// Write a file in one move.
    pub fn write(&self, path: &Path, content: impl AsRef<[u8]>) -> Result<(), Error> {
        self.attempt(|| file::write(path, &content))
    }

    /// Do what writes a file until it succeeds; it must be able to begin again after a failure.
    pub fn attempt(&self, mut write: impl FnMut() -> Result<(), Error>) -> Result<(), Error> {
        let begun = awake::now();
        loop {
            if let Trouble::GivenUp(code, why) = self.trouble() {
                return Err(Error::Run { code, why });
            }
            match write() {
                Err(error @ Error::File { .. }) => self.note(&error, awake::now() - begun),
                other => {
                    let mut state = self.state();
                    if matches!(*state, Trouble::Waiting(_)) {
                        *state = Trouble::None;
                    }
                    return other;
                }
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn note(&self, error: &Error, since: Duration) {
        let mut state = self.state();
        *state = match &*state {
            Trouble::GivenUp(code, why) => Trouble::GivenUp(*code, why.clone()),
            _ if since >= self.patience => {
                let seconds = self.patience.as_secs_f64();
                let why = format!("{error}, also after {seconds} s of trying");
                Trouble::GivenUp(error.exit_code(), why)
            }
            _ => {
                let seconds = self.patience.as_secs_f64();
                Trouble::Waiting(format!(
                    "{error}; the run waits for it, {seconds} s at most"
                ))
            }
        };
    }

    fn state(&self) -> MutexGuard<'_, Trouble> {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Tells of a disk's trouble once, and of its end.
#[derive(Debug, Default)]
pub struct Teller {
    told: bool,
}

impl Teller {
    /// What is to be said now.
    pub fn look(&mut self, trouble: &Trouble) -> Option<String> {
        match trouble {
            Trouble::Waiting(why) if !self.told => {
                self.told = true;
                Some(format!("warning: {why}"))
            }
            Trouble::None if self.told => {
                self.told = false;
                Some("the folder is written again, nothing is lost".to_owned())
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use scene::error::exit_code;

    use super::*;

    fn full() -> Error {
        Error::file("cannot write", "steps.csv")(std::io::ErrorKind::StorageFull.into())
    }

    #[test]
    fn a_write_is_tried_until_it_succeeds_and_told_of_once() {
        let (disk, mut teller, mut failures) = (Disk::new(PATIENCE), Teller::default(), 3);
        let mut said = Vec::new();
        let watched = disk.clone();
        let outcome = disk.attempt(|| {
            said.extend(teller.look(&watched.trouble()));
            failures -= 1;
            if failures >= 0 { Err(full()) } else { Ok(()) }
        });
        said.extend(teller.look(&disk.trouble()));
        println!("{said:#?}");
        assert!(outcome.is_ok());
        assert_eq!(said.len(), 2);
        assert!(said[0].contains("cannot write steps.csv"));
    }

    #[test]
    fn what_fails_for_too_long_is_given_up_and_so_is_all_that_follows() {
        let disk = Disk::new(Duration::from_millis(250));
        let begun = std::time::Instant::now();
        let error = disk.attempt(|| Err(full())).expect_err("given up");
        println!("{error} after {:?}", begun.elapsed());
        assert_eq!(error.exit_code(), exit_code::ENGINE);
        assert!(begun.elapsed() >= Duration::from_millis(250));
        let mut tried = false;
        let later = disk.attempt(|| {
            tried = true;
            Ok(())
        });
        assert!(later.is_err() && !tried);
    }
}
