//! The recorder: makes the file and the thread that writes it, hands out taps, ends the recording.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use protocol::channel::Channel;
use protocol::message::Role;

use crate::begin::{Begin, Compression};
use crate::error::RecordingError;
use crate::reader::Reader;

use super::feed::{Feed, Item, Outcome, Shared, lock};
use super::file::{CHUNK_AGE, Output};
use super::tap::Tap;

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
        let file = File::create(path).map_err(|error| unusable(path, error))?;
        let (compression, dimension) = (options.compression, begin.scene.dimension);
        let begin = json(path, begin)?;
        let open = move || Output::create(file, compression, &begin, dimension);
        Recorder::start(path, options, 0, open)
    }

    /// Go on with a recording from its first `messages` of the links; what came after is cut off. The file is
    /// replaced in one move.
    pub fn resume(
        path: &Path,
        options: Options,
        begin: &Begin,
        messages: u64,
    ) -> Result<Recorder, RecordingError> {
        let mut before = Reader::open(path)?;
        let draft = path.with_extension("part");
        let file = File::create(&draft).map_err(|error| unusable(&draft, error))?;
        let told = |why: String| unusable(&draft, std::io::Error::other(why));
        let dimension = begin.scene.dimension;
        let output = Output::create(file, options.compression, &json(path, begin)?, dimension);
        let mut output = output.map_err(told)?;
        for number in 0..messages {
            let Some(message) = before.next_copied()? else {
                return Err(RecordingError::Short {
                    path: path.to_path_buf(),
                    messages: number,
                    expected: messages,
                });
            };
            output.copy(&message).map_err(told)?;
        }
        output.settle().map_err(told)?;
        std::fs::rename(&draft, path).map_err(|error| unusable(path, error))?;
        Recorder::start(path, options, messages, move || Ok(output))
    }

    /// The thread that writes, after `passed` messages.
    fn start(
        path: &Path,
        options: Options,
        passed: u64,
        open: impl FnOnce() -> Result<Output, String> + Send + 'static,
    ) -> Result<Recorder, RecordingError> {
        let (queue, items) = channel();
        let shared = Shared::with_room_for(options.queue);
        shared.passed.store(passed, Ordering::Release);
        let theirs = std::sync::Arc::clone(&shared);
        std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || write(open(), &items, &theirs))
            .map_err(|error| unusable(path, error))?;
        Ok(Recorder {
            path: path.to_path_buf(),
            patience: options.patience,
            feed: Feed { queue, shared },
        })
    }

    /// Messages of the links taken so far.
    pub fn passed(&self) -> u64 {
        self.feed.shared.passed.load(Ordering::Acquire)
    }

    /// Leave out what passes, or take it again.
    pub fn pause(&self, paused: bool) {
        self.feed.shared.paused.store(paused, Ordering::Release);
    }

    /// Wait until all that has passed is on the disk, but not for ever; false where it is not.
    pub fn settle(&self) -> bool {
        let (reply, settled) = channel();
        let _ = self.feed.queue.send(Item::Settle(reply));
        settled.recv_timeout(self.patience).unwrap_or(false)
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

fn unusable(path: &Path, error: std::io::Error) -> RecordingError {
    RecordingError::file("cannot write the recording", path, error)
}

fn json(path: &Path, begin: &Begin) -> Result<Vec<u8>, RecordingError> {
    serde_json::to_vec(begin).map_err(|error| unusable(path, std::io::Error::other(error)))
}

/// Body of the thread: messages in the order they come, until the end of the run.
fn write(mut output: Result<Output, String>, items: &Receiver<Item>, shared: &Shared) {
    if let Err(why) = &output {
        shared.end(why.clone());
    }
    let mut finish = None;
    loop {
        let item = items.recv_timeout(CHUNK_AGE);
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
            (Ok(Item::Settle(reply)), output) => {
                let settled = match output {
                    Ok(output) => output.settle(),
                    Err(_) => Ok(()),
                };
                let _ = reply.send(output.is_ok() && settled.is_ok());
                settled
            }
            (Err(RecvTimeoutError::Timeout), Ok(output)) => output.flush(),
            (Err(RecvTimeoutError::Timeout), Err(_)) => Ok(()),
            (Ok(Item::Finish(exit, reply)), _) => {
                finish = Some((exit, reply));
                break;
            }
            // Dropped without finish(): the run broke.
            (Err(RecvTimeoutError::Disconnected), _) => {
                shared.end("the run ended without a word".to_owned());
                break;
            }
        };
        if let Err(why) = result {
            shared.end(why.clone());
            let broken = std::mem::replace(&mut output, Err(why));
            let _ = broken.map(Output::abandon);
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
