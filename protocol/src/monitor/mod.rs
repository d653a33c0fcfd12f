//! The link between coupler and orchestrator: steps and snapshots one way, stop the other.
//!
//! `SnapshotTaken` acknowledges a snapshot, and also `Started` (a queue that fills up before its
//! reader has looked at it for the first time is lost), `Finished` and `Stopped` (the coupler does
//! not close its buffers before the orchestrator has read the last of them).

pub mod columns;
mod receiver;
mod sender;

pub use receiver::{Event, MonitorReceiver};
pub use sender::MonitorSender;
