//! What is wrong with the surroundings of a run is said in words that help.

use std::os::unix::process::CommandExt;
use std::process::{Command, Output};
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::background::{Run, need_programs, report, root, small_cloud};
use crate::schema;

fn shell(command: &str) -> Output {
    need_programs();
    if let Some(arguments) = command.strip_prefix("sillage ") {
        let words = arguments.split(' ').map(|word| word.trim_matches('\''));
        schema::of_command(&root(), &words.collect::<Vec<_>>());
    }
    let command = command.replace("sillage ", &format!("{} ", env!("CARGO_BIN_EXE_sillage")));
    Command::new("bash")
        .args(["-c", &command])
        .current_dir(root())
        .output()
        .expect("started")
}

fn told(output: &Output) -> (Option<i32>, String) {
    let words = String::from_utf8_lossy(&output.stderr).into_owned()
        + &String::from_utf8_lossy(&output.stdout);
    println!("{:?}: {words}", output.status);
    (output.status.code(), words)
}

#[test]
fn too_few_open_files_are_named_by_the_run_and_by_the_doctor() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = format!(
        "sillage run scenes/one-grain.toml --set run.end_time=0.002 --set output.every=0.002 --out {}",
        folder.path().display()
    );
    // What is only a default is raised.
    let (code, words) = told(&shell(&format!("ulimit -S -n 100; {run}")));
    assert_eq!(code, Some(0), "{words}");
    let (code, words) = told(&shell(&format!("ulimit -n 300; {run}")));
    assert_eq!(code, Some(2));
    assert!(
        words.contains("may open 300 files, and a run needs 512"),
        "{words}"
    );
    let (_, words) = told(&shell("ulimit -n 300; sillage doctor"));
    assert!(
        words.contains("problem        a process may open 300 files"),
        "{words}"
    );
}

#[test]
fn an_engine_that_is_told_to_end_is_said_to_be_so_and_quoted_with_nothing() {
    for (seat, name) in [("fluid", "sillage-fluid"), ("particles", "sillage-particl")] {
        let mut run = Run::start(&small_cloud(100.0));
        run.wait_for_steps(3);
        let (children, _) = run.children();
        kill(Pid::from_raw(children[name]), Signal::SIGTERM).expect("signalled");
        let (code, words, _, folder) = run.finish();
        println!("{code:?}: {words}");
        assert_eq!(code, Some(5));
        let report = report(folder.path());
        let why = report["exit"]["why"].as_str().expect("why");
        assert!(why.starts_with(&format!("the {seat} (process ")), "{why}");
        assert!(
            why.contains("ended on SIGTERM, as it was told at step"),
            "{why}"
        );
        assert!(!why.contains("INFO"), "{why}");
    }
}

#[test]
fn a_signal_that_was_ignored_from_the_start_stays_ignored() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = small_cloud(0.11);
    let mut child = Command::new("bash")
        .args([
            "-c",
            "trap '' HUP; exec \"$@\"",
            "bash",
            env!("CARGO_BIN_EXE_sillage"),
            "run",
        ])
        .args(&arguments)
        .args(["--threads", "1", "--out"])
        .arg(folder.path())
        .process_group(0)
        .spawn()
        .expect("started");
    let pid = Pid::from_raw(child.id() as i32);
    while !folder.path().join("steps.csv").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    kill(pid, Signal::SIGHUP).expect("signalled");
    assert_eq!(child.wait().expect("reaped").code(), Some(0));
    assert_eq!(report(folder.path())["steps"], 20);
}

#[test]
fn an_interruption_is_no_error_of_the_coupler() {
    let mut run = Run::start(&small_cloud(100.0));
    run.wait_for_steps(3);
    kill(Pid::from_raw(run.child.id() as i32), Signal::SIGINT).expect("signalled");
    let (code, _, _, folder) = run.finish();
    assert_eq!(code, Some(130));
    let log = std::fs::read_to_string(folder.path().join("logs/coupler.log")).expect("a log");
    println!("{log}");
    assert!(log.contains("stopped on request after step") && !log.contains("ERROR"));
}

#[test]
fn what_cannot_be_had_here_is_refused_before_anything_starts() {
    for (command, named) in [
        (
            "sillage run scenes/cloud.toml --threads 100000",
            "a whole number from 1 to",
        ),
        (
            "sillage study one-grain --threads 0",
            "a whole number from 1 to",
        ),
        (
            "sillage check scenes/cloud.toml --set 'engines.particles.command=[\"no-such-engine\"]'",
            "engines.particles.command",
        ),
        (
            "sillage check scenes/cloud.toml --set 'engines.fluid.command=[\"./cloud.toml\"]'",
            "./cloud.toml is no program in the folder of the scene",
        ),
        (
            "sillage check scenes/cloud.toml --set grains.density=1",
            "as in grains[0].density",
        ),
        (
            "sillage check scenes/cloud.toml --set grains[3].density=1",
            "the list grains, which has 1",
        ),
    ] {
        let (code, words) = told(&shell(command));
        assert_eq!(code, Some(2), "{command}");
        assert!(words.contains(named), "{words}");
    }
    let command = "sillage check scenes/cloud.toml --set 'engines.particles.command=[\"true\"]'";
    assert_eq!(told(&shell(command)).0, Some(0));
}
