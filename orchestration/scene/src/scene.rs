//! A scene as everything after it takes it: checked, complete, nothing relative left.

use std::path::PathBuf;

use protocol::configure::CouplerScene;

use crate::grains::GrainTable;
use crate::keys::{Engines, Output, Record};

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
    /// May engines leave out what their bounds allow?
    pub leave_out: bool,
    /// What was asked for and will not happen, or may surprise.
    pub warnings: Vec<String>,
}
