//! A scene into a run folder: processes started, watched and ended, results written.
//!
//! | file | what |
//! | --- | --- |
//! | `run` | a scene into a run folder |
//! | `begin`, `failed_step` | from its start or a checkpoint; the step that ended it, recorded |
//! | `launch`, `watch`, `stopped`, `verdict` | child processes: start, wait, end, and why they ended |
//! | `interrupt`, `progress` | Ctrl-C, and how far a run is |
//! | `folder` | `run.json`, `steps.csv`, the recording, how states get there |
//! | `vtu` | states for ParaView, written and read back |
//! | `version`, `file`, `disk` | what this program is; files that others may be reading, on a disk that may be full |
//! | `tell`, `limits` | words on stderr, which may be gone or not be read; open files and threads |
//! | `batch` | many scenes, each in a folder of its own, not run again when there |

pub mod batch;
mod begin;
pub mod disk;
mod failed_step;
pub mod file;
pub mod folder;
pub mod interrupt;
pub mod launch;
pub mod limits;
pub mod progress;
mod run;
mod stopped;
pub mod tell;
pub mod verdict;
pub mod version;
pub mod vtu;
pub mod watch;

pub use folder::fresh::fresh_folder;
pub use run::{Outcome, Runner, Voice, unfinished};
