//! Runs with real processes: what is written, and how they end when asked to or when somebody is
//! silent. What happens when one of them is killed is in `kills`.

use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::background::{
    LEAVING_MAX, Run, is_alive, need_programs, programs, report, root, shared_memory_of,
    small_cloud,
};
use crate::schema;

#[test]
fn a_run_writes_its_folder_and_leaves_no_trace_elsewhere() {
    let mut run = Run::start(&small_cloud(0.22));
    run.wait_for_steps(1);
    let (_, id) = run.children();
    let (code, words, _, folder) = run.finish();
    assert_eq!(code, Some(0), "{words}");
    let report = report(folder.path());
    println!("{:#}\n{:#}", report["cost"], report["worst"]);
    assert_eq!(report["steps"], 40);
    assert_eq!(report["engines"].as_array().map(Vec::len), Some(2));
    for file in [
        "frames/0004.png",
        "overview.png",
        "vtu/fluid_0004.vtu",
        "vtu/grains_0004.vtu",
    ] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
    assert!(id.is_empty() || shared_memory_of(&id).is_empty());
}

#[test]
fn an_interruption_stops_after_the_step_and_keeps_what_was_computed() {
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        let mut run = Run::start(&small_cloud(100.0));
        run.wait_for_steps(12);
        let (children, id) = run.children();
        kill(Pid::from_raw(run.child.id() as i32), signal).expect("signalled");
        let (code, words, elapsed, folder) = run.finish();
        println!("{signal}: exit code {code:?} after {elapsed:.2?}\n{words}");
        assert_eq!(code, Some(130));
        assert!(elapsed < LEAVING_MAX);
        assert!(words.contains("interrupted: stopped after step"), "{words}");
        assert!(children.values().all(|&pid| !is_alive(pid)));
        assert_eq!(shared_memory_of(&id), Vec::<String>::new());
        let report = report(folder.path());
        assert!(report["steps"].as_u64().is_some_and(|steps| steps >= 12));
        assert!(folder.path().join("frames/0001.png").exists());
        assert!(folder.path().join("overview.png").exists());
    }
}

#[test]
fn a_folder_that_a_run_writes_to_is_refused_to_another_until_it_is_over() {
    let scene = small_cloud(100.0);
    let mut run = Run::start(&scene);
    run.wait_for_steps(2);
    let folder = run.folder.path().to_path_buf();
    let second = || {
        Command::new(programs().join("sillage"))
            .arg("run")
            .args(&scene)
            .args(["--set", "run.end_time=0.011", "--out"])
            .arg(&folder)
            .output()
            .expect("started")
    };
    let refused = second();
    let words = String::from_utf8_lossy(&refused.stderr);
    println!("{words}");
    assert_eq!(refused.status.code(), Some(2));
    let owner = format!("in use by process {}", run.child.id());
    assert!(words.contains(&owner), "{words}");
    let before = run.rows();
    run.wait_for_steps(before + 2);
    // a process that died holds no folder
    let (children, _) = run.children();
    kill(Pid::from_raw(run.child.id() as i32), Signal::SIGKILL).expect("killed");
    run.child.wait().expect("gone");
    let begun = Instant::now();
    while children.values().any(|&pid| is_alive(pid)) && begun.elapsed() < LEAVING_MAX {
        std::thread::sleep(Duration::from_millis(20));
    }
    let again = second();
    let words = String::from_utf8_lossy(&again.stderr);
    assert_eq!(again.status.code(), Some(0), "{words}");
}

