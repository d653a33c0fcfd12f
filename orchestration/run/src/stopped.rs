//! Processes that were stopped (SIGSTOP): nobody else notices, and they would be waited for as long as
//! a step may take, the coupler without end.

use std::collections::BTreeMap;
use std::time::Duration;

use protocol::awake;
use protocol::limits;

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(500);

/// Since when which seat's process is stopped, in time in which this process could look.
#[derive(Debug, Default)]
pub struct Stopped {
    looked: Option<Duration>,
    since: BTreeMap<String, Duration>,
}

impl Stopped {
    /// A seat whose process has been stopped for longer than [`limits::STOPPED`]; `stopped` tells
    /// which are, and is asked twice a second at most.
    pub fn look(
        &mut self,
        stopped: impl FnOnce() -> BTreeMap<String, u32>,
    ) -> Option<(String, u32)> {
        let now = awake::now();
        if self.looked.is_some_and(|then| now - then < PAUSE) {
            return None;
        }
        self.looked = Some(now);
        let stopped = stopped();
        self.since.retain(|seat, _| stopped.contains_key(seat));
        let limit = limits::STOPPED.duration();
        stopped.into_iter().find(|(seat, _)| {
            let since = self.since.entry(seat.clone()).or_insert(now);
            now - *since >= limit
        })
    }
}
