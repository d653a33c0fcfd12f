//! Recordings: every field and control message of a run, both directions, in one MCAP file.
//!
//! ```text
//!   coupler ──► Tap ──► engine          Tap      a channel that hands a copy of all that passes …
//!                │ copy, never waits
//!                ▼
//!             queue (bytes bounded) ──► thread: JSON, CRC-32C, zstd ──► exchange.mcap
//! ```
//!
//! | topic | payload after the header |
//! | --- | --- |
//! | `run/begin` | JSON [`Begin`]: format, protocol, versions, scene, mesh file |
//! | `fluid/<field>`, `particles/<field>` | `f64`, little endian, as exchanged |
//! | `fluid/request`, `particles/request` | JSON of a [`ToEngine`](crate::messages::ToEngine) |
//! | `fluid/answer`, `particles/answer` | JSON of a [`ToCoupler`](crate::messages::ToCoupler) |
//! | `run/end` | JSON [`End`]: whether all is in it, and how the run ended |
//!
//! Every payload stands behind 64 bytes: the header of the wire, in which bytes 56–59 are the CRC-32C
//! of all others and of the payload, and bytes 60–63 the attempt. `log_time` is the integer [`Key`],
//! `publish_time` the wall clock in ns since 1970, `sequence` counts messages without a gap.
//!
//! The recorder never waits: what the writing thread cannot take any more (queue full, disk full) ends
//! the recording, not the run. Chunks are written whole, at least once a second, so the file of a
//! killed run can be read up to its last whole chunk.

pub mod compare;
pub mod diff;
mod entry;
mod error;
mod reader;
mod replay;
mod summary;
mod tap;
mod writer;

pub use entry::{Body, Entry, Key};
pub use error::RecordingError;
pub use reader::{Ending, Reader};
pub use replay::{ReplayError, Report, replay};
pub use summary::summary;
pub use writer::{Options, Outcome, Recorder};

use serde::{Deserialize, Serialize};

use crate::PROTOCOL_VERSION;
use crate::configure::{CouplerScene, MeshSource};

/// Version of the layout described above.
pub const FORMAT: u32 = 1;

/// MCAP profile of our files.
const PROFILE: &str = "sillage";
/// Topics of the recorder itself.
const BEGIN: &str = "run/begin";
const END: &str = "run/end";
/// Bytes before each payload.
const HEADER: usize = 64;

/// How chunks are compressed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// zstd: smaller.
    #[default]
    Zstd,
    /// None: faster to read at random.
    None,
}

/// First message of a recording: all that a replay needs beside the exchange itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Begin {
    /// [`FORMAT`].
    pub format: u32,
    /// `PROTOCOL_VERSION` of the run.
    pub protocol: u32,
    /// Who recorded, with its version.
    pub program: String,
    /// Commit that the programs were built from, where it is known.
    pub commit: Option<String>,
    /// The resolved scene.
    pub scene: CouplerScene,
    /// Content of the mesh file, where the scene has one.
    pub mesh_file: Option<String>,
}

impl Begin {
    /// Of a run of this scene; reads the mesh file, if there is one.
    pub fn of(
        scene: &CouplerScene,
        program: &str,
        commit: Option<String>,
    ) -> Result<Begin, RecordingError> {
        let source = scene.fluid.as_ref().map(|fluid| &fluid.mesh);
        let mesh_file = match source {
            Some(MeshSource::File { path }) => {
                let bytes = std::fs::read(path)
                    .map_err(|error| RecordingError::file("cannot read the mesh", path, error))?;
                Some(String::from_utf8_lossy(&bytes).into_owned())
            }
            _ => None,
        };
        Ok(Begin {
            format: FORMAT,
            protocol: PROTOCOL_VERSION,
            program: program.to_owned(),
            commit,
            scene: scene.clone(),
            mesh_file,
        })
    }
}

/// Last message of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct End {
    /// Is every message of the run in the file?
    pub complete: bool,
    /// Why not.
    pub why: Option<String>,
    /// Exit code of the run, as the coupler sees it.
    pub exit: Option<i32>,
    /// Messages before this one, `run/begin` included.
    pub messages: u64,
}
