//! The first and the last message of a recording, and what marks a file as ours.

use serde::{Deserialize, Serialize};

use protocol::PROTOCOL_VERSION;
use protocol::scene::{CouplerScene, MeshSource};

use crate::error::RecordingError;

/// Version of the layout described above.
pub const FORMAT: u32 = 1;

/// MCAP profile of our files.
pub(crate) const PROFILE: &str = "sillage";
/// Topics of the recorder itself.
pub(crate) const BEGIN: &str = "run/begin";
pub(crate) const END: &str = "run/end";

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
    /// Content of the mesh file, where the scene has one: a character for each of its bytes.
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
            Some(MeshSource::File { path, .. }) => {
                let bytes = std::fs::read(path)
                    .map_err(|error| RecordingError::file("cannot read the mesh", path, error))?;
                Some(bytes.into_iter().map(char::from).collect())
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