#[test]
fn a_second_interruption_kills() {
    let mut run = Run::start(&small_cloud(100.0));
    run.wait_for_steps(3);
    let (children, id) = run.children();
    // A process that does not answer any more: nothing short of a kill ends the run.
    kill(Pid::from_raw(children["sillage-fluid"]), Signal::SIGSTOP).expect("stopped");
    let this = Pid::from_raw(run.child.id() as i32);
    kill(this, Signal::SIGINT).expect("signalled");
    std::thread::sleep(Duration::from_millis(600));
    assert!(
        run.child.try_wait().expect("status").is_none(),
        "it must wait for the step"
    );
    kill(this, Signal::SIGINT).expect("signalled");
    let (code, words, elapsed, _folder) = run.finish();
    println!("exit code {code:?} after {elapsed:.2?}\n{words}");
    assert_eq!(code, Some(130));
    assert!(words.contains("killed after step"), "{words}");
    assert!(elapsed < LEAVING_MAX);
    assert!(children.values().all(|&pid| !is_alive(pid)));
    assert_eq!(shared_memory_of(&id), Vec::<String>::new());
}

#[test]
fn a_silent_engine_ends_the_run_at_its_time_limit() {
    let mut arguments = small_cloud(100.0);
    arguments.extend(["--set".to_string(), "limits.step=1.5".to_string()]);
    let mut run = Run::start(&arguments);
    run.wait_for_steps(3);
    let (children, id) = run.children();
    kill(Pid::from_raw(children["sillage-particl"]), Signal::SIGSTOP).expect("stopped");
    let (code, words, elapsed, _folder) = run.finish();
    println!("exit code {code:?} after {elapsed:.2?}\n{words}");
    assert_eq!(code, Some(6));
    assert!(words.contains("the particles did not send"), "{words}");
    assert!(elapsed < Duration::from_millis(1500) + LEAVING_MAX);
    assert!(children.values().all(|&pid| !is_alive(pid)));
    assert_eq!(shared_memory_of(&id), Vec::<String>::new());
}

/// Columns of steps.csv that are results and not times.
fn results(folder: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("steps.csv")).expect("steps.csv");
    let mut lines = text
        .lines()
        .map(|line| line.split(',').map(String::from).collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    let kept: Vec<usize> = (0..header.len())
        .filter(|&column| {
            !["wall", "cpu_"]
                .iter()
                .any(|time| header[column].starts_with(time))
        })
        .collect();
    lines
        .map(|row| kept.iter().map(|&column| row[column].clone()).collect())
        .collect()
}

#[test]
fn two_runs_at_once_do_not_disturb_each_other_and_agree_to_the_bit() {
    let (one, other) = (
        Run::start(&small_cloud(0.11)),
        Run::start(&small_cloud(0.11)),
    );
    let (one, other) = (one.finish(), other.finish());
    assert_eq!(
        (one.0, other.0),
        (Some(0), Some(0)),
        "{}\n{}",
        one.1,
        other.1
    );
    let (first, second) = (results(one.3.path()), results(other.3.path()));
    println!("{} steps, last: {:?}", first.len(), first.last());
    assert_eq!(first.len(), 20);
    assert_eq!(first, second);
}

fn output(arguments: &[&str]) -> Output {
    need_programs();
    schema::of_command(Path::new("."), arguments);
    let folder = tempfile::tempdir().expect("a folder");
    Command::new(env!("CARGO_BIN_EXE_sillage"))
        .args(arguments)
        .arg("--out")
        .arg(folder.path())
        .output()
        .expect("started")
}

#[test]
fn a_foreign_engine_that_cannot_start_or_leaves_at_once_is_named() {
    let scene = root().join("scenes/cloud.toml");
    let scene = scene.to_string_lossy();
    for (command, named) in [
        ("[\"/no/such/engine\"]", "is no program"),
        ("[\"false\"]", "ended with exit code 1"),
        (
            "[\"sh\", \"-c\", \"echo out of luck >&2; exit 3\"]",
            "out of luck",
        ),
    ] {
        let begun = Instant::now();
        let setting = format!("engines.particles.command={command}");
        let output = output(&[
            "run",
            &scene,
            "--set",
            &setting,
            "--set",
            "run.end_time=0.011",
        ]);
        let words = String::from_utf8_lossy(&output.stderr);
        println!(
            "{command}: {:?} after {:.2?}\n{words}",
            output.status,
            begun.elapsed()
        );
        assert!(matches!(output.status.code(), Some(2..=5)), "{words}");
        assert!(
            words.contains(named) && words.contains("particles"),
            "{words}"
        );
        assert!(begun.elapsed() < Duration::from_secs(20));
    }
}

