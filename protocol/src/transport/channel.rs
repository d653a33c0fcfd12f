//! What the protocol needs from a transport. Two back ends: `ipc` between processes, `local`
//! between threads. Nothing above this trait knows about shared memory, so a network can follow.

use std::time::Duration;

use crate::language::error::Error;
use crate::language::field::Field;
use crate::language::header::FieldHeader;
use crate::run::awake;

/// What a receiver waits for, and for how long at most.
#[derive(Debug, Clone, Copy)]
pub struct Wait<'a> {
    /// Step of the link, for error messages.
    pub step: u64,
    /// What is awaited, for error messages.
    pub awaited: &'a str,
    /// When waiting began, by the clock of `awake`.
    since: Duration,
    /// How long it may last, in time in which the waiter itself could look.
    limit: Duration,
}

impl<'a> Wait<'a> {
    /// From now on, for at most `limit`.
    pub fn new(step: u64, awaited: &'a str, limit: Duration) -> Wait<'a> {
        Wait {
            step,
            awaited,
            since: awake::now(),
            limit,
        }
    }

    /// The same deadline, for another thing.
    pub fn awaiting(self, awaited: &'a str) -> Wait<'a> {
        Wait { awaited, ..self }
    }

    /// Time left until the deadline.
    pub fn left(&self) -> Duration {
        let waited = awake::now().saturating_sub(self.since);
        self.limit.saturating_sub(waited)
    }

    /// The error of a deadline that passed.
    pub fn passed(&self, who: &str) -> Error {
        Error::TimeLimit {
            who: who.to_owned(),
            step: self.step,
            awaited: self.awaited.to_owned(),
            seconds: self.limit.as_secs_f64(),
        }
    }

    /// The error of a partner that is gone.
    pub fn lost(&self, who: &str) -> Error {
        Error::PartnerLost {
            who: who.to_owned(),
            step: self.step,
            awaited: self.awaited.to_owned(),
        }
    }
}

/// A duration of a scene; what is not a usable number of seconds becomes a century.
pub fn seconds(limit: f64) -> Duration {
    const CENTURY: f64 = 3.2e9;
    Duration::from_secs_f64(if limit >= 0.0 {
        limit.min(CENTURY)
    } else {
        CENTURY
    })
}

/// A buffer of the transport that will be sent; written in place.
pub trait Loan {
    /// The numbers, NaN until they are written: what an engine forgets is refused by the receiver.
    fn values(&mut self) -> &mut [f64];
    /// Send it; without this the buffer goes back unsent.
    fn send(self: Box<Self>) -> Result<(), Error>;
}

/// A field that arrived; read in place, given back when dropped.
pub trait Received {
    /// Its header, not validated yet.
    fn header(&self) -> &FieldHeader;
    /// Its numbers, not validated yet.
    fn values(&self) -> &[f64];
}

/// One end of a link between two processes. Each direction is in order; fields are sent before
/// the message that lists them, and the message wakes the receiver.
pub trait Channel {
    /// Name of the partner at the other end.
    fn peer(&self) -> &str;
    /// Send a message and wake the partner. `false`: nobody listens.
    fn send_message(&mut self, header: FieldHeader, bytes: &[u8]) -> Result<bool, Error>;
    /// The message that is there, if one is.
    fn poll_message(&mut self) -> Result<Option<(FieldHeader, Vec<u8>)>, Error>;
    /// Block until a message is there.
    fn receive_message(&mut self, wait: Wait<'_>) -> Result<(FieldHeader, Vec<u8>), Error>;
    /// A buffer of `header.count` numbers for `field`.
    fn loan_field(&mut self, field: Field, header: FieldHeader) -> Result<Box<dyn Loan>, Error>;
    /// Send a copy of `values`.
    fn send_field(
        &mut self,
        field: Field,
        header: FieldHeader,
        values: &[f64],
    ) -> Result<(), Error>;
    /// Block until a field is there.
    fn receive_field(&mut self, field: Field, wait: Wait<'_>) -> Result<Box<dyn Received>, Error>;
    /// Block until anything may have changed, at most for `limit`; errors when the partner is gone.
    fn idle(&mut self, wait: Wait<'_>, limit: Duration) -> Result<(), Error>;
    /// Block until the partner has left; `false` when it has not within the limit.
    fn wait_for_leave(&mut self, limit: Duration) -> bool;
    /// Would a message reach somebody?
    fn has_reader(&mut self) -> Result<bool, Error>;
    /// Whom to name when a message or field found no receiver: who was lost, else the partner.
    fn culprit(&mut self) -> String;
    /// Is any process of the run known to be lost?
    fn anyone_is_lost(&self) -> bool;
    /// Is the partner known to be gone?
    fn peer_is_gone(&self) -> bool;
    /// What an engine must show, where somebody else could have opened the link.
    fn token(&self) -> Option<&str>;
}
