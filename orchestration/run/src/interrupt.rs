//! Ctrl-C and SIGTERM, counted: the first asks to stop, the second insists.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use scene::error::Error;

/// One key press, or one `timeout`, may arrive as several signals; a person needs longer than this.
const ONE_WISH: Duration = Duration::from_millis(250);

/// How often an interruption was asked for.
#[derive(Clone)]
pub struct Interrupts(Arc<AtomicUsize>);

impl Interrupts {
    /// Start counting; without this the signals would end the process at once.
    pub fn count() -> Result<Interrupts, Error> {
        let counter = Arc::new(AtomicUsize::new(0));
        let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP])
            .map_err(Error::file("cannot handle signals of", "this process"))?;
        let shared = Arc::clone(&counter);
        std::thread::spawn(move || {
            let mut last: Option<Instant> = None;
            for _ in signals.forever() {
                if last.is_none_or(|last| last.elapsed() > ONE_WISH) {
                    shared.fetch_add(1, Ordering::SeqCst);
                }
                last = Some(Instant::now());
            }
        });
        Ok(Interrupts(counter))
    }

    /// Interruptions so far.
    pub fn so_far(&self) -> usize {
        self.0.load(Ordering::SeqCst)
    }
}
