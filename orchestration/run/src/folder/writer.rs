//! Writing beside the run: messages queue up, and a thread writes them, so that a slow disk or a
//! large picture does not hold the coupler up.

use std::sync::mpsc::{Sender, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

use protocol::message::ToOrchestrator;
use protocol::monitor::Event;
use scene::error::{Error, exit_code};

use super::draw::Draw;
use super::run_folder::RunFolder;

/// States that may wait to be written; a coupler that is further ahead of the disk waits, so that
/// memory stays bounded. Steps are small and always queue up.
const STATES_WAITING: usize = 4;

/// The thread that writes.
pub struct Writer {
    queue: Sender<Event>,
    places: SyncSender<()>,
    thread: JoinHandle<Outcome>,
}

/// The folder, and the first error; after an error the rest is dropped.
type Outcome = (RunFolder, Result<(), Error>);

impl Writer {
    /// Start writing to a folder, with its pictures.
    pub fn start(mut folder: RunFolder, mut pictures: Box<dyn Draw>) -> Writer {
        let (queue, events) = channel::<Event>();
        let (places, taken) = sync_channel::<()>(STATES_WAITING);
        let thread = std::thread::spawn(move || {
            let mut outcome = Ok(());
            for event in events {
                let is_state = is_state(&event);
                if outcome.is_ok() {
                    outcome = folder.take(&event).and_then(|()| pictures.take(&event));
                }
                if is_state {
                    let _ = taken.recv();
                }
            }
            let outcome = outcome.and_then(|()| pictures.finish());
            (folder, outcome)
        });
        Writer {
            queue,
            places,
            thread,
        }
    }

    /// Hand a message over; waits only when many states are waiting.
    pub fn take(&self, event: Event) {
        // The thread ends only after the queue: neither can fail while it is alive.
        if is_state(&event) {
            let _ = self.places.send(());
        }
        let _ = self.queue.send(event);
    }

    /// Wait until all is written.
    pub fn finish(self) -> Result<Outcome, Error> {
        drop(self.queue);
        self.thread.join().map_err(|_| Error::Run {
            code: exit_code::ENGINE,
            why: "the thread that writes the run folder broke".into(),
        })
    }
}

fn is_state(event: &Event) -> bool {
    matches!(event.message, ToOrchestrator::Snapshot { .. })
}
