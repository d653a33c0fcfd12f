//! Runs with real processes: what is written, and that whatever is killed, the others leave within
//! seconds, the reason is named, and nothing stays in shared memory.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Once;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

/// Longest time between a death and the end of everybody else.
const LEAVING_MAX: Duration = Duration::from_secs(6);
/// A machine that is busy with other tests may take long to get a run going.
const STARTING_MAX: Duration = Duration::from_secs(60);

fn programs() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_sillage"))
        .parent()
        .expect("a folder")
        .to_path_buf()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The engines and the coupler, built when they are not there yet.
fn need_programs() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let names = ["sillage-fluid", "sillage-particles", "sillage-coupler"];
        if names.iter().all(|name| programs().join(name).exists()) {
            return;
        }
        let mut cargo = Command::new(env!("CARGO"));
        cargo
            .args(["build", "--workspace", "--bins"])
            .current_dir(root());
        if programs().ends_with("release") {
            cargo.arg("--release");
        }
        assert!(
            cargo.status().expect("cargo").success(),
            "the programs cannot be built"
        );
    });
}

/// A small cloud, as many steps as a test needs: about 10 ms each.
fn small_cloud(end_time: f64) -> Vec<String> {
    let mut arguments = vec![
        root()
            .join("scenes/cloud.toml")
            .to_string_lossy()
            .into_owned(),
    ];
    for setting in [
        "fluid.domain.rectangle.cells=[10, 30]".to_string(),
        "grains[0].radius=1.5e-4".to_string(),
        format!("run.end_time={end_time}"),
        "output.every=0.055".to_string(),
    ] {
        arguments.extend(["--set".to_string(), setting]);
    }
    arguments
}

/// A run in the background.
struct Run {
    child: Child,
    folder: tempfile::TempDir,
}

impl Run {
    fn start(arguments: &[String]) -> Run {
        need_programs();
        let folder = tempfile::tempdir().expect("a folder");
        let child = Command::new(env!("CARGO_BIN_EXE_sillage"))
            .arg("run")
            .args(arguments)
            .args(["--threads", "1", "--out"])
            .arg(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        Run { child, folder }
    }

    fn rows(&self) -> usize {
        let text =
            std::fs::read_to_string(self.folder.path().join("steps.csv")).unwrap_or_default();
        text.lines().count().saturating_sub(1)
    }

    /// Wait until some steps are computed; then all processes are there.
    fn wait_for_steps(&mut self, count: usize) {
        let begun = Instant::now();
        while self.rows() < count {
            let ended = self.child.try_wait().expect("status");
            assert!(
                ended.is_none() && begun.elapsed() < STARTING_MAX,
                "no steps: {}",
                self.words()
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Children by program name (cut by the system to 15 characters), and the run's identity.
    fn children(&self) -> (BTreeMap<String, i32>, String) {
        let mut found = BTreeMap::new();
        let mut run = String::new();
        for entry in std::fs::read_dir("/proc").expect("/proc").flatten() {
            let Ok(pid) = entry.file_name().to_string_lossy().parse::<i32>() else {
                continue;
            };
            let stat = std::fs::read_to_string(entry.path().join("stat")).unwrap_or_default();
            let Some((start, rest)) = stat.rsplit_once(") ") else {
                continue;
            };
            if rest.split_whitespace().nth(1) != Some(&self.child.id().to_string()) {
                continue;
            }
            let name = start
                .split_once('(')
                .map_or("", |(_, name)| name)
                .to_string();
            let environment = std::fs::read(entry.path().join("environ")).unwrap_or_default();
            for variable in environment.split(|&byte| byte == 0) {
                if let Some(id) = String::from_utf8_lossy(variable).strip_prefix("SILLAGE_RUN=") {
                    run = id.to_string();
                }
            }
            found.insert(name, pid);
        }
        (found, run)
    }

    fn words(&mut self) -> String {
        let mut text = String::new();
        if let Some(stderr) = &mut self.child.stderr {
            let _ = stderr.read_to_string(&mut text);
        }
        text
    }

    /// Wait for the end; exit code, stderr, and how long it took.
    fn finish(mut self) -> (Option<i32>, String, Duration, tempfile::TempDir) {
        let begun = Instant::now();
        let words = self.words();
        let status = self.child.wait().expect("reaped");
        (status.code(), words, begun.elapsed(), self.folder)
    }
}

/// Files of a run in shared memory.
fn shared_memory_of(run: &str) -> Vec<String> {
    let entries = std::fs::read_dir("/dev/shm").expect("/dev/shm").flatten();
    entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name.contains(run))
        .collect()
}

fn is_alive(pid: i32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit_once(") ")
        .is_some_and(|(_, rest)| !rest.starts_with('Z'))
}

fn report(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("run.json")).expect("run.json");
    serde_json::from_str(&text).expect("JSON")
}

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

/// Kill one process of a run that is on its way; everybody else must leave, with the reason named.
fn survivors_of(victim: &str, seat: &str) {
    let mut run = Run::start(&small_cloud(100.0));
    run.wait_for_steps(3);
    let (children, id) = run.children();
    println!("run {id}: {children:?}");
    assert_eq!(children.len(), 3);
    kill(Pid::from_raw(children[victim]), Signal::SIGKILL).expect("killed");
    let (code, words, elapsed, folder) = run.finish();
    println!("{victim} killed: exit code {code:?} after {elapsed:.2?}\n{words}");
    assert_eq!(code, Some(5));
    assert!(elapsed < LEAVING_MAX);
    assert!(
        words.contains(&format!("the {seat} (process {})", children[victim])),
        "{words}"
    );
    assert!(words.contains("SIGKILL at step"), "{words}");
    for (name, pid) in children {
        assert!(!is_alive(pid), "{name} still runs");
    }
    assert_eq!(shared_memory_of(&id), Vec::<String>::new());
    let report = report(folder.path());
    assert_eq!(report["exit"]["code"], 5);
    assert!(report["steps"].as_u64().is_some_and(|steps| steps >= 3));
}

#[test]
fn when_the_fluid_engine_is_killed_the_others_leave_and_it_is_named() {
    survivors_of("sillage-fluid", "fluid");
}

#[test]
fn when_the_particle_engine_is_killed_the_others_leave_and_it_is_named() {
    survivors_of("sillage-particl", "particles");
}

#[test]
fn when_the_coupler_is_killed_the_others_leave_and_it_is_named() {
    survivors_of("sillage-coupler", "coupler");
}

#[test]
fn when_the_orchestrator_is_killed_the_others_leave_and_clean_up() {
    let mut run = Run::start(&small_cloud(100.0));
    run.wait_for_steps(3);
    let (children, id) = run.children();
    assert_eq!(children.len(), 3);
    run.child.kill().expect("killed");
    run.child.wait().expect("reaped");
    let begun = Instant::now();
    while children.values().any(|&pid| is_alive(pid)) {
        assert!(begun.elapsed() < LEAVING_MAX, "still there: {children:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
    println!("all gone after {:.2?}", begun.elapsed());
    assert_eq!(shared_memory_of(&id), Vec::<String>::new());
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
        .filter(|&column| header[column] != "wall" && !header[column].starts_with("cpu_"))
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
        ("[\"/no/such/engine\"]", "could not be started"),
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
        assert!(matches!(output.status.code(), Some(3..=5)), "{words}");
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
