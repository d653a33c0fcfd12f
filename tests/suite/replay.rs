//! Recordings replay: what is recorded now to the bit, the stored ones within what another processor
//! may differ by.

use std::path::Path;

use protocol::message::Role;
use recording::{Ending, Reader, Report, compare, diff, replay};
use tests::engine;
use tests::recorded::{Case, cases, text_of};

/// Another processor has other vector instructions, which sum in another order; another C library
/// other last bits of its functions. Relative to the largest magnitude of each field; measured without
/// AVX: 9e-14.
const OTHER_PROCESSOR: f64 = 1e-11;
/// The same through the passes and contacts of a whole run; measured without AVX: 1.1e-10.
const OTHER_RUN: f64 = 1e-8;
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
fn stored_recordings_replay_within_what_a_processor_may_differ_by() {
    for case in cases() {
        for role in case.seats() {
            let report = replayed(&case.stored(), role);
            print(&case, role, &report, OTHER_PROCESSOR);
            assert_eq!(report.stopped, None, "{}", case.name);
            assert!(
                report.within(OTHER_PROCESSOR),
                "{}: see tests/recordings/README.md",
                case.name
            );
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
        println!("{}\n{}", case.name, diff::text(&differences, OTHER_RUN));
        assert!(!differences.scenes_differ, "{}: renew it", case.name);
        assert!(
            differences.within(OTHER_RUN),
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
