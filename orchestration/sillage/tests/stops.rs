//! Processes that are stopped (SIGSTOP): one that does not go on is named and ends the run within its
//! limit; all of them for longer than every limit, and the run goes on as if nothing had been.

use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::background::{LEAVING_MAX, Run, is_alive, report, shared_memory_of, small_cloud};

const TIME_LIMIT: i32 = 6;

fn quick() -> Vec<String> {
    let mut arguments = small_cloud(100.0);
    arguments.extend(["--set", "output.frames=false"].map(String::from));
    arguments
}

#[test]
fn a_stopped_process_that_does_not_go_on_is_named_and_ends_the_run() {
    for (seat, name) in [
        ("coupler", "sillage-coupler"),
        ("fluid", "sillage-fluid"),
        ("particles", "sillage-particl"),
    ] {
        let mut run = Run::start_with(&quick(), &[("SILLAGE_STOPPED_LIMIT", "1.5")]);
        run.wait_for_steps(3);
        let (children, id) = run.children();
        kill(Pid::from_raw(children[name]), Signal::SIGSTOP).expect("stopped");
        let begun = Instant::now();
        let (code, words, _, folder) = run.finish();
        println!(
            "{seat}: exit code {code:?} after {:.2?}\n{words}",
            begun.elapsed()
        );
        assert_eq!(code, Some(TIME_LIMIT), "{words}");
        let named = format!(
            "the {seat} (process {}) was stopped (SIGSTOP)",
            children[name]
        );
        assert!(words.contains(&named), "{words}");
        assert!(begun.elapsed() < Duration::from_millis(1500) + LEAVING_MAX);
        assert!(children.values().all(|&pid| !is_alive(pid)));
        assert_eq!(shared_memory_of(&id), Vec::<String>::new());
        assert_eq!(report(folder.path())["exit"]["code"], TIME_LIMIT);
    }
}

#[test]
fn a_stopped_orchestrator_is_not_waited_for_without_limit() {
    let mut run = Run::start_with(&quick(), &[("SILLAGE_TAKE_OVER_LIMIT", "1.5")]);
    run.wait_for_steps(3);
    let (children, id) = run.children();
    let this = Pid::from_raw(run.child.id() as i32);
    kill(this, Signal::SIGSTOP).expect("stopped");
    let begun = Instant::now();
    // Its queue of messages is filled first.
    let most = Duration::from_secs(20);
    while children.values().any(|&pid| is_alive(pid)) && begun.elapsed() < most {
        std::thread::sleep(Duration::from_millis(20));
    }
    println!("all gone after {:.2?}", begun.elapsed());
    assert!(begun.elapsed() < most);
    kill(this, Signal::SIGCONT).expect("goes on");
    let (code, words, ..) = run.finish();
    assert_eq!(code, Some(TIME_LIMIT), "{words}");
    assert!(words.contains("the orchestrator did not"), "{words}");
    assert_eq!(shared_memory_of(&id), Vec::<String>::new());
}

#[test]
fn a_stopped_engine_does_not_outlive_an_orchestrator_that_was_killed() {
    let mut run = Run::start(&quick());
    run.wait_for_steps(3);
    let (children, id) = run.children();
    kill(Pid::from_raw(children["sillage-fluid"]), Signal::SIGSTOP).expect("stopped");
    run.child.kill().expect("killed");
    let begun = Instant::now();
    while children.values().any(|&pid| is_alive(pid)) {
        assert!(begun.elapsed() < Duration::from_secs(2), "{children:?}");
        std::thread::sleep(Duration::from_millis(10));
    }
    println!("all gone after {:.2?}", begun.elapsed());
    drop(protocol::runspace::RunSpace::create().expect("another run"));
    assert_eq!(shared_memory_of(&id), Vec::<String>::new());
    run.finish();
}

#[test]
fn a_run_that_is_stopped_as_a_whole_for_longer_than_every_limit_goes_on() {
    const SHORT: &str = "3";
    let limits = [
        "SILLAGE_CONNECT_LIMIT",
        "SILLAGE_IDLE_LIMIT",
        "SILLAGE_QUEUE_LIMIT",
        "SILLAGE_LEAVE_LIMIT",
        "SILLAGE_MONITOR_LIMIT",
        "SILLAGE_TAKE_OVER_LIMIT",
        "SILLAGE_STOPPED_LIMIT",
        "SILLAGE_LOCK_LIMIT",
    ];
    let mut arguments = small_cloud(2.2);
    for setting in ["output.frames=false", "limits.step=3", "limits.connect=3"] {
        arguments.extend(["--set".to_owned(), setting.to_owned()]);
    }
    let mut run = Run::start_with(&arguments, &limits.map(|name| (name, SHORT)));
    let mut stops = 0;
    for steps in [3, 40, 80, 120] {
        run.wait_for_steps(steps);
        let (children, _) = run.children();
        let everybody: Vec<i32> = children
            .into_values()
            .chain([run.child.id() as i32])
            .collect();
        let tell = |signal| {
            for &pid in &everybody {
                let _ = kill(Pid::from_raw(pid), signal);
            }
        };
        tell(Signal::SIGSTOP);
        std::thread::sleep(Duration::from_secs(6));
        tell(Signal::SIGCONT);
        stops += 1;
    }
    let (code, words, ..) = run.finish();
    println!("{stops} stops of 6 s, every limit {SHORT} s: exit code {code:?}");
    assert_eq!(code, Some(0), "{words}");
}
