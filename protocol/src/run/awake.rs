//! A clock of the time in which a thread could look: what limits on waiting are counted in.
//!
//! A process that was stopped (SIGSTOP, a frozen container, a paused machine) finds all its deadlines
//! passed when it goes on, and its partners, stopped like it, had no time to answer. Who waits looks at
//! least every second; between two looks at most [`SLICE`] counts, however long it was.

use std::cell::Cell;
use std::time::{Duration, Instant};

/// The most that counts between two looks of a thread.
pub const SLICE: Duration = Duration::from_secs(1);

thread_local! {
    static CLOCK: Cell<(Option<Instant>, Duration)> = const { Cell::new((None, Duration::ZERO)) };
}

/// The time of this thread's clock; only differences mean something, and only within a thread.
pub fn now() -> Duration {
    look(Instant::now())
}

fn look(this: Instant) -> Duration {
    let (last, counted) = CLOCK.get();
    let passed = last.map_or(Duration::ZERO, |last| this.saturating_duration_since(last));
    let counted = counted + passed.min(SLICE);
    CLOCK.set((Some(this), counted));
    counted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_hour_in_which_nobody_looked_counts_as_one_slice() {
        let (hour, tick) = (Duration::from_secs(3600), Duration::from_millis(700));
        let begun = Instant::now();
        let since = look(begun);
        assert_eq!(look(begun + tick) - since, tick);
        assert_eq!(look(begun + tick + hour) - since, tick + SLICE);
        assert_eq!(look(begun + 2 * tick + hour) - since, 2 * tick + SLICE);
        // a clock that steps back counts nothing
        assert_eq!(look(begun) - since, 2 * tick + SLICE);
    }
}
