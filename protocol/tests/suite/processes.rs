//! Real processes: the test program starts itself again in another role.

use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use protocol::Error;
use protocol::engine::{serve_fluid, serve_particles};
use protocol::ipc::engine_link;
use protocol::local::{LIMITS, spawn_fluid, spawn_particles};
use protocol::message::Role;
use protocol::partner::Partner;
use protocol::process;
use protocol::runspace::RunSpace;
use protocol::scene::Limits;

use crate::runspaces::files_of;
use crate::toy::{self, Fault, ToyFluid, ToyGrains, fluid_run, particle_run};

const ROLE: &str = "SILLAGE_TEST_ROLE";
const FAULT: &str = "SILLAGE_TEST_FAULT";

/// Entry of the child processes; as a test it does nothing.
#[test]
fn child() {
    let Ok(role) = std::env::var(ROLE) else {
        return;
    };
    let fault = Fault::named(&std::env::var(FAULT).unwrap_or_default());
    std::process::exit(match role.as_str() {
        "fluid" => process::exit_code("fluid", |run| {
            serve_fluid(&mut ToyFluid::new(fault), engine_link(run, Role::Fluid)?)
        }),
        "particles" => process::exit_code("particles", |run| {
            serve_particles(&mut ToyGrains::new(), engine_link(run, Role::Particles)?)
        }),
        "coupler" => process::exit_code("coupler", endless_coupler),
        _ => orchestrator(),
    });
}

/// Steps both engines until something happens.
fn endless_coupler(run: &RunSpace) -> Result<(), Error> {
    let mut fluid = Partner::accept(Role::Fluid, run, &LIMITS)?;
    let mut particles = Partner::accept(Role::Particles, run, &LIMITS)?;
    fluid.configure_fluid(&toy::fluid_scene(4))?;
    particles.configure_particles(&toy::particle_scene(), &toy::grains(3))?;
    for step in 1.. {
        for engine in [&mut fluid, &mut particles] {
            engine.advance(&toy::request(step, 0), &[], &mut [])?;
            engine.commit(step)?;
        }
    }
    Ok(())
}

/// Owns a run, tells its name, waits to be killed.
fn orchestrator() -> i32 {
    let run = RunSpace::create().unwrap();
    println!(
        "\n{}",
        run.to_environment()
            .iter()
            .map(|(k, v)| format!("{k}={v} "))
            .collect::<String>()
    );
    std::thread::sleep(Duration::from_secs(30));
    0
}

