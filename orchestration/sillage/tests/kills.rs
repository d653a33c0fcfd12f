//! Whoever is killed, at whatever moment: everybody else leaves within two seconds, with exit code
//! 5, says who was lost, at which step and what was awaited, and shared memory is as it was.

use std::path::Path;
use std::time::{Duration, Instant};

use nix::sys::prctl::set_child_subreaper;
use nix::sys::signal::{Signal, kill};
use nix::sys::wait::{WaitStatus, waitpid};
use nix::unistd::Pid;

use crate::background::{Run, Schedule, is_alive, report, shared_memory_of, small_cloud};

/// Longest time between a death and the end of everybody else.
const LEAVING_MAX: Duration = Duration::from_secs(2);
/// Seat, and the name of its process as the system cuts it.
const CHILDREN: [(&str, &str); 3] = [
    ("fluid", "sillage-fluid"),
    ("particles", "sillage-particl"),
    ("coupler", "sillage-coupler"),
];
const PARTNER_LOST: i32 = 5;

/// How the survivors of one death left.
struct Aftermath {
    /// Steps written when the death came.
    step: usize,
    /// From the death until nobody was left.
    elapsed: Duration,
    /// Seats of the survivors with their exit codes.
    codes: Vec<(String, Option<i32>)>,
    /// What names the death: the orchestrator's last line, or a child's when it is the victim.
    words: String,
    /// What each surviving child wrote last.
    last_lines: Vec<String>,
    /// Files in shared memory that were not there before.
    left_over: Vec<String>,
}

/// Kill the process of this seat after `steps` steps and `pause`.
fn kill_one(arguments: &[String], seat: &str, steps: usize, pause: Duration) -> Aftermath {
    let mut run = Run::start(arguments);
    run.wait_for_steps(steps);
    std::thread::sleep(pause);
    let step = run.rows();
    let (children, id) = run.children();
    assert_eq!(children.len(), 3);
    let pid_of = |seat: &str| {
        let name = CHILDREN.iter().find(|(child, _)| *child == seat);
        name.map_or(run.child.id() as i32, |(_, name)| children[*name])
    };
    let begun = Instant::now();
    kill(Pid::from_raw(pid_of(seat)), Signal::SIGKILL).expect("killed");
    let everybody: Vec<i32> = children
        .values()
        .copied()
        .chain([run.child.id() as i32])
        .collect();
    while everybody.iter().any(|&pid| is_alive(pid)) && begun.elapsed() < 10 * LEAVING_MAX {
        std::thread::sleep(Duration::from_millis(5));
    }
    let elapsed = begun.elapsed();
    let survivors: Vec<(&str, i32)> = CHILDREN
        .iter()
        .filter(|(child, _)| *child != seat)
        .map(|(child, _)| (*child, pid_of(child)))
        .collect();
    let (code, heard, _, folder) = run.finish();
    let last_lines = survivors
        .iter()
        .map(|(child, _)| last_line(folder.path(), child))
        .collect::<Vec<_>>();
    let mut codes: Vec<(String, Option<i32>)> = survivors
        .iter()
        .map(|(child, pid)| match seat {
            // Orphans are ours to reap; the orchestrator says how the others ended.
            "orchestrator" => (child.to_string(), reaped(*pid)),
            _ => (child.to_string(), code_said(&heard, child)),
        })
        .collect();
    let words = if seat == "orchestrator" {
        last_lines[0].clone()
    } else {
        codes.push(("orchestrator".into(), code));
        let written = report(folder.path());
        let exit = &written["exit"]["code"];
        assert_eq!(*exit, PARTNER_LOST, "exit code {code:?}, said: {heard}");
        let last = heard.lines().rfind(|line| line.starts_with("sillage: "));
        last.unwrap_or_default().into()
    };
    Aftermath {
        step,
        elapsed,
        codes,
        words,
        last_lines,
        left_over: shared_memory_of(&id),
    }
}

fn reaped(pid: i32) -> Option<i32> {
    match waitpid(Pid::from_raw(pid), None) {
        Ok(WaitStatus::Exited(_, code)) => Some(code),
        other => {
            println!("process {pid}: {other:?}");
            None
        }
    }
}