#[test]
fn the_three_processes_run_when_started_by_hand() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = small_cloud(0.055);
    let output = Command::new(root().join("orchestration/three-processes.sh"))
        .arg(&arguments[0])
        .arg(folder.path())
        .args(&arguments[1..])
        .env("SILLAGE_PROGRAMS", programs())
        .output()
        .expect("started");
    let words = String::from_utf8_lossy(&output.stdout);
    println!("{words}{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success());
    assert_eq!(words.matches("exit code 0").count(), 3);
    let steps = std::fs::read_to_string(folder.path().join("steps.jsonl")).expect("steps");
    assert_eq!(steps.lines().count(), 10);
}

#[test]
fn a_dry_scene_starts_no_fluid_and_a_clear_one_no_grains() {
    need_programs();
    for (scene, settings, there, absent) in [
        (
            "dry-collapse",
            &["run.end_time=0.02"][..],
            "particles",
            "fluid",
        ),
        (
            "cavity",
            &["run.end_time=0.4", "fluid.domain.rectangle.cells=[8,8]"],
            "fluid",
            "particles",
        ),
    ] {
        let mut arguments = vec![
            root()
                .join(format!("scenes/{scene}.toml"))
                .to_string_lossy()
                .into_owned(),
        ];
        for setting in settings {
            arguments.extend(["--set".to_string(), setting.to_string()]);
        }
        let (code, words, _, folder) = Run::start(&arguments).finish();
        assert_eq!(code, Some(0), "{words}");
        let log = |seat: &str| folder.path().join(format!("logs/{seat}.log")).exists();
        assert!(log(there) && log("coupler") && !log(absent), "{scene}");
    }
}

#[test]
fn json_output_is_one_document() {
    need_programs();
    let scene = root().join("scenes/one-grain.toml");
    let scene = scene.to_string_lossy();
    let output = output(&["run", &scene, "--json", "--set", "run.end_time=0.02"]);
    assert_eq!(output.status.code(), Some(0));
    let document: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("one JSON document");
    assert_eq!(document["steps"], 20);
    assert_eq!(document["exit"]["meaning"], "ok");
}

#[test]
fn an_interruption_ends_a_step_that_is_halved_again_and_again_before_its_next_try() {
    // Passes that are never exact enough: every try fails, 33 of them down to 1e-12 s.
    let settings = [
        "coupling.scheme={ iterated = { tolerance = 1e-30, passes_max = 60 } }",
        "coupling.adaptive={ step_min = 1e-12, step_max = 5e-3, courant = 0.5 }",
        "output.frames=false",
    ];
    let scene = root().join("scenes/fluidised-bed.toml");
    let mut arguments = vec![scene.to_string_lossy().into_owned()];
    for setting in settings {
        arguments.extend(["--set".to_owned(), setting.to_owned()]);
    }
    let mut run = Run::start(&arguments);
    let log = run.folder.path().join("logs/coupler.log");
    let halvings = || {
        let text = std::fs::read_to_string(&log).unwrap_or_default();
        text.matches("step halved").count()
    };
    while halvings() == 0 {
        assert!(run.child.try_wait().expect("status").is_none());
        std::thread::sleep(Duration::from_millis(5));
    }
    let before = halvings();
    kill(Pid::from_raw(run.child.id() as i32), Signal::SIGINT).expect("signalled");
    let (code, words, elapsed, folder) = run.finish();
    let text = std::fs::read_to_string(folder.path().join("logs/coupler.log")).expect("a log");
    let after = text.matches("step halved").count();
    println!("{before} halvings, {after} at the end, {elapsed:?}: {words}");
    assert_eq!(code, Some(130));
    assert!(after <= before + 2, "{after}");
    assert!(
        words.contains("interrupted: stopped after step 0"),
        "{words}"
    );
}
