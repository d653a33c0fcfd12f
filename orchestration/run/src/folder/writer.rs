//! Writing beside the run: messages queue up, and a thread writes them, so that a slow disk or a
//! large picture does not hold the coupler up, up to a point.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use protocol::message::ToOrchestrator;
use protocol::monitor::Event;
use scene::error::{Error, exit_code};

use super::draw::Draw;
use super::run_folder::RunFolder;
use crate::disk::{Disk, Trouble};

/// States and messages that may wait to be written; a coupler that is further ahead of the disk waits, so
/// that memory stays bounded.
const STATES_WAITING: usize = 4;
const MESSAGES_WAITING: usize = 256;
/// How often the end of the thread is looked for.
const TICK: Duration = Duration::from_millis(5);

/// The thread that writes.
pub struct Writer {
    queue: Sender<Event>,
    waiting: Arc<Waiting>,
    disk: Disk,
    thread: JoinHandle<Outcome>,
}

#[derive(Default)]
struct Waiting {
    states: AtomicUsize,
    messages: AtomicUsize,
}

/// The folder, and the first error; after an error the rest is dropped.
type Outcome = (RunFolder, Result<(), Error>);

impl Writer {
    /// Start writing to a folder, with its pictures.
    pub fn start(mut folder: RunFolder, mut pictures: Box<dyn Draw>, disk: Disk) -> Writer {
        let (queue, events) = channel::<Event>();
        let waiting = Arc::new(Waiting::default());
        let (left, own) = (Arc::clone(&waiting), disk.clone());
        let thread = std::thread::spawn(move || {
            let mut outcome = Ok(());
            for event in events {
                if outcome.is_ok() {
                    outcome = match event.message {
                        ToOrchestrator::Checkpoint { step, time } => {
                            folder.keep((step, time), pictures.keep(), &own)
                        }
                        _ => {
                            let written = folder.take(&event, &own);
                            written.and_then(|()| pictures.take(&event, &own))
                        }
                    };
                }
                left.messages.fetch_sub(1, Ordering::SeqCst);
                left.states
                    .fetch_sub(usize::from(is_state(&event)), Ordering::SeqCst);
            }
            let outcome = outcome.and_then(|()| pictures.finish(&own));
            (folder, outcome)
        });
        Writer {
            queue,
            waiting,
            disk,
            thread,
        }
    }

    /// Hand a message over; never waits.
    pub fn take(&self, event: Event) {
        let states = usize::from(is_state(&event));
        self.waiting.states.fetch_add(states, Ordering::SeqCst);
        self.waiting.messages.fetch_add(1, Ordering::SeqCst);
        // The thread ends only after the queue: this cannot fail while it is alive.
        let _ = self.queue.send(event);
    }

    /// May the run go on, or is it too far ahead of the disk?
    pub fn has_room(&self) -> bool {
        let waits = matches!(self.disk.trouble(), Trouble::Waiting(_));
        !waits
            && self.waiting.states.load(Ordering::SeqCst) < STATES_WAITING
            && self.waiting.messages.load(Ordering::SeqCst) < MESSAGES_WAITING
    }

    /// How writing goes.
    pub fn trouble(&self) -> Trouble {
        self.disk.trouble()
    }

    /// Wait until all is written; `look` is called again and again, and may abandon the disk.
    pub fn finish(self, mut look: impl FnMut(&Disk)) -> Result<Outcome, Error> {
        drop(self.queue);
        while !self.thread.is_finished() {
            look(&self.disk);
            std::thread::sleep(TICK);
        }
        self.thread.join().map_err(|_| Error::Run {
            code: exit_code::ENGINE,
            why: "the thread that writes the run folder broke".into(),
        })
    }
}

fn is_state(event: &Event) -> bool {
    matches!(event.message, ToOrchestrator::Snapshot { .. })
}
