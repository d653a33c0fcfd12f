//! Each process of a short run is killed at an instant that is drawn over the whole of it: while processes
//! start, greet each other, compute, commit, put out, and end. Whatever the instant, nobody is left two
//! seconds later, the culprit is named, and what was written can be read.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use protocol::runspace::RunSpace;

use crate::background::{Schedule, need_programs, programs, shared_memory_of, small_cloud};

const LEAVING_MAX: Duration = Duration::from_secs(2);
const VICTIMS: [(&str, &str); 4] = [
    ("orchestrator", "sillage"),
    ("coupler", "sillage-coupler"),
    ("fluid", "sillage-fluid"),
    ("particles", "sillage-particl"),
];
const PARTNER_LOST: i32 = 5;
/// How a fault begins that may be the machine's.
const LATE: &str = "somebody was left";
/// In the environment of every process of one trial.
const TAG: &str = "SILLAGE_TEST_TRIAL";

/// A process of a trial.
#[derive(Debug, Clone)]
struct Found {
    pid: i32,
    name: String,
    run: Option<String>,
}

/// Processes that have the tag of this trial, and are alive.
fn found(tag: &str) -> Vec<Found> {
    let wanted = format!("{TAG}={tag}");
    let entries = std::fs::read_dir("/proc").expect("/proc").flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    let tagged = pids.filter_map(|pid| {
        let environment = std::fs::read(format!("/proc/{pid}/environ")).ok()?;
        let text = String::from_utf8_lossy(&environment);
        let mut variables = text.split('\0');
        variables.clone().find(|variable| *variable == wanted)?;
        let run = variables.find_map(|variable| variable.strip_prefix("SILLAGE_RUN="));
        let name = std::fs::read_to_string(format!("/proc/{pid}/comm")).ok()?;
        Some(Found {
            pid,
            name: name.trim().to_owned(),
            run: run.map(String::from),
        })
    });
    tagged.collect()
}

/// How one trial ended.
#[derive(Debug)]
struct Trial {
    /// Of the orchestrator, none when it was the one killed.
    code: Option<i32>,
    /// What it said last.
    words: String,
    /// From the death until nobody was left; none when the run was over before.
    elapsed: Option<Duration>,
    /// Rows of steps.csv.
    rows: usize,
    /// What is wrong.
    faults: Vec<String>,
}

fn identity(orchestrator: u32, seen: &[Found]) -> Option<String> {
    let named = seen.iter().find_map(|process| process.run.clone());
    named.or_else(|| {
        let folders = std::fs::read_dir("/dev/shm").ok()?.flatten();
        let ours = folders.filter(|entry| {
            let seat = entry.path().join("members/orchestrator");
            let text = std::fs::read_to_string(seat).unwrap_or_default();
            text.starts_with(&format!("{orchestrator} "))
        });
        let name = ours.map(|entry| entry.file_name().to_string_lossy().into_owned());
        name.filter_map(|name| name.strip_prefix("sillage-").map(String::from))
            .next()
    })
}

/// Every row of a table is complete; how many there are.
fn rows(folder: &Path, faults: &mut Vec<String>) -> usize {
    let text = std::fs::read_to_string(folder.join("steps.csv")).unwrap_or_default();
    let columns = |line: &str| line.split(',').count();
    let width = text.lines().next().map_or(0, columns);
    if let Some(bad) = text.lines().find(|line| columns(line) != width) {
        faults.push(format!("a row is cut: {bad}"));
    }
    if !text.is_empty() && !text.ends_with('\n') {
        faults.push("the last row has no end".to_owned());
    }
    text.lines().count().saturating_sub(1)
}

