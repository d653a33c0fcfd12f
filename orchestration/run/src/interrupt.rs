//! Ctrl-C and SIGTERM, counted: the first asks to stop, the second insists.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;
use signal_hook::iterator::Signals;

use scene::error::Error;

/// One key press, or one `timeout`, may arrive as several signals; a person needs longer than this.
const ONE_WISH: Duration = Duration::from_millis(250);

/// Signals that this process ignores, a bit each, from the lowest on.
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

/// How often an interruption was asked for.
#[derive(Clone)]
pub struct Interrupts(Arc<AtomicUsize>);

impl Interrupts {
    /// Start counting; without this the signals would end the process at once.
    pub fn count() -> Result<Interrupts, Error> {
        let counter = Arc::new(AtomicUsize::new(0));
        // What was ignored from the start stays so: `nohup` and shells ask for it.
        let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter();
        let ignored = ignored();
        let mut signals = Signals::new(wanted.filter(|signal| ignored & (1 << (signal - 1)) == 0))
            .map_err(Error::file("cannot handle signals of", "this process"))?;
        // A file that grows beyond what is allowed is an error of its write, not the end of the process.
        let noted = Arc::new(AtomicBool::new(false));
        flag::register(SIGXFSZ, noted)
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
