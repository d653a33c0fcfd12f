//! What both seats do the same way: check the functions they were given, run, commit, save, restore.

use std::ffi::{CString, c_char, c_void};
use std::path::Path;

use protocol::error::Error;
use protocol::message::{Capability, Failure, FailureKind, Role};
use protocol::process;
use protocol::runspace::RunSpace;

use crate::handle::Engine;

/// A function that takes the engine alone.
pub(crate) type Plain = unsafe extern "C" fn(engine: *mut Engine, user: *mut c_void) -> i32;
/// A function that takes a file's path too.
pub(crate) type Filed =
    unsafe extern "C" fn(engine: *mut Engine, user: *mut c_void, path: *const c_char) -> i32;

/// The engine behind the border, and what it was given with.
#[derive(Clone, Copy)]
pub(crate) struct Border<'a> {
    pub(crate) this: &'a Engine,
    pub(crate) engine: *mut Engine,
    pub(crate) user: *mut c_void,
    pub(crate) commit: Option<Plain>,
    pub(crate) save: Option<Filed>,
    pub(crate) restore: Option<Filed>,
}

impl Border<'_> {
    /// Take the seat and serve until the run is over; the exit code for the process. `own` are functions of
    /// this seat that must be there, and whether they are.
    pub(crate) fn run(
        &self,
        role: Role,
        own: &[(&str, bool)],
        serve: impl FnOnce(&RunSpace) -> Result<(), Error>,
    ) -> Result<i32, String> {
        let checkpoint = self.this.declares(Capability::Checkpoint);
        let shared = [
            ("commit", self.commit.is_some()),
            ("save", self.save.is_some() || !checkpoint),
            ("restore", self.restore.is_some() || !checkpoint),
        ];
        if let Some((name, _)) = own.iter().chain(&shared).find(|(_, there)| !there) {
            return Err(format!("calls.{name} is a null pointer"));
        }
        if !self.this.begin_run() {
            return Err("this engine runs already".to_owned());
        }
        let code = process::exit_code(role.seat(), serve);
        self.this.end_run();
        Ok(code)
    }

    pub(crate) fn commit(&self) -> Result<(), Failure> {
        let commit = self.commit.ok_or_else(|| missing("commit"))?;
        // SAFETY: the function takes what it was given with.
        let call = || unsafe { commit(self.engine, self.user) };
        self.this.call("commit", call).map(drop)
    }

    pub(crate) fn save(&self, path: &Path) -> Result<(), Failure> {
        self.file("save", self.save, path)
    }

    pub(crate) fn restore(&self, path: &Path) -> Result<(), Failure> {
        self.file("restore", self.restore, path)
    }

    fn file(&self, name: &str, function: Option<Filed>, path: &Path) -> Result<(), Failure> {
        let function = function.ok_or_else(|| missing(name))?;
        let path = c_path(path)?;
        // SAFETY: the path outlives the call.
        let call = || unsafe { function(self.engine, self.user, path.as_ptr()) };
        self.this.call(name, call).map(drop)
    }
}

pub(crate) fn missing(name: &str) -> Failure {
    Failure::new(FailureKind::Engine, format!("the engine has no {name}"))
}

/// A path for C.
fn c_path(path: &Path) -> Result<CString, Failure> {
    let text = path.to_str().and_then(|text| CString::new(text).ok());
    text.ok_or_else(|| {
        let why = format!("{} cannot be a C string", path.display());
        Failure::new(FailureKind::Engine, why)
    })
}
