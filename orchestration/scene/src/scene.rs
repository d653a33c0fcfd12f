//! A scene as everything after it takes it: checked, complete, nothing relative left.

use std::path::PathBuf;

use protocol::scene::CouplerScene;

use crate::error::Error;
use crate::grains::GrainTable;
use crate::keys::{Checkpoint, Engines, Output, Record};
use crate::record::check_file;

/// A scene that can be run.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Its file name without `.toml`.
    pub name: String,
    /// Folder of its file; engine commands start there.
    pub folder: PathBuf,
    /// Text of its file, as read.
    pub text: String,
    /// What the coupler receives.
    pub coupler: CouplerScene,
    /// The grains at t = 0.
    pub grains: GrainTable,
    /// Engines other than the built-in ones.
    pub engines: Engines,
    /// What is written.
    pub output: Output,
    /// The recording, when one is asked for.
    pub record: Option<Record>,
    /// What is kept of the run.
    pub checkpoint: Checkpoint,
    /// May engines leave out what their bounds allow?
    pub leave_out: bool,
    /// What was asked for and will not happen, or may surprise.
    pub warnings: Vec<String>,
}

impl Scene {
    /// In how many dimensions it is computed.
    pub fn dimension(&self) -> usize {
        self.coupler.gravity.len()
    }

    /// Ask for a recording on the command line; an empty name leaves it to the scene.
    pub fn record_into(&mut self, file: &str) -> Result<(), Error> {
        let record = self.record.get_or_insert_with(Record::default);
        if !file.is_empty() {
            check_file(file).map_err(|why| Error::Usage(format!("--record={file}: {why}")))?;
            record.file = file.to_string();
        }
        Ok(())
    }
}
