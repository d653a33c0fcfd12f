//! What can go wrong between processes. Every message names who, at which step, waiting for what;
//! the exit code of a process follows from the variant.

use super::field::Field;
use super::message::{Failure, FailureKind};

/// An error of an exchange between two processes of a run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A partner speaks another protocol, takes the wrong seat or cannot be joined.
    #[error("handshake with the {who}: {why}")]
    Handshake {
        /// The partner.
        who: String,
        /// What does not fit, with both values.
        why: String,
    },
    /// A partner process ended, or left, while it was needed.
    #[error("the {who} is gone at step {step}, while waiting for {awaited}")]
    PartnerLost {
        /// The partner that ended.
        who: String,
        /// The step of this link when it was noticed.
        step: u64,
        /// What this process was waiting for.
        awaited: String,
    },
    /// A partner is alive and silent for longer than allowed.
    #[error("the {who} did not send {awaited} within {seconds} s at step {step}")]
    TimeLimit {
        /// The silent partner.
        who: String,
        /// The step of this link.
        step: u64,
        /// What this process was waiting for.
        awaited: String,
        /// The limit \[s\].
        seconds: f64,
    },
    /// An engine answered that it cannot do what was asked.
    #[error("the {who} failed at step {step}: {}", failure.why)]
    Engine {
        /// The engine.
        who: String,
        /// The step of this link.
        step: u64,
        /// Its own words and the class of the failure.
        failure: Failure,
    },
    /// A message, a header or a field is not what the contract allows here.
    #[error("invalid {what} from the {who} at step {step}: {why}")]
    Invalid {
        /// The sender.
        who: String,
        /// The step of this link.
        step: u64,
        /// Which message, header value or field.
        what: String,
        /// The value and the bound.
        why: String,
    },
    /// A field contains NaN or an infinity.
    #[error(
        "{} of the {who} is {value} at {support} {index} (component {component}), step {step}",
        field.name()
    )]
    NotFinite {
        /// The sender.
        who: String,
        /// The step of this link.
        step: u64,
        /// The field.
        field: Field,
        /// "node", "simplex" or "grain".
        support: &'static str,
        /// Number of the node, simplex or grain, from 0.
        index: usize,
        /// Component within it, from 0.
        component: usize,
        /// The value as text.
        value: String,
    },
    /// The transport refused an operation.
    #[error("transport: {what}: {why}")]
    Transport {
        /// The operation.
        what: String,
        /// What the transport said.
        why: String,
    },
    /// Shared memory is missing, too small or not accessible.
    #[error("shared memory: {what}: {why}")]
    SharedMemory {
        /// The operation and the place.
        what: String,
        /// The reason, with the remedy where there is one.
        why: String,
    },
}

impl Error {
    /// The exit code of a process that ends with this error (`sillage` documents the list).
    pub fn exit_code(&self) -> i32 {
        match self {
            Error::Handshake { .. } => 3,
            Error::PartnerLost { .. } => 5,
            Error::TimeLimit { .. } => 6,
            Error::Engine { failure, .. } => failure.kind.exit_code(),
            Error::Invalid { .. } | Error::NotFinite { .. } => 7,
            Error::Transport { .. } | Error::SharedMemory { .. } => 4,
        }
    }

    /// What `who` sent is not what the contract allows: which part, and why.
    pub fn invalid(who: &str, step: u64, what: impl Into<String>, why: impl Into<String>) -> Error {
        Error::Invalid {
            who: who.to_owned(),
            step,
            what: what.into(),
            why: why.into(),
        }
    }

    pub(crate) fn transport(what: impl Into<String>, why: impl std::fmt::Display) -> Error {
        Error::Transport {
            what: what.into(),
            why: why.to_string(),
        }
    }

    pub(crate) fn memory(what: impl Into<String>, why: impl std::fmt::Display) -> Error {
        Error::SharedMemory {
            what: what.into(),
            why: why.to_string(),
        }
    }
}

impl FailureKind {
    /// The exit code of this class of failures.
    pub fn exit_code(self) -> i32 {
        match self {
            FailureKind::Scene => 2,
            FailureKind::Engine => 4,
            FailureKind::NotFinite => 7,
            FailureKind::NotConverged => 8,
        }
    }
}

impl Failure {
    /// A failure of this class.
    pub fn new(kind: FailureKind, why: impl Into<String>) -> Failure {
        Failure {
            kind,
            why: why.into(),
        }
    }
}
