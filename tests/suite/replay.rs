//! Recordings replay to the bit, those that are recorded now and the stored ones.

use std::path::Path;

use protocol::message::Role;
use recording::{Ending, Reader, Report, compare, diff, replay};
use tests::engine;
use tests::recorded::{Case, cases, text_of};

/// Largest difference allowed. A processor with other vector instructions sums in another order, and
/// another C library has other last bits: there the recordings are renewed before anything is changed
/// (`tests/recordings/README.md`).
const NONE: f64 = 0.0;
/// All stored recordings together \[bytes\].
const SIZE_MAX: u64 = 2_000_000;

fn replayed(path: &Path, role: Role) -> Report {
    let folder = tempfile::tempdir().expect("a folder");
    let mut reader = Reader::open(path).unwrap_or_else(|error| panic!("{error}"));
    let mut partner = engine(role, None);
    let report = replay(&mut reader, &mut partner, folder.path(), |_, _| ());
    let report = report.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(reader.ending(), Ending::Complete { exit: Some(0) });
    report
}

fn print(case: &Case, role: Role, report: &Report, tolerance: f64) {
    let table = compare::text(&report.fields, tolerance);
    println!("{} as {}\n{table}", case.name, role.seat());
}

#[test]
fn what_is_recorded_now_replays_without_any_difference() {
    let folder = tempfile::tempdir().expect("a folder");
    for case in cases() {
        let path = folder.path().join(case.name);
        let outcome = case.record(&path).unwrap_or_else(|error| panic!("{error}"));
        assert!(outcome.complete, "{}: {outcome:?}", case.name);
        for role in case.seats() {
            let report = replayed(&path, role);
            print(&case, role, &report, 0.0);
            assert_eq!(report.stopped, None);
            assert_eq!(report.steps, case.steps as u64);
            assert!(report.fields.len() >= 6);
            for (name, row) in &report.fields {
                let found = (row.unequal, row.max);
                assert_eq!(found, (0, 0.0), "{} {name}", case.name);
            }
        }
    }
}

#[test]
fn stored_recordings_replay_without_any_difference() {
    for case in cases() {
        for role in case.seats() {
            let report = replayed(&case.stored(), role);
            print(&case, role, &report, NONE);
            assert_eq!(report.stopped, None, "{}", case.name);
            let unequal: u64 = report.fields.values().map(|row| row.unequal).sum();
            assert_eq!(unequal, 0, "{}: see tests/recordings/README.md", case.name);
        }
    }
}

#[test]
fn the_runs_of_today_are_those_that_are_stored() {
    let folder = tempfile::tempdir().expect("a folder");
    for case in cases() {
        let path = folder.path().join(case.name);
        case.record(&path).unwrap_or_else(|error| panic!("{error}"));
        let open = |path: &Path| Reader::open(path).unwrap_or_else(|error| panic!("{error}"));
        let differences = diff::diff(&mut open(&case.stored()), &mut open(&path));
        let differences = differences.unwrap_or_else(|error| panic!("{error}"));
        println!("{}\n{}", case.name, diff::text(&differences, NONE));
        assert!(!differences.scenes_differ, "{}: renew it", case.name);
        assert!(
            differences.within(NONE),
            "{}: see tests/recordings/README.md",
            case.name
        );
    }
}

#[test]
fn stored_recordings_are_small_and_their_texts_tell_what_is_in_them() {
    let mut size = 0;
    for case in cases() {
        size += case.stored().metadata().expect("a recording").len();
        let text = std::fs::read_to_string(case.text()).expect("a text");
        let found = text_of(&case.stored()).unwrap_or_else(|error| panic!("{error}"));
        println!("{}\n{found}", case.name);
        assert_eq!(text, found, "{}: renew it", case.name);
    }
    println!("{size} bytes together");
    assert!(size < SIZE_MAX);
}
