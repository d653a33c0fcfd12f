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

pub mod channel;
pub mod codec;
pub mod configure;
mod convection;
pub mod engine;
pub mod error;
pub mod field;
pub mod header;
mod iox;
pub mod ipc;
pub mod links;
mod liveness;
pub mod local;
mod members;
pub mod messages;
pub mod monitor;
pub mod partner;
pub mod process;
pub mod runspace;
mod seats;
mod serve;
mod services;

pub use error::Error;

/// Version of the messages and of the header; both sides of a link must agree on it.
pub const PROTOCOL_VERSION: u32 = 1;

/// The engine in the guide compiles.
#[cfg(doctest)]
#[doc = include_str!("../../docs/writing-an-engine.md")]
struct Guide;
