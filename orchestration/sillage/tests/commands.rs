//! Commands: where the program of an engine is found, what its last words are worth, and who reads.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use crate::background::{need_programs, programs, root};
use crate::schema;

/// Run the dry collapse for a step from a folder of its own; exit code and words.
fn run(folder: &Path, program: &str) -> (Option<i32>, String) {
    need_programs();
    let scene = folder.join("scenes/own/scene.toml");
    std::fs::create_dir_all(scene.parent().expect("a folder")).expect("made");
    std::fs::copy(root().join("scenes/dry-collapse.toml"), &scene).expect("copied");
    let mut arguments = vec!["run", "scenes/own/scene.toml", "--out", "out"];
    let program = format!("engines.particles.command=[\"{program}\"]");
    for setting in ["run.end_time=2e-3", "output.frames=false", &program] {
        arguments.extend(["--set", setting]);
    }
    schema::of_command(folder, &arguments);
    // the scene's path is relative, and from elsewhere than its folder
    let output = Command::new(env!("CARGO_BIN_EXE_sillage"))
        .args(&arguments)
        .current_dir(folder)
        .output()
        .expect("started");
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), words)
}

fn script(path: &Path, text: &str) {
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    std::fs::write(path, text).expect("written");
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).expect("allowed");
}

#[test]
fn a_program_with_a_folder_is_found_from_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let built_in = programs().join("sillage-particles");
    script(
        &folder.path().join("scenes/engine"),
        &format!("#!/bin/sh\nexec {} \"$@\"\n", built_in.display()),
    );
    let (code, words) = run(folder.path(), "../engine");
    println!("{words}");
    assert_eq!(code, Some(0));
    let (code, words) = run(folder.path(), "./engine");
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(words.contains("./engine is no program"), "{words}");
}

#[test]
fn what_an_engine_says_last_is_in_the_error_of_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let remedy = "error: no environment: run engines/set-up NAME";
    let hint = "For more information, try --help.";
    for more in ["", hint] {
        script(
            &folder.path().join("scenes/engine"),
            &format!("#!/bin/sh\necho '{remedy}' >&2\necho '{more}' >&2\nexit 4\n"),
        );
        let (code, words) = run(folder.path(), "../engine");
        println!("{words}");
        assert_eq!(code, Some(4));
        let last = words.lines().last().unwrap_or_default();
        assert!(last.contains(&format!("exit code 4 ({remedy})")), "{last}");
    }
}

#[test]
fn a_reader_of_stdout_that_has_seen_enough_is_no_error() {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let output = Command::new(env!("CARGO_BIN_EXE_sillage"))
        .arg("plan")
        .arg(root().join("scenes/cloud.toml"))
        .stdout(writer)
        .stderr(std::process::Stdio::piped())
        .output()
        .expect("started");
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{words}");
    assert!(!words.contains("panicked"), "{words}");
}

#[test]
fn the_program_exits_with_2_for_a_bad_scene_and_a_bad_command_line() {
    let sillage = env!("CARGO_BIN_EXE_sillage");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/one-grain.toml");
    for arguments in [
        &["check", "/no/such/scene.toml"][..],
        &["chekc"],
        &["run"],
        &["run", scene, "--out", "/proc/no/folder"],
        &[],
    ] {
        let output = Command::new(sillage)
            .args(arguments)
            .output()
            .expect("started");
        println!("{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
}