fn attempt(seat: &str, name: &str, after: Duration, tag: &str) -> Trial {
    let folder = tempfile::tempdir().expect("a folder");
    let temporary = tempfile::tempdir().expect("a folder");
    let mut arguments = small_cloud(0.11);
    arguments.extend(["--set", "output.frames=false"].map(String::from));
    let child = Command::new(programs().join("sillage"))
        .arg("run")
        .args(arguments)
        .args(["--threads", "1", "--out"])
        .arg(folder.path().join("run"))
        .env(TAG, tag)
        .env("TMPDIR", temporary.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let orchestrator = child.id();
    std::thread::sleep(after);
    // One that is not there yet is killed as soon as it is.
    let seen = loop {
        let seen = found(tag);
        let over = !seen
            .iter()
            .any(|process| process.pid == orchestrator as i32);
        if over || seen.iter().any(|process| process.name == name) {
            break seen;
        }
        std::thread::sleep(Duration::from_micros(500));
    };
    let run = identity(orchestrator, &seen);
    let victim = seen.iter().find(|process| process.name == name);
    let killed = Instant::now();
    let hit = victim.is_some_and(|v| kill(Pid::from_raw(v.pid), Signal::SIGKILL).is_ok());
    while !found(tag).is_empty() && killed.elapsed() < 5 * LEAVING_MAX {
        std::thread::sleep(Duration::from_millis(5));
    }
    let elapsed = hit.then(|| killed.elapsed());
    for process in found(tag) {
        // It would be waited for below.
        let _ = kill(Pid::from_raw(process.pid), Signal::SIGKILL);
    }
    let output = child.wait_with_output().expect("ended");
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let mut faults = Vec::new();
    match elapsed {
        Some(elapsed) if elapsed > 4 * LEAVING_MAX => {
            faults.push(format!("somebody would never have left: {words}"));
        }
        Some(elapsed) if elapsed > LEAVING_MAX => faults.push(format!("{LATE} after {elapsed:?}")),
        _ => {}
    }
    if seat == "orchestrator" {
        // What nobody was left to remove the next run removes.
        drop(RunSpace::create().expect("another run"));
    }
    let left = run.map(|run| shared_memory_of(&run)).unwrap_or_default();
    if !left.is_empty() {
        faults.push(format!(
            "left in shared memory: {}, e.g. {:?}",
            left.len(),
            left[0]
        ));
    }
    let left = std::fs::read_dir(temporary.path())
        .expect("a folder")
        .count();
    if left > 0 {
        faults.push(format!(
            "{left} files left in the folder of temporary files"
        ));
    }
    let rows = rows(&folder.path().join("run"), &mut faults);
    let code = output.status.code();
    let pid = victim.map_or(0, |victim| victim.pid);
    match (hit && seat != "orchestrator", code) {
        (true, Some(PARTNER_LOST)) => {
            let named = format!("the {seat} (process {pid}) was killed by SIGKILL");
            let finished = format!("all steps were computed, but the {seat} was killed by SIGKILL");
            if !words.contains(&named) && !words.contains(&finished) {
                faults.push(format!("the {seat} is not named: {words}"));
            }
        }
        // It had left before the signal came.
        (_, Some(0)) => {}
        (false, None) if seat == "orchestrator" => {}
        (_, code) => faults.push(format!("exit code {code:?}: {words}")),
    }
    let words = words.lines().next_back().unwrap_or_default().to_owned();
    Trial {
        code,
        words,
        elapsed,
        rows,
        faults,
    }
}

fn kill_at_instants(count: usize, seed: u64) {
    need_programs();
    let mut schedule = Schedule(seed);
    // As long as such a run takes here and now.
    let whole = |number: u64| {
        let begun = Instant::now();
        let tag = format!("whole{seed}x{number}");
        let trial = attempt("nobody", "nobody", Duration::ZERO, &tag);
        assert_eq!(trial.faults, Vec::<String>::new());
        begun.elapsed().as_micros() as u64
    };
    let span = (0..3).map(whole).min().unwrap_or_default();
    println!("a run takes {:.2} s", span as f64 * 1e-6);
    println!("   n | victim       | at [ms] | exit | rows | all gone [s] | last words");
    let (mut hits, mut longest) = ([0; 4], Duration::ZERO);
    for number in 0..count {
        let place = number % VICTIMS.len();
        let (seat, name) = VICTIMS[place];
        let mut after = Duration::from_micros(schedule.below(span));
        let mut trial = attempt(seat, name, after, &format!("{seed}x{number}"));
        // It was over before: earlier, then.
        while trial.elapsed.is_none() && trial.faults.is_empty() && !after.is_zero() {
            after /= 2;
            trial = attempt(
                seat,
                name,
                after,
                &format!("{seed}x{number}x{}", after.as_micros()),
            );
        }
        // Other work on the machine can make one death late, not the same one three times.
        for again in 0..2 {
            if trial.faults.iter().any(|fault| fault.starts_with(LATE)) {
                println!("again: {:?}", trial.faults);
                trial = attempt(seat, name, after, &format!("{seed}x{number}x{again}"));
            }
        }
        println!(
            "{number:4} | {seat:12} | {:7.1} | {:4} | {:4} | {:12.2} | {}",
            after.as_secs_f64() * 1e3,
            trial.code.map_or("–".to_owned(), |code| code.to_string()),
            trial.rows,
            trial.elapsed.unwrap_or_default().as_secs_f64(),
            trial.words
        );
        assert_eq!(trial.faults, Vec::<String>::new());
        assert!(trial.elapsed.is_some(), "it could not be killed");
        hits[place] += 1;
        longest = longest.max(trial.elapsed.unwrap_or_default());
    }
    let seats = VICTIMS.map(|(seat, _)| seat);
    println!("{count} trials, hits {hits:?} of {seats:?}, longest {longest:.2?}");
}

#[test]
fn twelve_deaths_at_random_instants_leave_nobody_and_nothing_behind() {
    kill_at_instants(12, 13);
}

#[test]
#[ignore = "200 runs: minutes"]
fn two_hundred_deaths_at_random_instants_leave_nobody_and_nothing_behind() {
    kill_at_instants(200, 200);
}
