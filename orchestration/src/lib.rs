//! The orchestrator: reads a scene, starts the processes of a run, watches them, writes the run
//! folder. It knows no physics.
//!
//! | file | what |
//! | --- | --- |
//! | `scene` | one TOML file → validated scene → `CouplerScene` |
//! | `grains` | populations: where the grains are at t = 0 |
//! | `plan` | which processes, terms and fields a scene needs |
//! | `run` | a scene into a run folder |
//! | `launch`, `watch`, `verdict` | child processes: start, wait, end, and why they ended |
//! | `interrupt`, `progress` | Ctrl-C, and how far a run is |
//! | `output` | run folder: `steps.csv`, ParaView files, pictures, `run.json` |
//! | `conform` | does a command speak the protocol? |
//! | `record`, `replay`, `diff` | recordings: made, fed to an engine, compared |
//! | `report`, `table` | one HTML page of a run, from what its folder holds |
//! | `study` | error against run time: many runs, one table |
//! | `stability` | where each scheme is stable: maps of small scenes with closed forms |
//! | `batch` | many scenes, each in a folder of its own, not run again when there |
//! | `view` | the page of a run, served while it goes on |
//! | `doctor` | what this machine offers |
//! | `stdout` | what commands say, into a pipe too |

pub mod batch;
pub mod cli;
pub mod conform;
pub mod diff;
pub mod doctor;
pub mod error;
pub mod grains;
pub mod interrupt;
pub mod launch;
pub mod output;
pub mod plan;
pub mod progress;
pub mod record;
pub mod replay;
pub mod report;
pub mod run;
pub mod scene;
pub mod stability;
pub mod stdout;
pub mod study;
pub mod table;
pub mod verdict;
pub mod view;
pub mod watch;

pub use error::Error;
