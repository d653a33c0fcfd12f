//! The orchestrator: reads a scene, starts the processes of a run, watches them, writes the run
//! folder. It knows no physics.
//!
//! | file | what |
//! | --- | --- |
//! | `scene` | one TOML file → validated scene → `CouplerScene` |
//! | `grains` | populations: where the grains are at t = 0 |
//! | `plan` | which processes, terms and fields a scene needs |
//! | `launch`, `watch` | child processes: start, wait, end |
//! | `output` | run folder: `steps.csv`, ParaView files, pictures, `run.json` |
//! | `doctor` | what this machine offers |

pub mod cli;
pub mod error;
pub mod grains;
pub mod plan;
pub mod scene;

pub use error::Error;
