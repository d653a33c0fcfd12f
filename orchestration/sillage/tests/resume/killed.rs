//! Whoever is killed, at whatever moment: the run goes on, and its results are those of a run that nobody
//! disturbed.

use std::path::Path;
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::background::{Run, Schedule, small_cloud};
use crate::resume::same::{assert_same, kept, resume};

const END_TIME: f64 = 0.3;
const VICTIMS: [&str; 6] = [
    "sillage-coupler",
    "sillage-fluid",
    "sillage-particl",
    "orchestrator",
    "all",
    "interrupt",
];

fn arguments() -> Vec<String> {
    let mut arguments = small_cloud(END_TIME);
    for setting in ["checkpoint.every_steps=3", "output.frames=true"] {
        arguments.extend(["--set".to_owned(), setting.to_owned()]);
    }
    arguments.push("--record".to_owned());
    arguments
}

/// End a run after `steps` steps and `pause`; its folder.
fn disturb(victim: &str, steps: usize, pause: Duration) -> tempfile::TempDir {
    let mut run = Run::start(&arguments());
    run.wait_for_steps(steps);
    std::thread::sleep(pause);
    let (children, _) = run.children();
    let own = Pid::from_raw(run.child.id() as i32);
    let end = |pid: i32| _ = kill(Pid::from_raw(pid), Signal::SIGKILL);
    match victim {
        "interrupt" => _ = kill(own, Signal::SIGINT),
        "orchestrator" => end(own.as_raw()),
        "all" => {
            end(own.as_raw());
            children.values().for_each(|&pid| end(pid));
        }
        name => end(children.get(name).copied().unwrap_or(own.as_raw())),
    }
    let (code, words, _, folder) = run.finish();
    // It may have been at its end, or before its start.
    let out_of_it = code == Some(0) || words.contains("after step 0");
    let told = out_of_it || words.contains("sillage resume");
    assert!(victim != "interrupt" || told, "{words}");
    folder
}

/// Resume the run: then it is the undisturbed one. From which step; none where it had not begun.
fn goes_on(undisturbed: &Path, folder: &Path) -> Option<u64> {
    let from = kept(folder).pop();
    let (code, said, words) = resume(folder, &["--threads", "1"]);
    if code == Some(2) && !folder.join("steps.csv").exists() {
        return None;
    }
    assert_eq!(code, Some(0), "{said} {words}");
    assert_same(undisturbed, folder);
    Some(from.unwrap_or(0))
}

fn trials(seeds: std::ops::Range<u64>) {
    let whole = Run::start(&arguments());
    let (code, words, _, undisturbed) = whole.finish();
    assert_eq!(code, Some(0), "{words}");
    for seed in seeds {
        let victim = VICTIMS[seed as usize % VICTIMS.len()];
        let mut drawn = Schedule(seed);
        let (steps, pause) = (drawn.below(30), Duration::from_micros(drawn.below(20_000)));
        let folder = disturb(victim, steps as usize, pause);
        let from = goes_on(undisturbed.path(), folder.path());
        let from = from.map_or("not begun".to_owned(), |step| {
            format!("resumed after {step}")
        });
        println!("{seed:>4} {victim:<16} after {steps:>2} steps and {pause:>10.1?}: {from}");
    }
}

#[test]
fn a_killed_run_goes_on_as_if_nothing_had_been() {
    trials(0..6);
}

#[test]
#[ignore = "ten minutes"]
fn two_hundred_killed_runs_go_on_as_if_nothing_had_been() {
    trials(0..200);
}
