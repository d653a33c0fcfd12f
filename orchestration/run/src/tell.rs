//! Words on stderr. Its reader may have left, or pause for as long as it likes (a pager, Ctrl-S on a
//! terminal), or be a device that is full. Nobody who says something waits for it: a thread of its own
//! writes, and what it does not get rid of is lost, the oldest first.

use std::collections::VecDeque;
use std::fmt::Arguments;
use std::io::{Result, Stderr, Write, stderr};
use std::os::fd::{AsRawFd, RawFd};
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

/// Words kept for a reader that pauses \[bytes\].
const KEPT: usize = 64 << 10;
/// For what is still to be said at the end.
const LAST_WORDS: Duration = Duration::from_secs(10);

/// What is to be written.
struct Waiting {
    words: VecDeque<Vec<u8>>,
    bytes: usize,
    left_out: usize,
    writer: Writer,
    given_up: bool,
}

/// The thread that writes.
#[derive(PartialEq)]
enum Writer {
    NotThere,
    Waits,
    Writes,
}

static WAITING: Mutex<Waiting> = Mutex::new(Waiting {
    words: VecDeque::new(),
    bytes: 0,
    left_out: 0,
    writer: Writer::NotThere,
    given_up: false,
});
static CHANGED: Condvar = Condvar::new();

impl Waiting {
    /// Keep `words`, and of those before them what there is room for.
    fn add(&mut self, words: Vec<u8>) {
        self.bytes += words.len();
        self.words.push_back(words);
        while self.bytes > KEPT && self.words.len() > 1 {
            self.next();
            self.left_out += 1;
        }
    }

    fn next(&mut self) -> Option<Vec<u8>> {
        let words = self.words.pop_front()?;
        self.bytes -= words.len();
        Some(words)
    }
}

/// Write what waits, for as long as this process lives.
fn write_for_ever() {
    let mut waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        waiting.writer = Writer::Waits;
        CHANGED.notify_all();
        let wakened = CHANGED.wait_while(waiting, |waiting| waiting.words.is_empty());
        waiting = wakened.unwrap_or_else(PoisonError::into_inner);
        while let Some(words) = waiting.next() {
            waiting.writer = Writer::Writes;
            let left_out = std::mem::take(&mut waiting.left_out);
            drop(waiting);
            let mut out = stderr();
            if left_out > 0 {
                let said = format!("({left_out} messages were left out: nobody read them)\n");
                let _ = out.write_all(said.as_bytes());
            }
            let _ = out.write_all(&words);
            waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
            waiting.given_up = false;
        }
    }
}

/// stderr, for whom it must not stop.
#[derive(Debug)]
pub struct Told(Stderr);

/// stderr, for whom it must not stop.
pub fn told() -> Told {
    Told(stderr())
}

impl Write for Told {
    fn write(&mut self, words: &[u8]) -> Result<usize> {
        let mut waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
        if waiting.writer == Writer::NotThere {
            let named = Builder::new().name("stderr".to_owned());
            if named.spawn(write_for_ever).is_err() {
                return self.0.write(words);
            }
            waiting.writer = Writer::Waits;
        }
        waiting.add(words.to_vec());
        CHANGED.notify_all();
        Ok(words.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

impl AsRawFd for Told {
    fn as_raw_fd(&self) -> RawFd {
        self.0.as_raw_fd()
    }
}

/// A line on stderr.
pub fn line(text: Arguments<'_>) {
    let _ = told().write_all(format!("{text}\n").as_bytes());
}

/// Wait until all that was said is written, before anything is said elsewhere and at the end: for a while, and
/// not again for a reader that has not moved since.
pub fn finish() {
    let waiting = WAITING.lock().unwrap_or_else(PoisonError::into_inner);
    let unsaid = |waiting: &mut Waiting| {
        let writes = !waiting.words.is_empty() || waiting.writer == Writer::Writes;
        writes && !waiting.given_up
    };
    let waited = CHANGED.wait_timeout_while(waiting, LAST_WORDS, unsaid);
    let (mut waiting, waited) = waited.unwrap_or_else(PoisonError::into_inner);
    waiting.given_up |= waited.timed_out();
}

/// [`line()`], written as `eprintln!` is.
#[macro_export]
macro_rules! tell {
    ($($text:tt)*) => { $crate::tell::line(format_args!($($text)*)) };
}