pub fn start(role: &str, environment: &[(String, String)], fault: &str) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    // What started the tests may ignore signals (nohup, a shell's `&`), and children inherit that.
    // SAFETY: signal is async-signal-safe.
    unsafe {
        command.pre_exec(|| {
            for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
                libc::signal(signal, libc::SIG_DFL);
            }
            Ok(())
        });
    }
    command
        .args([
            "--exact",
            "processes::child",
            "--nocapture",
            "--test-threads=1",
        ])
        .envs(environment.iter().cloned())
        .envs([
            (ROLE, role),
            (FAULT, fault),
            ("SILLAGE_LOG", "error,iceoryx2_bb_loggers=off"),
            ("RUST_BACKTRACE", "0"),
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Exit code and stderr of a child that must end within `limit`.
pub fn end(mut child: Child, limit: Duration) -> (Option<i32>, String) {
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > limit {
            child.kill().unwrap();
            let output = child.wait_with_output().unwrap();
            panic!(
                "still running after {limit:?}: {}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let took = began.elapsed();
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    println!(
        "exit {:?} after {took:.0?}: {}",
        output.status.code(),
        text.trim()
    );
    (output.status.code(), text)
}

fn signal(child: &Child, signal: rustix::process::Signal) {
    let pid = rustix::process::Pid::from_child(child);
    rustix::process::kill_process(pid, signal).unwrap();
}

/// Another start of a run may be at the removal just now.
pub fn wait_until_gone(id: &str) {
    let began = Instant::now();
    while !files_of(id).is_empty() {
        assert!(
            began.elapsed() < Duration::from_secs(2),
            "left in shared memory: {:?}",
            files_of(id)
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn processes_and_threads_give_the_same_bits_and_leave_nothing() {
    let run = RunSpace::create().unwrap();
    let id = run.id().to_owned();
    let engines = ["fluid", "particles"].map(|role| start(role, &run.to_environment(), ""));
    let mut fluid = Partner::accept(Role::Fluid, &run, &LIMITS).unwrap();
    let mut particles = Partner::accept(Role::Particles, &run, &LIMITS).unwrap();
    assert_eq!(fluid.hello().process, engines[0].id());
    let apart = (fluid_run(&mut fluid, 300), particle_run(&mut particles));
    fluid.finish().unwrap();
    particles.finish().unwrap();
    for engine in engines {
        assert_eq!(end(engine, Duration::from_secs(2)).0, Some(0));
    }
    drop((fluid, particles, run));
    wait_until_gone(&id);
    let mut fluid = spawn_fluid(|| ToyFluid::new(Fault::None)).unwrap();
    let mut particles = spawn_particles(ToyGrains::new).unwrap();
    let together = (fluid_run(&mut fluid, 300), particle_run(&mut particles));
    println!("{} + {} numbers compared", apart.0.len(), apart.1.len());
    assert_eq!(together, apart);
}

#[test]
fn two_runs_at_once_do_not_meet() {
    let runs = [RunSpace::create().unwrap(), RunSpace::create().unwrap()];
    let engines = [0, 1].map(|k| start("fluid", &runs[k].to_environment(), ""));
    let mut links = [0, 1].map(|k| Partner::accept(Role::Fluid, &runs[k], &LIMITS).unwrap());
    for (link, engine) in links.iter().zip(&engines) {
        assert_eq!(link.hello().process, engine.id());
    }
    for (link, cells) in links.iter_mut().zip([5, 70]) {
        assert_eq!(
            link.configure_fluid(&toy::fluid_scene(cells))
                .unwrap()
                .simplex_count(),
            2 * cells
        );
    }
    for step in 1..20 {
        for link in &mut links {
            link.advance(&toy::request(step, 0), &[], &mut []).unwrap();
            link.commit(step).unwrap();
        }
    }
    links.iter_mut().for_each(|link| link.finish().unwrap());
    for engine in engines {
        assert_eq!(end(engine, Duration::from_secs(2)).0, Some(0));
    }
    let ids = runs.each_ref().map(|run| run.id().to_owned());
    drop((links, runs));
    ids.iter().for_each(|id| wait_until_gone(id));
}

#[test]
fn a_killed_engine_ends_the_wait_within_a_second_and_takes_its_files_along() {
    let run = RunSpace::create().unwrap();
    let id = run.id().to_owned();
    let mut victim = start("fluid", &run.to_environment(), "sleeps");
    let other = start("particles", &run.to_environment(), "");
    let mut fluid = Partner::accept(Role::Fluid, &run, &LIMITS).unwrap();
    let particles = Partner::accept(Role::Particles, &run, &LIMITS).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(4)).unwrap();
    fluid.advance(&toy::request(1, 0), &[], &mut []).unwrap();
    fluid.commit(1).unwrap();
    // As a process leaves it that is killed between making and sizing a segment: who opens it waits for ever.
    let half = format!("/dev/shm/sillage{}_half.connection", &id[..10]);
    std::fs::write(&half, "").unwrap();
    let killer = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(300));
        victim.kill().unwrap();
        let killed = Instant::now();
        assert_eq!(victim.wait().unwrap().signal(), Some(9));
        killed
    });
    let error = fluid
        .advance(&toy::request(2, 0), &[], &mut [])
        .unwrap_err();
    let noticed = Instant::now();
    let latency = noticed.saturating_duration_since(killer.join().unwrap());
    println!("{error}, noticed {latency:?} after the kill");
    assert_eq!(
        error.to_string(),
        "the fluid is gone at step 2, while waiting for Done"
    );
    assert!(latency < Duration::from_secs(1), "{latency:?}");
    while std::path::Path::new(&half).exists() {
        assert!(noticed.elapsed() < Duration::from_secs(1));
    }
    let (code, text) = end(other, Duration::from_secs(1));
    assert_eq!(code, Some(5));
    assert!(text.contains("the fluid is gone"), "{text}");
    drop((fluid, particles, run));
    wait_until_gone(&id);
}

/// Starts a run owned by a process of its own, steps it, kills `victim`; everybody else must leave.
fn kill_and_watch(victim: &str, fault: &str) {
    // Both links are open, with all their services.
    const MANY: usize = 60;
    let mut owner = start("orchestrator", &[], "");
    let line = BufReader::new(owner.stdout.take().unwrap())
        .lines()
        .map_while(Result::ok);
    let line = line
        .into_iter()
        .find(|line| line.contains("SILLAGE_RUN"))
        .unwrap();
    let pairs = line
        .split_whitespace()
        .filter_map(|pair| pair.split_once('='));
    let environment: Vec<_> = pairs.map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
    let id = environment[0].1.clone();
    let mut all = vec![("orchestrator", owner)];
    for role in ["fluid", "particles", "coupler"] {
        all.push((role, start(role, &environment, fault)));
    }
    let began = Instant::now();
    while files_of(&id).len() < MANY {
        assert!(
            began.elapsed() < Duration::from_secs(20),
            "the run does not begin"
        );
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(300));
    let place = all.iter().position(|(role, _)| *role == victim).unwrap();
    let (_, mut killed) = all.remove(place);
    killed.kill().unwrap();
    killed.wait().unwrap();
    for (role, child) in all {
        if role == "orchestrator" {
            // The real one reaps its children and leaves last.
            signal(&child, rustix::process::Signal::KILL);
            child.wait_with_output().unwrap();
            let ours = RunSpace::leftovers()
                .unwrap()
                .into_iter()
                .filter(|left| left.id == id);
            ours.for_each(|left| println!("{} files swept", left.sweep().unwrap()));
            continue;
        }
        let (code, text) = end(child, Duration::from_secs(2));
        assert_eq!(code, Some(5), "{role}: {text}");
        assert!(
            text.contains(&format!("the {victim} is gone at step")),
            "{role}: {text}"
        );
    }
    wait_until_gone(&id);
}

#[test]
fn a_killed_orchestrator_ends_all_and_the_last_one_removes_the_run() {
    kill_and_watch("orchestrator", "");
}

#[test]
fn a_busy_engine_is_ended_by_its_watch() {
    kill_and_watch("orchestrator", "sleeps");
}

#[test]
fn a_panicking_engine_exits_with_4_and_its_words_reach_the_coupler() {
    let run = RunSpace::create().unwrap();
    let engine = start("fluid", &run.to_environment(), "panic");
    let mut fluid = Partner::accept(Role::Fluid, &run, &LIMITS).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(4)).unwrap();
    fluid.advance(&toy::request(1, 0), &[], &mut []).unwrap();
    fluid.commit(1).unwrap();
    let error = fluid
        .advance(&toy::request(2, 0), &[], &mut [])
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "the fluid failed at step 2: panicked: the toy breaks"
    );
    drop(fluid);
    assert_eq!(end(engine, Duration::from_secs(2)).0, Some(4));
}

#[test]
fn a_stopped_engine_ends_at_the_time_limit() {
    let run = RunSpace::create().unwrap();
    let engine = start("fluid", &run.to_environment(), "");
    let limits = Limits {
        step: 0.5,
        ..LIMITS
    };
    let mut fluid = Partner::accept(Role::Fluid, &run, &limits).unwrap();
    fluid.configure_fluid(&toy::fluid_scene(4)).unwrap();
    signal(&engine, rustix::process::Signal::STOP);
    let stat = format!("/proc/{}/stat", engine.id());
    while !std::fs::read_to_string(&stat).unwrap().contains(") T ") {
        std::thread::sleep(Duration::from_millis(1));
    }
    let error = fluid
        .advance(&toy::request(1, 0), &[], &mut [])
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "the fluid did not send Done within 0.5 s at step 1"
    );
    assert_eq!(error.exit_code(), 6);
    signal(&engine, rustix::process::Signal::CONT);
    drop(fluid);
    end(engine, Duration::from_secs(2));
}

