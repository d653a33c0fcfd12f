//! What a run writes: on a disk that is full for a while, beside what others wrote, over an earlier run.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Resource, Rlimit, Signal, geteuid, kill_process, prlimit};

use crate::background::{LEAVING_MAX, Run, need_programs, report, root, small_cloud};
use crate::schema;

/// Let a process write no file beyond so many bytes; none: as many as it likes.
fn limit_files(pid: u32, bytes: Option<u64>) {
    let limit = Rlimit {
        current: bytes,
        maximum: None,
    };
    prlimit(Pid::from_raw(pid as i32), Resource::Fsize, limit).expect("limited");
}

fn sillage(folder: &Path, arguments: &[&str]) -> Output {
    need_programs();
    schema::of_command(folder, arguments);
    Command::new(env!("CARGO_BIN_EXE_sillage"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("started")
}

/// Exit code and stderr.
fn told(output: &Output) -> (Option<i32>, String) {
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    println!("{:?}: {words}", output.status);
    (output.status.code(), words)
}

#[test]
fn a_disk_that_is_full_for_two_seconds_costs_time_and_no_data() {
    let mut run = Run::start(&small_cloud(0.22));
    run.wait_for_steps(4);
    limit_files(run.child.id(), Some(1));
    std::thread::sleep(Duration::from_secs(2));
    let rows = run.rows();
    assert!(rows < 40, "the run was too fast");
    limit_files(run.child.id(), None);
    let (code, words, _, folder) = run.finish();
    println!("{rows} rows; {words}");
    assert_eq!(code, Some(0));
    assert!(
        words.contains("cannot write") && words.contains("the run waits for it"),
        "{words}"
    );
    assert!(words.contains("nothing is lost"), "{words}");
    let table = std::fs::read_to_string(folder.path().join("steps.csv")).expect("steps.csv");
    let columns: Vec<usize> = table.lines().map(|row| row.split(',').count()).collect();
    assert_eq!(columns.len(), 41);
    assert!(columns.iter().all(|count| *count == columns[0]));
    let report = report(folder.path());
    assert_eq!(report["steps"], 40);
    let phases = &report["cost"]["wall_phases"];
    assert!(
        phases["start"].as_f64() > Some(0.0) && phases["steps"].as_f64() > Some(2.0),
        "{phases}"
    );
    for number in 0..=4 {
        for file in [
            format!("vtu/fluid_{number:04}.vtu"),
            format!("frames/{number:04}.png"),
        ] {
            assert!(folder.path().join(&file).exists(), "{file}");
        }
    }
}

#[test]
fn a_folder_that_is_elsewhere_for_a_while_costs_time_and_no_data() {
    let mut run = Run::start(&small_cloud(0.22));
    run.wait_for_steps(4);
    let (place, away) = (run.folder.path(), run.folder.path().with_extension("away"));
    std::fs::rename(place, &away).expect("moved");
    std::thread::sleep(Duration::from_secs(2));
    assert!(!place.exists(), "made again");
    std::fs::rename(&away, place).expect("moved");
    let (code, words, _, folder) = run.finish();
    println!("{words}");
    assert_eq!(code, Some(0));
    for part in ["cannot write", "No such file", "nothing is lost"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert_eq!(report(folder.path())["steps"], 40);
    let table = std::fs::read_to_string(folder.path().join("steps.csv")).expect("steps.csv");
    assert_eq!(table.lines().count(), 41);
    assert!(folder.path().join("vtu/fluid_0004.vtu").exists());
}

#[test]
fn a_folder_that_is_read_only_for_a_while_costs_time_and_no_data() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let mut arguments = vec!["run".to_owned()];
    arguments.extend(small_cloud(0.22));
    arguments.extend(["--threads", "1", "--out"].map(str::to_owned));
    schema::of_command(Path::new("."), &arguments);
    // Root writes everywhere, unless it gives that up.
    let mut command = Command::new("setpriv");
    command.args(["--bounding-set", "-dac_override,-dac_read_search"]);
    if !geteuid().is_root() {
        command = Command::new("env");
    }
    let child = command
        .arg(env!("CARGO_BIN_EXE_sillage"))
        .args(&arguments)
        .arg(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let Ok(child) = child else {
        return println!("not tried: there is no setpriv");
    };
    let mut run = Run { child, folder };
    run.wait_for_steps(4);
    let places = ["", "vtu", "frames"].map(|name| run.folder.path().join(name));
    let permit = |mode| {
        let mode = std::fs::Permissions::from_mode(mode);
        let changed = places
            .iter()
            .map(|place| std::fs::set_permissions(place, mode.clone()));
        assert!(changed.into_iter().all(|done| done.is_ok()));
    };
    permit(0o500);
    std::thread::sleep(Duration::from_secs(2));
    let rows = run.rows();
    permit(0o700);
    let (code, words, _, folder) = run.finish();
    println!("{rows} rows; {words}");
    assert_eq!(code, Some(0));
    assert!(rows < 40, "nothing was missing");
    for part in ["cannot write", "Permission denied", "nothing is lost"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert_eq!(report(folder.path())["steps"], 40);
    for number in 0..=4 {
        let state = format!("vtu/fluid_{number:04}.vtu");
        assert!(folder.path().join(&state).exists(), "{state}");
    }
}

#[test]
fn a_second_interruption_ends_the_wait_for_a_disk_that_is_full() {
    let mut run = Run::start(&small_cloud(100.0));
    run.wait_for_steps(4);
    limit_files(run.child.id(), Some(1));
    let this = Pid::from_raw(run.child.id() as i32).expect("a process");
    // longer apart than what counts as one wish
    for _ in 0..2 {
        std::thread::sleep(Duration::from_secs(1));
        kill_process(this, Signal::INT).expect("signalled");
    }
    let (code, words, elapsed, _folder) = run.finish();
    println!("{elapsed:?}: {words}");
    assert_eq!(code, Some(130));
    assert!(
        words.contains("interrupted while the folder was written"),
        "{words}"
    );
    assert!(elapsed < LEAVING_MAX, "{elapsed:?}");
}

#[test]
fn a_reader_that_is_gone_or_a_device_that_is_full_ends_no_run_and_panics_nowhere() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let scene = root().join("scenes/one-grain.toml");
    let run = format!(
        "{} run {} --set run.end_time=0.02 --set output.every=0.02 --out {}",
        env!("CARGO_BIN_EXE_sillage"),
        scene.display(),
        folder.path().join("run").display()
    );
    let quiet = "2>/dev/full >/dev/null";
    for (redirected, code) in [
        (format!("{run} {quiet}"), 0),
        (format!("{run} 2>&- >&-"), 0),
        (format!("{run} 2>&1 | :; exit ${{PIPESTATUS[0]}}"), 0),
        (format!("{run} --json >/dev/full 2>/dev/full"), 2),
        (
            format!(
                "{} check /no/such/scene {quiet}",
                env!("CARGO_BIN_EXE_sillage")
            ),
            2,
        ),
        (
            format!(
                "{} study /no/such/study {quiet}",
                env!("CARGO_BIN_EXE_sillage")
            ),
            2,
        ),
    ] {
        let status = Command::new("bash").args(["-c", &redirected]).status();
        let found = status.expect("started").code();
        println!("{found:?}: {redirected}");
        assert_eq!(found, Some(code), "{redirected}");
    }
}

#[test]
fn what_is_no_run_of_ours_is_not_touched() {
    let place = tempfile::tempdir().expect("a folder");
    let scene = std::fs::read_to_string(root().join("scenes/one-grain.toml")).expect("a scene");
    let short = ["--set", "run.end_time=0.002", "--set", "output.every=0.002"];
    for (name, text) in [
        ("scene.toml", scene.as_str()),
        ("grains.csv", "mine"),
        ("other/run.json", "{ \"mine\": true }"),
        ("other/steps.csv", "mine"),
    ] {
        std::fs::create_dir_all(place.path().join("other")).expect("made");
        std::fs::write(place.path().join(name), text).expect("written");
    }
    let files = || {
        let mut files: Vec<String> = std::fs::read_dir(place.path())
            .expect("listed")
            .chain(std::fs::read_dir(place.path().join("other")).expect("listed"))
            .flatten()
            .map(|entry| {
                let text = std::fs::read_to_string(entry.path()).unwrap_or_default();
                format!("{}: {text}", entry.file_name().to_string_lossy())
            })
            .collect();
        files.sort();
        files
    };
    let before = files();
    for (out, named) in [
        (".", "--out .: holds "),
        ("", "--out"),
        ("other", "no run of sillage"),
        ("scene.toml", "is not a folder"),
    ] {
        for command in ["run", "plan"] {
            let mut arguments = vec![command, "scene.toml", "--out", out];
            arguments.extend(short);
            let (code, words) = told(&sillage(place.path(), &arguments));
            assert_eq!(code, Some(2), "{words}");
            assert!(command == "plan" || words.contains(named), "{words}");
        }
        let (code, _) = told(&sillage(
            place.path(),
            &["study", "one-grain", "--out", out],
        ));
        assert_eq!(code, Some(2));
    }
    assert_eq!(files(), before);
}

#[test]
fn an_earlier_run_is_replaced_only_once_the_new_one_has_started() {
    let place = tempfile::tempdir().expect("a folder");
    let scene = root().join("scenes/one-grain.toml");
    let scene = scene.to_string_lossy();
    let run = |settings: &[&str]| {
        let mut arguments = vec!["run", &scene, "--out", "run"];
        for setting in settings {
            arguments.extend(["--set", setting]);
        }
        told(&sillage(place.path(), &arguments))
    };
    let file = |name: &str| std::fs::read_to_string(place.path().join("run").join(name));
    let short = ["run.end_time=0.002", "output.every=0.002"];
    assert_eq!(run(&short).0, Some(0));
    let before = (
        file("run.json").expect("run.json"),
        file("steps.csv").expect("steps.csv"),
    );
    let (code, words) = run(&["engines.particles.command=[\"false\"]"]);
    assert_eq!(code, Some(4), "{words}");
    assert!(words.contains("is kept"), "{words}");
    assert_eq!(
        (
            file("run.json").expect("run.json"),
            file("steps.csv").expect("steps.csv")
        ),
        before
    );
    assert!(file("not-started/logs/particles.log").is_ok());
    assert_eq!(
        run(&["run.end_time=0.003", "output.every=0.003"]).0,
        Some(0)
    );
    assert_eq!(file("steps.csv").expect("steps.csv").lines().count(), 4);
    assert!(!place.path().join("run/.previous").exists());
}

#[test]
fn a_folder_that_cannot_be_written_is_wrong_usage() {
    let scene = root().join("scenes/one-grain.toml");
    let scene = scene.to_string_lossy();
    for arguments in [
        &["run", &scene][..],
        &["run", &scene, "--out", "/proc/run"],
        &["study", "one-grain", "--out", "/proc/study"],
    ] {
        let (code, words) = told(&sillage(Path::new("/proc"), arguments));
        assert_eq!(code, Some(2), "{words}");
        assert!(
            words.contains("--out") || words.contains("cannot create"),
            "{words}"
        );
    }
}
