//! The one language between Sillage's processes.
//!
//! ```text
//!   coupler                         fluid engine            particle engine
//!      │  Advance + solid's response   │                        │
//!      ├──────────────────────────────►│  solve u, p            │
//!      │◄──────── Done + v, ∇p, p ─────┤                        │
//!      │  Advance + γ, q                                        │
//!      ├───────────────────────────────────────────────────────►│ free velocity, contacts
//!      │◄─────────────────────── Done + x, v, contact state ────┤
//!      │  accept: Commit to both, or another pass               │
//! ```

mod coupler;
mod language;
pub mod monitor;
mod run;
mod transport;

pub use coupler::partner;
pub use language::error::Error;
pub use language::header::PROTOCOL_VERSION;
pub use language::{codec, engine, error, field, header, message, report, scene};
pub use run::{awake, checkpoints, limits, process, runspace};
pub use transport::{channel, ipc, local};

/// The engine in the guide compiles.
#[cfg(doctest)]
#[doc = include_str!("../../docs/writing-an-engine.md")]
struct Guide;