#[test]
fn a_second_engine_in_the_same_seat_is_refused() {
    let run = RunSpace::create().unwrap();
    let first = start("fluid", &run.to_environment(), "");
    let mut fluid = Partner::accept(Role::Fluid, &run, &LIMITS).unwrap();
    let (code, text) = end(
        start("fluid", &run.to_environment(), ""),
        Duration::from_secs(2),
    );
    assert_eq!(code, Some(3));
    assert!(
        text.contains(&format!("process {} has this seat", first.id())),
        "{text}"
    );
    fluid.finish().unwrap();
    assert_eq!(end(first, Duration::from_secs(2)).0, Some(0));
}

#[test]
fn an_engine_without_a_run_says_what_is_missing() {
    let (code, text) = end(start("fluid", &[], ""), Duration::from_secs(2));
    assert_eq!(code, Some(3));
    assert!(text.contains("SILLAGE_RUN"), "{text}");
    let gone = [("SILLAGE_RUN", "gone"), ("SILLAGE_ORCHESTRATOR", "1")]
        .map(|(k, v)| (k.to_owned(), v.to_owned()));
    let (code, text) = end(start("fluid", &gone, ""), Duration::from_secs(2));
    assert_eq!(code, Some(5), "{text}");
    wait_until_gone("gone");
}

