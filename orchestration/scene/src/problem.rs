//! Problems of a scene: file, line, key, value, and what is allowed.

use std::fmt;

use serde::Serialize;

/// One thing that is wrong with a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Problem {
    /// Where: "cloud.toml:14", or `--set grains[0].radius` for a key given on the command line.
    pub place: String,
    /// The key, e.g. `grains[0].radius`; empty when the file is not TOML.
    pub key: String,
    /// The value as written, when there is one.
    pub value: Option<String>,
    /// What is wrong and what is allowed.
    pub message: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: ", self.place)?;
        match (self.key.is_empty(), &self.value) {
            (true, _) => {}
            (false, Some(value)) => write!(out, "{} = {value}: ", self.key)?,
            (false, None) => write!(out, "{}: ", self.key)?,
        }
        write!(out, "{}", self.message)
    }
}

/// All problems found in a scene; never empty in an `Err`.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct Problems(pub Vec<Problem>);

impl fmt::Display for Problems {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(out)?;
            }
            write!(out, "{problem}")?;
        }
        Ok(())
    }
}