/// "fluid ended with exit code 5" in what the orchestrator logged.
fn code_said(words: &str, seat: &str) -> Option<i32> {
    let said = format!("{seat} ended with exit code ");
    let after = &words[words.find(&said)? + said.len()..];
    after.split_whitespace().next()?.parse().ok()
}

fn last_line(folder: &Path, seat: &str) -> String {
    let path = folder.join(format!("logs/{seat}.log"));
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let line = text.lines().next_back().unwrap_or_default();
    // Without time and origin.
    let words = line.split_once(" ERROR ").map_or(line, |(_, words)| words);
    words
        .split_once(": ")
        .map_or(words, |(_, words)| words)
        .into()
}

impl Aftermath {
    fn assert(&self, seat: &str) {
        assert!(self.elapsed < LEAVING_MAX, "{:?}", self.elapsed);
        for (survivor, code) in &self.codes {
            assert_eq!(*code, Some(PARTNER_LOST), "the {survivor}: {}", self.words);
        }
        if seat != "orchestrator" {
            assert!(self.words.contains(&format!("the {seat} (process ")));
            assert!(
                self.words.contains("was killed by SIGKILL at step"),
                "{}",
                self.words
            );
        }
        for line in self.last_lines.iter().chain([&self.words]) {
            for part in [seat, "at step", "while"] {
                assert!(line.contains(part), "no `{part}` in: {line}");
            }
        }
        assert_eq!(self.left_over, Vec::<String>::new());
    }
}

/// Wide enough that a step takes a good part of a second: the fluid engine computes when it, or
/// somebody else, is killed.
fn busy_cloud() -> Vec<String> {
    let mut arguments = small_cloud(100.0);
    arguments.extend([
        "--set".to_string(),
        "fluid.domain.rectangle.cells=[120, 360]".to_string(),
    ]);
    arguments
}

fn print_header() {
    println!("   | victim       | step | until all gone | exit codes of the others | what is said");
}

fn print_row(number: usize, seat: &str, aftermath: &Aftermath) {
    let codes = aftermath
        .codes
        .iter()
        .map(|(seat, code)| {
            let code = code.map_or("?".into(), |code| code.to_string());
            format!("{}:{code}", &seat[..1])
        })
        .collect::<Vec<_>>()
        .join(" ");
    println!(
        "{number:2} | {seat:12} | {:4} | {:12.2} s | {codes:24} | {}",
        aftermath.step,
        aftermath.elapsed.as_secs_f64(),
        aftermath.words
    );
}

fn kill_all_in_turn(arguments: &[String], count: usize, steps_max: u64) {
    // Orphans of a killed orchestrator come to this process, which learns their exit codes.
    set_child_subreaper(true).expect("Linux");
    let victims = ["fluid", "particles", "coupler", "orchestrator"];
    let mut schedule = Schedule(20);
    let mut longest = Duration::ZERO;
    print_header();
    for number in 0..count {
        let seat = victims[number % victims.len()];
        let steps = 1 + schedule.below(steps_max) as usize;
        let pause = Duration::from_micros(schedule.below(20_000));
        let mut aftermath = kill_one(arguments, seat, steps, pause);
        print_row(number + 1, seat, &aftermath);
        // Other work on the machine can make one death late, not the same one three times.
        for _ in 0..2 {
            if aftermath.elapsed >= LEAVING_MAX {
                aftermath = kill_one(arguments, seat, steps, pause);
                print_row(number + 1, seat, &aftermath);
            }
        }
        aftermath.assert(seat);
        longest = longest.max(aftermath.elapsed);
    }
    println!("longest: {:.2} s", longest.as_secs_f64());
}

#[test]
fn twenty_deaths_at_random_steps_leave_nobody_and_nothing_behind() {
    // Pictures that are waiting to be drawn are drawn also after a death: not what is timed here.
    let mut arguments = small_cloud(100.0);
    arguments.extend(["--set", "output.frames=false"].map(String::from));
    kill_all_in_turn(&arguments, 20, 30);
}

#[test]
fn a_death_while_the_fluid_engine_computes_for_long_is_noticed_as_fast() {
    kill_all_in_turn(&busy_cloud(), 4, 2);
}
