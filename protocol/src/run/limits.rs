//! Every limit on waiting that is not a key of the scene, in one table; each can be set in the
//! environment, in seconds.

use std::time::Duration;

/// A limit on waiting.
#[derive(Debug)]
pub struct Limit {
    /// Environment variable that sets it \[s\].
    pub variable: &'static str,
    /// What holds without it \[s\].
    pub default: f64,
    /// Who waits for what.
    pub what: &'static str,
}

/// An engine for its coupler.
pub const CONNECT: Limit = Limit {
    variable: "SILLAGE_CONNECT_LIMIT",
    default: 60.0,
    what: "an engine for the coupler to listen, and for the fields of a message",
};
/// An engine for the next message.
pub const IDLE: Limit = Limit {
    variable: "SILLAGE_IDLE_LIMIT",
    default: 86_400.0,
    what: "an engine for its next message",
};
/// Coupler for orchestrator.
pub const TAKE_OVER: Limit = Limit {
    variable: "SILLAGE_TAKE_OVER_LIMIT",
    default: 120.0,
    what: "the coupler for the orchestrator to take a message or a state over, also while the disk is full",
};
/// Orchestrator for a process that was stopped.
pub const STOPPED: Limit = Limit {
    variable: "SILLAGE_STOPPED_LIMIT",
    default: 60.0,
    what: "the orchestrator for a process that was stopped (SIGSTOP) to go on",
};
/// Between coupler and orchestrator.
pub const MONITOR: Limit = Limit {
    variable: "SILLAGE_MONITOR_LIMIT",
    default: 30.0,
    what: "coupler and orchestrator for each other's end, and for the fields of a message",
};
/// A sender for room.
pub const QUEUE: Limit = Limit {
    variable: "SILLAGE_QUEUE_LIMIT",
    default: 10.0,
    what: "coupler and engine for room in the other's queue",
};
/// The coupler for an engine to leave.
pub const LEAVE: Limit = Limit {
    variable: "SILLAGE_LEAVE_LIMIT",
    default: 10.0,
    what: "the coupler for an engine to leave after `Finish`",
};
/// Anybody for the lock of a run's folder.
pub const LOCK: Limit = Limit {
    variable: "SILLAGE_LOCK_LIMIT",
    default: 10.0,
    what: "anybody for the lock of the run's private folder",
};

/// All of them.
pub const ALL: [&Limit; 8] = [
    &CONNECT, &IDLE, &QUEUE, &LEAVE, &MONITOR, &TAKE_OVER, &STOPPED, &LOCK,
];

impl Limit {
    /// As long as the environment says, or by default; what is no number of seconds is not heeded.
    pub fn duration(&self) -> Duration {
        let asked = std::env::var(self.variable).ok();
        let asked = asked.and_then(|text| text.parse::<f64>().ok());
        let usable = asked.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        usable.unwrap_or_else(|| Duration::from_secs_f64(self.default))
    }
}
