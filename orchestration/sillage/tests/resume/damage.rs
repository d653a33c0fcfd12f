//! Checkpoints that are damaged are told of, and those before them are taken.

use std::path::Path;

use protocol::checkpoints::{FOLDER, complete};

use crate::background::{Run, report, root, small_cloud};
use crate::resume::same::{assert_same, copy, kept, resume, run};

/// A run with checkpoints after the steps 2, 4, …, 10.
fn done(place: &Path) -> std::path::PathBuf {
    let folder = place.join("run");
    let scene = root().join("scenes/one-grain.toml");
    let settings = ["run.end_time=0.01", "output.every=0.003"].map(str::to_owned);
    run(&scene.to_string_lossy(), &settings, 2, &folder);
    folder
}

#[test]
fn a_damaged_checkpoint_is_told_of_and_the_one_before_is_taken() {
    let place = tempfile::tempdir().expect("a folder");
    let whole = done(place.path());
    let newest = whole.join(FOLDER).join(complete(10));
    let files = std::fs::read_dir(newest).expect("listed").flatten();
    let mut names: Vec<String> = files
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(
        names,
        ["coupler", "fluid", "manifest.json", "outputs", "particles"]
    );
    for name in &names {
        for damage in ["flip", "cut", "remove"] {
            let copied = place.path().join(format!("{name}-{damage}"));
            copy(&whole, &copied);
            let file = copied.join(FOLDER).join(complete(10)).join(name);
            let mut bytes = std::fs::read(&file).expect("read");
            let middle = bytes.len() / 2;
            match damage {
                "flip" => bytes[middle] ^= 0x08,
                _ => bytes.truncate(middle),
            }
            match damage {
                "remove" => std::fs::remove_file(&file).expect("removed"),
                _ => std::fs::write(&file, bytes).expect("written"),
            }
            let (code, said, words) = resume(&copied, &[]);
            println!(
                "{name} {damage}: {}",
                words.lines().next().unwrap_or_default()
            );
            assert_eq!(code, Some(0), "{said} {words}");
            assert!(
                words.contains("the checkpoint of step 10 cannot be used"),
                "{words}"
            );
            assert!(words.contains("from step 8"), "{words}");
            assert_same(&whole, &copied);
        }
    }
}

#[test]
fn where_none_is_whole_the_run_is_refused_and_nothing_is_lost() {
    let place = tempfile::tempdir().expect("a folder");
    let whole = done(place.path());
    let before = std::fs::read(whole.join("steps.csv")).expect("read");
    for step in kept(&whole) {
        std::fs::remove_file(whole.join(FOLDER).join(complete(step)).join("fluid"))
            .expect("removed");
    }
    let (code, _, words) = resume(&whole, &["--set", "run.end_time=0.02"]);
    println!("{words}");
    assert_eq!(code, Some(2));
    assert_eq!(
        std::fs::read(whole.join("steps.csv")).expect("read"),
        before
    );
}

#[test]
fn another_format_is_refused_with_the_remedy() {
    let place = tempfile::tempdir().expect("a folder");
    let whole = done(place.path());
    for step in kept(&whole) {
        let file = whole
            .join(FOLDER)
            .join(complete(step))
            .join("manifest.json");
        let text = std::fs::read_to_string(&file).expect("read");
        let text = text.replace("\"format\": 1", "\"format\": 7");
        std::fs::write(&file, text).expect("written");
    }
    let (code, _, words) = resume(&whole, &["--from", "8"]);
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(words.contains("its format is 7") && words.contains("take the one that wrote it"));
}

#[test]
fn a_checkpoint_that_cannot_be_written_is_told_of_and_the_run_goes_on() {
    let mut arguments = small_cloud(0.3);
    arguments.extend(["--set".to_owned(), "checkpoint.every_steps=3".to_owned()]);
    let mut run = Run::start(&arguments);
    run.wait_for_steps(5);
    // A file where their folder was.
    let place = run.folder.path().join(FOLDER);
    while std::fs::write(&place, "in the way").is_err() {
        let _ = std::fs::remove_dir_all(&place);
    }
    let (code, words, _, folder) = run.finish();
    println!("{words}");
    assert_eq!(code, Some(0));
    assert!(words.contains("no checkpoint: step"), "{words}");
    let told = &report(folder.path())["checkpoint"]["none_later"];
    assert!(
        told.as_str()
            .is_some_and(|why| why.contains("could not be kept")),
        "{told}"
    );
}
