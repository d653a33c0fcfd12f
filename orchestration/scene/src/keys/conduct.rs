//! Keys of how a run is made: `[engines]`, `[output]`, `[record]`, `[checkpoint]` and `[limits]`.

use recording::Compression;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::ranges::{not_empty, positive, written_fields};

/// Engines to use instead of the built-in ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Engines {
    /// Takes the fluid seat.
    pub fluid: Option<EngineCommand>,
    /// Takes the particle seat.
    pub particles: Option<EngineCommand>,
}

/// How to start an engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EngineCommand {
    /// Program and arguments; started in the folder of the scene.
    #[schemars(transform = not_empty)]
    pub command: Vec<String>,
}

/// What is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Time between states written (s); left out: only the first and the last.
    #[schemars(transform = positive)]
    pub every: Option<f64>,
    /// Draw a picture of every state written.
    #[serde(default = "yes")]
    pub frames: bool,
    /// Names of the fields in the ParaView files; left out: all that exist.
    #[schemars(transform = written_fields)]
    pub fields: Option<Vec<String>>,
}

/// Recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Record {
    /// File, relative to the run folder; its name ends in ".mcap".
    #[schemars(regex(pattern = r"[^/]\.mcap$"))]
    pub file: String,
    /// "zstd" (smaller) or "none".
    #[schemars(schema_with = "compression")]
    pub compression: Compression,
}

impl Default for Record {
    fn default() -> Self {
        Record {
            file: "exchange.mcap".to_string(),
            compression: Compression::Zstd,
        }
    }
}

/// What is kept of a run, so that it can be resumed. The last state is kept in any case, also of a run that is
/// stopped or fails.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Checkpoint {
    /// Steps between two checkpoints; left out: only the wall clock counts.
    pub every_steps: Option<std::num::NonZeroU64>,
    /// Wall time between two checkpoints (s).
    #[schemars(transform = positive)]
    pub every_wall: f64,
    /// How many stay; 0: none is made.
    pub keep: u32,
}

impl Default for Checkpoint {
    fn default() -> Self {
        Checkpoint {
            every_steps: None,
            every_wall: 600.0,
            keep: 2,
        }
    }
}

/// How long to wait for an engine, all (s).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LimitKeys {
    /// Until an engine says hello.
    #[schemars(transform = positive)]
    pub connect: f64,
    /// Until an engine is ready after its scene.
    #[schemars(transform = positive)]
    pub configure: f64,
    /// Until an engine answers one step.
    #[schemars(transform = positive)]
    pub step: f64,
}

impl Default for LimitKeys {
    fn default() -> Self {
        LimitKeys {
            connect: 30.0,
            configure: 120.0,
            step: 600.0,
        }
    }
}

impl Default for Output {
    fn default() -> Self {
        Output {
            every: None,
            frames: true,
            fields: None,
        }
    }
}

/// The enumeration of recordings, which know nothing of schemas.
fn compression(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["zstd", "none"] })
}

fn yes() -> bool {
    true
}
