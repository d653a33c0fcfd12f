//! What an engine's script starts ends with the run, also what has a session of its own.

use std::path::Path;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::background::{Run, is_alive, programs, shared_memory_of, small_cloud};

const LEAVING_MAX: Duration = Duration::from_secs(2);

/// A run whose particle engine is a script that starts more than the engine.
fn with_script(folder: &Path, ending: &str) -> Vec<String> {
    use std::os::unix::fs::PermissionsExt;
    let script = folder.join("engine.sh");
    let engine = programs().join("sillage-particles");
    let said = folder.join("pids");
    let text = format!(
        "#!/bin/sh\nsetsid sleep 1000 &\n(setsid sh -c 'sleep 1001; true' &)\nsleep 1002 &\n\
         sleep 0.2\npgrep -f '^sleep 100[012]$' -s 0,$$ > /dev/null\necho started > {}\n{ending} {}\n",
        said.display(),
        engine.display()
    );
    std::fs::write(&script, text).expect("written");
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).expect("program");
    let mut arguments = small_cloud(100.0);
    for setting in [
        format!("engines.particles.command=[\"{}\"]", script.display()),
        "output.frames=false".to_owned(),
    ] {
        arguments.extend(["--set".to_owned(), setting]);
    }
    arguments
}

/// Processes whose environment names this run.
fn of_run(id: &str) -> Vec<i32> {
    let wanted = format!("SILLAGE_RUN={id}");
    let entries = std::fs::read_dir("/proc").expect("/proc").flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    let named = |pid: &i32| {
        let environment = std::fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
        let mut variables = environment.split(|&byte| byte == 0);
        variables.any(|variable| variable == wanted.as_bytes())
    };
    pids.filter(|pid| named(pid) && is_alive(*pid)).collect()
}

fn none_left(id: &str, begun: Instant) {
    while !of_run(id).is_empty() && begun.elapsed() < 5 * LEAVING_MAX {
        std::thread::sleep(Duration::from_millis(10));
    }
    println!("nobody is left {:.2?} after the end", begun.elapsed());
    assert!(begun.elapsed() < LEAVING_MAX, "{:?}", of_run(id));
    assert_eq!(shared_memory_of(id), Vec::<String>::new());
}

#[test]
fn nothing_that_a_script_started_is_left_after_the_end() {
    for ending in ["exec", ""] {
        for signal in [Signal::SIGINT, Signal::SIGKILL] {
            let folder = tempfile::tempdir().expect("a folder");
            let mut run = Run::start(&with_script(folder.path(), ending));
            run.wait_for_steps(3);
            let (_, id) = run.children();
            let there = of_run(&id);
            println!("`{ending}`, {signal}: {} processes", there.len());
            assert!(there.len() >= 6, "{there:?}");
            let begun = Instant::now();
            kill(Pid::from_raw(run.child.id() as i32), signal).expect("signalled");
            run.child.wait().expect("ended");
            let begun = match signal {
                Signal::SIGKILL => begun,
                _ => Instant::now(),
            };
            none_left(&id, begun);
        }
    }
}
