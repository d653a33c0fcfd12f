//! What two run folders must have in common, when one of them was resumed.

use std::collections::BTreeMap;
use std::path::Path;

use protocol::monitor::columns;
use run::folder::checkpoint;

use crate::background::{need_programs, sillage};

/// Copy a folder with all that is in it.
pub fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("made");
    for entry in std::fs::read_dir(from).expect("listed").flatten() {
        let target = to.join(entry.file_name());
        match entry.file_type().expect("known").is_dir() {
            true => copy(&entry.path(), &target),
            false => _ = std::fs::copy(entry.path(), target).expect("copied"),
        }
    }
}

/// Rows of `steps.csv` without what differs from run to run.
fn rows(folder: &Path) -> Vec<Vec<(String, String)>> {
    let text = std::fs::read_to_string(folder.join("steps.csv")).expect("steps");
    let mut lines = text.lines().map(|line| line.split(','));
    let heads: Vec<&str> = lines.next().expect("heads").collect();
    let lasting = |head: &str| !columns::is_cost(head);
    let row = |line: std::str::Split<'_, char>| {
        let named = heads.iter().zip(line);
        let lasting = named.filter(|(head, _)| lasting(head));
        lasting
            .map(|(head, value)| (head.to_string(), value.to_owned()))
            .collect()
    };
    lines.map(row).collect()
}

/// Files of a folder by name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let file = |entry: std::fs::DirEntry| {
        let bytes = std::fs::read(entry.path()).expect("read");
        (entry.file_name().to_string_lossy().into_owned(), bytes)
    };
    entries.map(file).collect()
}

/// Assert that two runs put out the same: steps, states, pictures, recording. How many steps there are.
pub fn assert_same(one: &Path, other: &Path) -> usize {
    let (mine, theirs) = (rows(one), rows(other));
    assert_eq!(mine.len(), theirs.len(), "steps of {}", other.display());
    for (number, (mine, theirs)) in mine.iter().zip(&theirs).enumerate() {
        let differ: Vec<_> = mine.iter().zip(theirs).filter(|(a, b)| a != b).collect();
        assert!(differ.is_empty(), "row {number}: {differ:?}");
    }
    for part in ["vtu", "frames"] {
        let (mine, theirs) = (files(&one.join(part)), files(&other.join(part)));
        let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&mine), names(&theirs), "{part}");
        for (name, bytes) in &mine {
            assert!(theirs[name] == *bytes, "{part}/{name} differs");
        }
    }
    for name in ["fluid.pvd", "grains.pvd", "overview.png", "steps.units.csv"] {
        let read = |folder: &Path| std::fs::read(folder.join(name)).ok();
        assert!(read(one) == read(other), "{name} differs");
    }
    let recording = |folder: &Path| folder.join("exchange.mcap");
    if recording(one).exists() {
        let paths = [one, other].map(|folder| recording(folder).display().to_string());
        let (code, said, words) = sillage(&["diff", &paths[0], &paths[1]]);
        assert_eq!(code, Some(0), "{said} {words}");
    }
    mine.len()
}

/// A scene with settings, run to its end with a checkpoint every `every` steps.
pub fn run(scene: &str, settings: &[String], every: u64, folder: &Path) -> String {
    need_programs();
    let every = format!("checkpoint.every_steps={every}");
    let out = folder.to_str().expect("UTF-8");
    let mut arguments = vec!["run", scene, "--out", out, "--record", "--set", &every];
    arguments.extend(["--set", "checkpoint.keep=1000", "--threads", "1"]);
    arguments.extend(settings.iter().flat_map(|setting| ["--set", setting]));
    let (code, _, words) = sillage(&arguments);
    assert_eq!(code, Some(0), "{scene}: {words}");
    words
}

/// Resume a copy of the run in `done` from its checkpoint of this step, and compare: steps in all.
pub fn resumed_from(done: &Path, step: u64, threads: u32) -> usize {
    let place = tempfile::tempdir().expect("a folder");
    let copied = place.path().join("run");
    copy(done, &copied);
    let (step, threads) = (step.to_string(), threads.to_string());
    let (code, said, words) = resume(&copied, &["--from", &step, "--threads", &threads]);
    assert_eq!(code, Some(0), "{said} {words}");
    assert_same(done, &copied)
}

/// `sillage resume` of a run folder: exit code, stdout, stderr.
pub fn resume(folder: &Path, more: &[&str]) -> (Option<i32>, String, String) {
    let out = folder.to_str().expect("UTF-8");
    sillage(&[&["resume", out][..], more].concat())
}

/// Steps that have a checkpoint.
pub fn kept(folder: &Path) -> Vec<u64> {
    checkpoint::steps(folder)
}
