//! What a run had put out at a checkpoint, so that what came after can be cut off again.

use std::path::Path;

use protocol::codec;
use scene::Error;
use serde::{Deserialize, Serialize};

use super::steps::Table;
use crate::vtu::write::Entries;

/// How a file of it begins.
const MAGIC: &[u8] = b"SILLOUT\0";

/// What had been put out.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Outputs {
    /// `steps.csv`.
    pub steps: Table,
    /// `fluid.pvd`.
    pub fluid: Entries,
    /// `grains.pvd`.
    pub grains: Entries,
    /// States put out.
    pub states: usize,
    /// Time of the last \[s\].
    pub states_to: Option<f64>,
    /// What draws needs to go on, as it says itself.
    pub pictures: String,
    /// Where the run was resumed before.
    pub resumed: Vec<Resumption>,
    /// Wall time of the run so far \[s\].
    pub wall: f64,
}

/// A run goes on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Resumption {
    /// After this step.
    pub step: u64,
    /// At this time \[s\].
    pub time: f64,
    /// When that was, in seconds since 1970.
    pub written: u64,
}

impl Outputs {
    pub(super) fn write(&self, path: &Path) -> Result<(), Error> {
        let content = codec::encode_file(self).map_err(|error| Error::Usage(error.to_string()))?;
        std::fs::write(path, [MAGIC, &content].concat()).map_err(Error::file("cannot write", path))
    }

    pub(super) fn read(path: &Path) -> Result<Outputs, String> {
        let bytes = std::fs::read(path).map_err(|error| format!("cannot be read: {error}"))?;
        let content = bytes.strip_prefix(MAGIC).ok_or("not outputs of a run")?;
        codec::decode_file(content).map_err(|error| error.to_string())
    }
}
