//! What can be wrong with a file.

use std::fmt;
use std::path::PathBuf;

/// Faults told of one file; the rest is counted.
const TOLD: usize = 12;

/// A file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// It cannot be read.
    #[error("mesh file {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is not what the format says.
    #[error("mesh file {}, {place}: {why}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// "line 27", or "byte 1234" of a binary file.
        place: String,
        /// What is wrong and what is expected.
        why: String,
    },
    /// It is well formed, and no mesh to compute on.
    #[error("mesh file {}: {faults}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// Everything that is wrong.
        faults: Faults,
    },
}

/// Everything that makes a mesh unusable, each with its number in the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faults(pub Vec<String>);

impl Faults {
    /// Note one.
    pub(crate) fn note(&mut self, fault: String) {
        self.0.push(fault);
    }

    /// Is nothing wrong?
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told: Vec<&str> = self.0.iter().take(TOLD).map(String::as_str).collect();
        write!(out, "{}", told.join("; "))?;
        match self.0.len().saturating_sub(TOLD) {
            0 => Ok(()),
            more => write!(out, "; and {more} more"),
        }
    }
}
