//! Writing beside the run: messages queue up, and a thread writes them, so that a slow disk or a
//! large picture does not hold the coupler up.

use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;

use protocol::monitor::Event;

use super::RunFolder;
use crate::error::{Error, exit_code};

/// Messages that may wait; a coupler that is far ahead of the disk waits as well, so that memory
/// stays bounded.
const QUEUE: usize = 64;

/// The thread that writes.
pub struct Writer {
    queue: SyncSender<Event>,
    thread: JoinHandle<Outcome>,
}

/// The folder, and the first error; after an error the rest is dropped.
type Outcome = (RunFolder, Result<(), Error>);

impl Writer {
    /// Start writing to a folder.
    pub fn start(mut folder: RunFolder) -> Writer {
        let (queue, events) = sync_channel::<Event>(QUEUE);
        let thread = std::thread::spawn(move || {
            let mut outcome = Ok(());
            for event in events {
                if outcome.is_ok() {
                    outcome = folder.take(event);
                }
            }
            let outcome = outcome.and_then(|()| folder.finish());
            (folder, outcome)
        });
        Writer { queue, thread }
    }

    /// Hand a message over.
    pub fn take(&self, event: Event) {
        // The thread ends only after the queue: this cannot fail while it is alive.
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
