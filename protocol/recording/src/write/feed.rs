//! The queue between the links of a run and the thread that writes: it never makes its caller wait, and
//! numbers what passes.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use protocol::header::FieldHeader;
use protocol::message::Role;

use crate::entry::{Key, Kind};

/// Bytes of a control message or numbers of a field.
pub(crate) enum Payload {
    Numbers(Vec<f64>),
    Bytes(Vec<u8>),
}

/// A message on its way to the file.
pub(crate) struct Raw {
    pub(crate) seat: Role,
    pub(crate) kind: Kind,
    pub(crate) key: Key,
    pub(crate) header: FieldHeader,
    pub(crate) wall: u64,
    pub(crate) size: usize,
    pub(crate) payload: Payload,
}

pub(crate) enum Item {
    Message(Raw),
    /// Bring all before it to the disk, and tell whether that was done.
    Settle(Sender<bool>),
    /// The run is over: its exit code, and where to tell the outcome.
    Finish(i32, Sender<Outcome>),
}

/// What became of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Is every message in the file?
    pub complete: bool,
    /// Why not.
    pub why: Option<String>,
    /// Messages in the file.
    pub messages: u64,
    /// Its size.
    pub bytes: u64,
    /// CPU time of the writing thread \[s\].
    pub cpu_seconds: f64,
}

/// Hands messages to the recorder; one a link.
#[derive(Clone)]
pub(crate) struct Feed {
    pub(crate) queue: Sender<Item>,
    pub(crate) shared: Arc<Shared>,
}

pub(crate) struct Shared {
    limit: usize,
    pub(crate) waiting: AtomicUsize,
    /// Nothing is taken any more.
    pub(crate) over: AtomicBool,
    /// What passes now is left out.
    pub(crate) paused: AtomicBool,
    /// Messages taken so far.
    pub(crate) passed: AtomicU64,
    pub(crate) why: Mutex<Option<String>>,
    clock: Mutex<Clock>,
}

/// Where the exchange is.
#[derive(Default)]
struct Clock {
    key: Key,
    /// Pass that each seat was last asked for in this attempt.
    asked: [Option<u32>; 2],
}

impl Clock {
    /// An exchange of this step and pass begins or goes on. A pass that comes again, or falls, is
    /// another attempt at the step.
    fn enter(&mut self, role: Role, step: u64, pass: u32) {
        let key = self.key;
        let again = pass < key.pass || self.asked[role as usize].is_some_and(|asked| asked >= pass);
        if step != key.step || again {
            let attempt = if step == key.step { key.attempt + 1 } else { 0 };
            self.asked = [None; 2];
            self.key = Key {
                step,
                attempt,
                pass,
                place: 0,
            };
        } else if pass != key.pass {
            self.key = Key {
                pass,
                place: 0,
                ..key
            };
        }
    }

    fn next(&mut self) -> Key {
        let key = self.key;
        self.key.place += 1;
        key
    }
}

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Feed {
    pub(crate) fn enter(&self, role: Role, step: u64, pass: u32) {
        lock(&self.shared.clock).enter(role, step, pass);
    }

    pub(crate) fn asked(&self, role: Role, pass: u32) {
        lock(&self.shared.clock).asked[role as usize] = Some(pass);
    }

    /// Queue a message; `copy` is called when it will be written. Never waits.
    pub(crate) fn take(
        &self,
        seat: Role,
        kind: Kind,
        header: FieldHeader,
        size: usize,
        copy: impl FnOnce() -> Payload,
    ) {
        if self.shared.paused.load(Ordering::Acquire) {
            return;
        }
        let key = lock(&self.shared.clock).next();
        if self.shared.over.load(Ordering::Acquire) {
            return;
        }
        let waiting = self.shared.waiting.load(Ordering::Acquire);
        if waiting > 0 && waiting + size > self.shared.limit {
            let why = format!(
                "at step {}, {:.0} MB waited for the disk and {:.0} MB are allowed to",
                key.step,
                (waiting + size) as f64 / 1e6,
                self.shared.limit as f64 / 1e6
            );
            self.shared.end(why);
            return;
        }
        self.shared.waiting.fetch_add(size, Ordering::AcqRel);
        self.shared.passed.fetch_add(1, Ordering::AcqRel);
        let raw = Raw {
            seat,
            kind,
            key,
            header,
            wall: now(),
            size,
            payload: copy(),
        };
        // Without a reader the thread broke; finish() finds out.
        let _ = self.queue.send(Item::Message(raw));
    }
}

impl Shared {
    /// Of a recording for which `limit` bytes may wait.
    pub(crate) fn with_room_for(limit: usize) -> Arc<Shared> {
        Arc::new(Shared {
            limit,
            waiting: AtomicUsize::new(0),
            over: AtomicBool::new(false),
            paused: AtomicBool::new(false),
            passed: AtomicU64::new(0),
            why: Mutex::default(),
            clock: Mutex::default(),
        })
    }

    /// Take nothing any more; the first reason counts.
    pub(crate) fn end(&self, why: String) {
        if !self.over.swap(true, Ordering::AcqRel) {
            tracing::warn!("the recording ends here, the run goes on: {why}");
            *lock(&self.why) = Some(why);
        }
    }
}

pub(crate) fn now() -> u64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |elapsed| elapsed.as_nanos() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_that_comes_again_is_another_attempt_at_the_step() {
        use Role::{Fluid, Particles};
        let mut clock = Clock::default();
        let mut seen = Vec::new();
        // Predicted, two passes; the second fails in the particles; again with half the step;
        // the next step has no prediction and fails at once in the fluid.
        let asked = [
            (Particles, 1, 0, 0),
            (Fluid, 1, 1, 0),
            (Particles, 1, 1, 0),
            (Fluid, 1, 2, 0),
            (Particles, 1, 2, 0),
            (Particles, 1, 0, 1),
            (Fluid, 1, 1, 1),
            (Particles, 1, 1, 1),
            (Fluid, 2, 1, 0),
            (Fluid, 2, 1, 1),
            (Particles, 2, 1, 1),
        ];
        for (role, step, pass, attempt) in asked {
            // two fields, then the message
            for _ in 0..3 {
                clock.enter(role, step, pass);
                let key = clock.next();
                assert_eq!((key.step, key.attempt, key.pass), (step, attempt, pass));
                seen.push(key);
            }
            clock.asked[role as usize] = Some(pass);
        }
        assert!(seen.is_sorted_by(|a, b| a < b), "{seen:?}");
    }
}
