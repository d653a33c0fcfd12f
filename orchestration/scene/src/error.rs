//! What can go wrong in the orchestrator, and the exit code that follows.

use std::path::PathBuf;

use recording::RecordingError;
use thiserror::Error;

use crate::problem::Problems;

/// Exit codes of `sillage`; a contract.
pub mod exit_code {
    /// Everything went well.
    pub const OK: i32 = 0;
    /// Two results differ by more than the tolerance (`replay`, `diff`).
    pub const DIFFERENT: i32 = 1;
    /// Wrong usage or an invalid scene.
    pub const SCENE: i32 = 2;
    /// Handshake refused or versions that do not match.
    pub const HANDSHAKE: i32 = 3;
    /// An engine failed.
    pub const ENGINE: i32 = 4;
    /// A partner process was lost.
    pub const PARTNER_LOST: i32 = 5;
    /// A limit on time was reached.
    pub const TIME_LIMIT: i32 = 6;
    /// A value is not finite, or an invariant is broken.
    pub const NOT_FINITE: i32 = 7;
    /// An iteration did not converge.
    pub const NOT_CONVERGED: i32 = 8;
    /// Interrupted from the keyboard or by SIGTERM.
    pub const INTERRUPTED: i32 = 130;

    /// What a code means, in words.
    pub fn meaning(code: i32) -> &'static str {
        match code {
            OK => "ok",
            DIFFERENT => "different",
            SCENE => "usage, scene or file",
            HANDSHAKE => "handshake or version",
            ENGINE => "engine failed",
            PARTNER_LOST => "partner lost",
            TIME_LIMIT => "time limit",
            NOT_FINITE => "not finite or an invariant broken",
            NOT_CONVERGED => "not converged",
            INTERRUPTED => "interrupted",
            _ => "unknown",
        }
    }
}

/// Errors of the orchestrator.
#[derive(Debug, Error)]
pub enum Error {
    /// The scene is not valid: every problem found, each with its line.
    #[error("{0}")]
    Scene(Problems),
    /// The command line is not valid.
    #[error("{0}")]
    Usage(String),
    /// A file or folder cannot be used.
    #[error("{action} {path}: {source}")]
    File {
        /// What was attempted, e.g. "cannot write".
        action: &'static str,
        /// Which file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// A run ended early; the code is the run's.
    #[error("{why}")]
    Run {
        /// Exit code of the run.
        code: i32,
        /// Who, at which step, waiting for what.
        why: String,
    },
    /// A recording cannot be used.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Drawing a picture failed.
    #[error("cannot draw {path}: {why}")]
    Picture {
        /// The picture.
        path: PathBuf,
        /// Why.
        why: String,
    },
}

/// What a run, or what is left of one, cannot do is told as the end of a run.
impl From<protocol::Error> for Error {
    fn from(error: protocol::Error) -> Error {
        Error::Run {
            code: error.exit_code(),
            why: error.to_string(),
        }
    }
}

impl Error {
    /// The exit code of the process.
    pub fn exit_code(&self) -> i32 {
        match self {
            Error::Scene(_) | Error::Usage(_) => exit_code::SCENE,
            Error::File { .. } | Error::Picture { .. } => exit_code::ENGINE,
            Error::Run { code, .. } => *code,
            Error::Recording(error) => error.exit_code(),
        }
    }

    /// An error about a file.
    pub fn file(
        action: &'static str,
        path: impl Into<PathBuf>,
    ) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.into();
        move |source| Error::File {
            action,
            path,
            source,
        }
    }
}
