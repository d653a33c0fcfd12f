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
//! | `fluid/request`, `particles/request` | JSON of a [`ToEngine`](protocol::message::ToEngine) |
//! | `fluid/answer`, `particles/answer` | JSON of a [`ToCoupler`](protocol::message::ToCoupler) |
//! | `run/end` | JSON [`End`]: whether all is in it, and how the run ended |
//!
//! Every payload stands behind 64 bytes: the header of the wire, in which bytes 56–59 are the CRC-32C
//! of all others and of the payload, and bytes 60–63 the attempt. `log_time` is the integer [`Key`],
//! `publish_time` the wall clock in ns since 1970, `sequence` counts messages without a gap.
//!
//! The recorder never waits: what the writing thread cannot take any more (queue full, disk full) ends
//! the recording, not the run. Chunks are written whole, at least once a second, so the file of a
//! killed run can be read up to its last whole chunk.

mod begin;
mod chunks;
pub mod compare;
pub mod diff;
mod entry;
mod error;
mod lengths;
mod reader;
mod replay;
mod summary;
mod write;

pub use begin::{Begin, Compression, End, FORMAT};
pub use entry::{Body, Entry, Key};
pub use error::RecordingError;
pub use reader::{Ending, Reader};
pub use replay::{ReplayError, Report, replay};
pub use summary::summary;
pub use write::feed::Outcome;
pub use write::recorder::{Options, Recorder};
