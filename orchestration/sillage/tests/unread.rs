//! stderr that nobody reads for a while: a pager that waits, a terminal that is paused.

use std::io::{PipeReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::background::{beside_programs, need_programs, report, root};

/// For what is still to be said when a run is over: see `tell`.
const LAST_WORDS: Duration = Duration::from_secs(10);

/// A program whose stderr is a pipe that is full.
fn unread(program: &mut Command) -> (Child, PipeReader) {
    let (reader, mut writer) = std::io::pipe().expect("a pipe");
    let stderr = writer.try_clone().expect("a pipe");
    // Writes until the pipe is full, and waits there for as long as nobody reads it.
    std::thread::spawn(move || while writer.write_all(b"-------\n").is_ok() {});
    std::thread::sleep(Duration::from_millis(200));
    let child = program.stdout(Stdio::null()).stderr(stderr).spawn();
    (child.expect("started"), reader)
}

#[test]
fn a_stderr_that_nobody_reads_stops_no_run() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let mut run = Command::new(env!("CARGO_BIN_EXE_sillage"));
    run.arg("run").arg(root().join("scenes/one-grain.toml"));
    run.args(["--set", "run.end_time=0.02", "--set", "output.every=0.02"]);
    run.arg("--out")
        .arg(folder.path())
        .env("SILLAGE_LOG", "debug");
    let begun = Instant::now();
    let (mut run, _reader) = unread(&mut run);
    let code = run.wait().expect("waited").code();
    let elapsed = begun.elapsed();
    let report = report(folder.path());
    let wall = report["cost"]["wall_total"].as_f64().expect("a time");
    println!("{code:?} after {elapsed:?}, of which the run took {wall} s");
    assert_eq!(code, Some(0));
    assert_eq!(report["exit"]["code"], 0, "{report:#}");
    assert!(folder.path().join("overview.png").exists());
    // What it still had to say was offered.
    assert!(elapsed >= LAST_WORDS, "{elapsed:?}");
}

/// Says more than is kept for a reader that pauses.
#[test]
#[ignore = "a program for the test beside it"]
fn a_program_that_says_much() {
    for line in 0..4000 {
        run::tell!("line {line:4} of many, as long as a line of progress is");
    }
    run::tell::finish();
}

#[test]
fn what_is_kept_for_a_reader_that_pauses_is_bounded_and_what_was_lost_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut program = Command::new(beside_programs(folder.path()));
    program.args(["--ignored", "--exact", "--nocapture"]);
    program.arg("unread::a_program_that_says_much");
    let (mut program, mut reader) = unread(&mut program);
    std::thread::sleep(Duration::from_secs(2));
    let mut words = vec![];
    let mut some = [0; 4096];
    // The writer that filled the pipe never leaves: until the last line.
    while !String::from_utf8_lossy(&words).contains("line 3999") {
        let read = reader.read(&mut some).expect("read");
        words.extend(&some[..read]);
    }
    assert_eq!(program.wait().expect("waited").code(), Some(0));
    let words = String::from_utf8_lossy(&words);
    let lines: Vec<&str> = words
        .lines()
        .filter(|line| line.starts_with("line "))
        .collect();
    let told = words.lines().filter(|line| line.contains("left out"));
    let told: Vec<&str> = told.collect();
    println!("{} lines of 4000; {told:?}", lines.len());
    let number = |told: &&str| told[1..].split(' ').next()?.parse::<usize>().ok();
    let lost: usize = told.iter().filter_map(number).sum();
    assert_eq!(lines.len() + lost, 4000);
    let kept: usize = lines.iter().map(|line| line.len() + 1).sum();
    assert!((60 << 10..=66 << 10).contains(&kept), "{kept} bytes");
}
