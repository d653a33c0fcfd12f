//! What can be wrong with a recording.

use std::path::{Path, PathBuf};

use protocol::PROTOCOL_VERSION;

/// Why a recording cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be used.
    #[error("{action} {path}: {source}")]
    File {
        /// What was attempted.
        action: &'static str,
        /// Which file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The file is something else.
    #[error("{path} is not a recording of Sillage: {why}")]
    Foreign {
        /// Which file.
        path: PathBuf,
        /// What it is, or lacks.
        why: String,
    },
    /// The file was written by another version.
    #[error(
        "{path} records {what} {theirs}, this program reads {ours}: use the version that wrote it, \
         or record again"
    )]
    Version {
        /// Which file.
        path: PathBuf,
        /// "protocol" or "format".
        what: &'static str,
        /// Its version.
        theirs: u64,
        /// Ours.
        ours: u32,
    },
    /// Bytes of the file changed after they were written.
    #[error("{path} is damaged {place}: {why}; what is before it can be trusted")]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// After which message.
        place: String,
        /// What does not fit.
        why: String,
    },
    /// A run cannot be resumed with it.
    #[error(
        "{path} holds {messages} messages, the checkpoint was made after {expected}: it has been cut since"
    )]
    Short {
        /// Which file.
        path: PathBuf,
        /// What it holds.
        messages: u64,
        /// What it should hold at least.
        expected: u64,
    },
    /// The recording cannot be replayed.
    #[error("{path} cannot be replayed: {why}")]
    NotReplayable {
        /// Which file.
        path: PathBuf,
        /// Why not.
        why: String,
    },
}

impl RecordingError {
    /// The exit code of a process that ends with this error.
    pub fn exit_code(&self) -> i32 {
        match self {
            RecordingError::Version { .. } => 3,
            _ => 2,
        }
    }

    pub(crate) fn file(
        action: &'static str,
        path: impl AsRef<Path>,
        source: std::io::Error,
    ) -> RecordingError {
        RecordingError::File {
            action,
            path: path.as_ref().to_path_buf(),
            source,
        }
    }

    pub(crate) fn foreign(path: &Path, why: impl Into<String>) -> RecordingError {
        RecordingError::Foreign {
            path: path.to_path_buf(),
            why: why.into(),
        }
    }

    pub(crate) fn protocol(path: &Path, theirs: u64) -> RecordingError {
        RecordingError::Version {
            path: path.to_path_buf(),
            what: "protocol",
            theirs,
            ours: PROTOCOL_VERSION,
        }
    }
}