#[test]
fn a_seat_that_will_stay_empty_ends_the_wait_for_hello() {
    let run = RunSpace::create().unwrap();
    let marker = run.clone();
    let thread = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(100));
        marker.mark_lost("fluid").unwrap();
    });
    let began = Instant::now();
    let error = Partner::accept(Role::Fluid, &run, &LIMITS).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the fluid is gone at step 0, while waiting for Hello"
    );
    assert!(began.elapsed() < Duration::from_secs(1));
    thread.join().unwrap();
}

#[test]
fn a_full_shared_memory_is_reported_with_exit_code_4() {
    let run = RunSpace::create().unwrap();
    let engine = start("fluid", &run.to_environment(), "");
    let fluid = Partner::accept(Role::Fluid, &run, &LIMITS).unwrap();
    signal(&engine, rustix::process::Signal::BUS);
    let (code, text) = end(engine, Duration::from_secs(2));
    assert_eq!(code, Some(4));
    assert!(text.contains("--shm-size"), "{text}");
    drop(fluid);
}

#[test]
fn a_process_that_is_told_to_end_leaves_nothing_even_when_alone() {
    let signals = [
        (rustix::process::Signal::INT, 130),
        (rustix::process::Signal::TERM, 143),
        (rustix::process::Signal::HUP, 129),
    ];
    for (told, code) in signals {
        // Started by hand: a name of its own, no orchestrator.
        let id = format!("hand{}s{code}", std::process::id());
        let engine = start("fluid", &[("SILLAGE_RUN".to_owned(), id.clone())], "");
        let began = Instant::now();
        while files_of(&id).len() < 20 {
            assert!(began.elapsed() < Duration::from_secs(10));
            std::thread::sleep(Duration::from_millis(5));
        }
        signal(&engine, told);
        assert_eq!(end(engine, Duration::from_secs(2)).0, Some(code));
        wait_until_gone(&id);
    }
}
