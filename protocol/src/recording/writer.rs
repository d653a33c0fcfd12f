//! The recorder: a queue that never makes its caller wait, and the thread that writes the file.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::channel::Channel;
use crate::header::FieldHeader;
use crate::messages::Role;

use super::entry::{Key, Kind};
use super::error::RecordingError;
use super::tap::Tap;
use super::{Begin, Compression};

mod file;

/// How a recording is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Of the chunks.
    pub compression: Compression,
    /// Bytes that may wait for the disk; more end the recording.
    pub queue: usize,
    /// How long the end of a run may wait for the disk.
    pub patience: Duration,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            compression: Compression::Zstd,
            queue: 256 << 20,
            patience: Duration::from_secs(60),
        }
    }
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

/// Bytes of a control message or numbers of a field.
pub(super) enum Payload {
    Numbers(Vec<f64>),
    Bytes(Vec<u8>),
}

/// A message on its way to the file.
struct Raw {
    seat: Role,
    kind: Kind,
    key: Key,
    header: FieldHeader,
    wall: u64,
    size: usize,
    payload: Payload,
}

enum Item {
    Message(Raw),
    /// The run is over: its exit code, and where to tell the outcome.
    Finish(i32, Sender<Outcome>),
}

/// Hands messages to the recorder; one a link.
#[derive(Clone)]
pub(super) struct Feed {
    queue: Sender<Item>,
    shared: Arc<Shared>,
}

struct Shared {
    limit: usize,
    waiting: AtomicUsize,
    /// Nothing is taken any more.
    over: AtomicBool,
    why: Mutex<Option<String>>,
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

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Feed {
    pub(super) fn enter(&self, role: Role, step: u64, pass: u32) {
        lock(&self.shared.clock).enter(role, step, pass);
    }

    pub(super) fn asked(&self, role: Role, pass: u32) {
        lock(&self.shared.clock).asked[role as usize] = Some(pass);
    }

    /// Queue a message; `copy` is called when it will be written. Never waits.
    pub(super) fn take(
        &self,
        seat: Role,
        kind: Kind,
        header: FieldHeader,
        size: usize,
        copy: impl FnOnce() -> Payload,
    ) {
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
    /// Take nothing any more; the first reason counts.
    fn end(&self, why: String) {
        if !self.over.swap(true, Ordering::AcqRel) {
            tracing::warn!("the recording ends here, the run goes on: {why}");
            *lock(&self.why) = Some(why);
        }
    }
}

fn now() -> u64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |elapsed| elapsed.as_nanos() as u64)
}

/// Records what passes through its taps.
pub struct Recorder {
    path: PathBuf,
    patience: Duration,
    feed: Feed,
}

impl Recorder {
    /// Make the file. What goes wrong with it later ends the recording and is told by
    /// [`Recorder::finish`].
    pub fn create(
        path: &Path,
        options: Options,
        begin: &Begin,
    ) -> Result<Recorder, RecordingError> {
        let unusable = |error| RecordingError::file("cannot write the recording", path, error);
        let file = File::create(path).map_err(unusable)?;
        let (queue, items) = channel();
        let shared = Arc::new(Shared {
            limit: options.queue,
            waiting: AtomicUsize::new(0),
            over: AtomicBool::new(false),
            why: Mutex::default(),
            clock: Mutex::default(),
        });
        let begin =
            serde_json::to_vec(begin).map_err(|error| unusable(std::io::Error::other(error)))?;
        let theirs = Arc::clone(&shared);
        std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || write(file, options.compression, &begin, &items, &theirs))
            .map_err(unusable)?;
        Ok(Recorder {
            path: path.to_path_buf(),
            patience: options.patience,
            feed: Feed { queue, shared },
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Why nothing is recorded any more, when that is so.
    pub fn trouble(&self) -> Option<String> {
        if !self.feed.shared.over.load(Ordering::Acquire) {
            return None;
        }
        lock(&self.feed.shared.why).clone()
    }

    /// The coupler's end of a link, recorded.
    pub fn tap(&self, role: Role, channel: Box<dyn Channel>) -> Box<dyn Channel> {
        Box::new(Tap {
            inner: channel,
            role,
            feed: self.feed.clone(),
        })
    }

    /// The run ends with this exit code: write what waits, and the end. Waits for the disk, but not
    /// for ever.
    pub fn finish(self, exit: i32) -> Outcome {
        let (reply, outcome) = channel();
        let shared = &self.feed.shared;
        let _ = self.feed.queue.send(Item::Finish(exit, reply));
        outcome.recv_timeout(self.patience).unwrap_or_else(|_| {
            let waiting = shared.waiting.load(Ordering::Acquire);
            shared.end(format!(
                "{:.1} MB were not taken by the disk within {} s",
                waiting as f64 / 1e6,
                self.patience.as_secs_f64()
            ));
            Outcome {
                complete: false,
                why: lock(&shared.why).clone(),
                messages: 0,
                bytes: std::fs::metadata(&self.path).map_or(0, |meta| meta.len()),
                cpu_seconds: 0.0,
            }
        })
    }
}

/// Body of the thread: messages in the order they come, until the end of the run.
fn write(
    file: File,
    compression: Compression,
    begin: &[u8],
    items: &Receiver<Item>,
    shared: &Shared,
) {
    let mut output = file::Output::create(file, compression, begin);
    if let Err(why) = &output {
        shared.end(why.clone());
    }
    let mut finish = None;
    loop {
        let item = items.recv_timeout(file::CHUNK_AGE);
        let result = match (item, &mut output) {
            (Ok(Item::Message(raw)), Ok(output)) => {
                let result = output.message(&raw);
                shared.waiting.fetch_sub(raw.size, Ordering::AcqRel);
                result
            }
            (Ok(Item::Message(raw)), Err(_)) => {
                shared.waiting.fetch_sub(raw.size, Ordering::AcqRel);
                Ok(())
            }
            (Err(std::sync::mpsc::RecvTimeoutError::Timeout), Ok(output)) => output.flush(),
            (Err(std::sync::mpsc::RecvTimeoutError::Timeout), Err(_)) => Ok(()),
            (Ok(Item::Finish(exit, reply)), _) => {
                finish = Some((exit, reply));
                break;
            }
            // Dropped without finish(): the run broke.
            (Err(std::sync::mpsc::RecvTimeoutError::Disconnected), _) => {
                shared.end("the run ended without a word".to_owned());
                break;
            }
        };
        if let Err(why) = result {
            shared.end(why.clone());
            let broken = std::mem::replace(&mut output, Err(why));
            let _ = broken.map(file::Output::abandon);
        }
    }
    let why = lock(&shared.why).clone();
    let exit = finish.as_ref().map(|(exit, _)| *exit);
    let written = output.and_then(|output| output.end(why.clone(), exit));
    let cpu_seconds = cpu_of_this_thread();
    let outcome = match written {
        Ok((messages, bytes)) => Outcome {
            complete: why.is_none(),
            why,
            messages,
            bytes,
            cpu_seconds,
        },
        Err(error) => {
            shared.end(error);
            Outcome {
                complete: false,
                why: lock(&shared.why).clone(),
                messages: 0,
                bytes: 0,
                cpu_seconds,
            }
        }
    };
    if let Some((_, reply)) = finish {
        let _ = reply.send(outcome);
    }
}

fn cpu_of_this_thread() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
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
