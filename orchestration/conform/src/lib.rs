//! Does a command speak the protocol, and does an engine answer as it was recorded?
//!
//! Each check starts a fresh process of the command in a run of its own and plays the coupler, well or
//! badly: `case` is what the engine is configured with and the inputs it is given, `subject` a process of
//! the command, `bench` the coupler's end of its link, `check` the form of a check, `checks` all of them,
//! `report` what came out. `replay` plays the coupler of a recording.

mod bench;
pub mod case;
mod check;
pub mod checks;
pub mod replay;
pub mod report;
mod subject;
