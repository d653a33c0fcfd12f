//! Nobody waits by the time of the day, which jumps when it is set: it only stamps what is written.

use std::path::Path;

use crate::sources::{crates, sources};

/// Where the time of the day is asked for, and what for.
const STAMPS: [(&str, &str); 3] = [
    (
        "orchestration/run/src/file.rs",
        "when a run began, was resumed, ended",
    ),
    (
        "orchestration/run/src/folder/fresh.rs",
        "the name of a folder",
    ),
    (
        "protocol/recording/src/write/feed.rs",
        "when a message passed",
    ),
];

#[test]
fn the_time_of_the_day_is_a_stamp_and_no_clock() {
    let mut asking = Vec::new();
    for source in crates().iter().flat_map(|folder| sources(folder)) {
        if source.text.contains("SystemTime") || source.text.contains("CLOCK_REALTIME") {
            asking.push(source.path);
        }
    }
    asking.sort();
    println!("{asking:?}");
    assert!(
        asking
            .iter()
            .eq(STAMPS.iter().map(|(path, _)| Path::new(path)))
    );
}
