use std::fs::DirBuilder;
use std::os::unix::fs::DirBuilderExt;
use std::process::Command;

use protocol::runspace::{Leftover, RunSpace};

use crate::processes::wait_until_gone;

pub fn files_of(id: &str) -> Vec<String> {
    let files = protocol::runspace::files_of(id).into_iter();
    files.map(|path| path.display().to_string()).collect()
}

#[test]
fn nothing_is_left_after_a_run_space_is_dropped() {
    let runspace = RunSpace::create().unwrap();
    let id = runspace.id().to_owned();
    assert_eq!(files_of(&id).len(), 1);
    drop(runspace);
    assert!(files_of(&id).is_empty());
}

#[test]
fn run_spaces_have_different_names_and_hand_them_to_children() {
    let (a, b) = (RunSpace::create().unwrap(), RunSpace::create().unwrap());
    assert_ne!(a.id(), b.id());
    let pid = std::process::id().to_string();
    let environment = a.to_environment();
    let token = &environment[2].1;
    assert_eq!((a.id().len(), token.len()), (25, 25), "128 bits each");
    let expected = [
        ("SILLAGE_RUN", a.id()),
        ("SILLAGE_ORCHESTRATOR", &pid),
        ("SILLAGE_TOKEN", token),
    ];
    assert_ne!(*token, b.to_environment()[2].1);
    assert!(
        environment
            .iter()
            .map(|(k, v)| (k.as_str(), v.as_str()))
            .eq(expected)
    );
}

#[test]
fn names_that_are_no_names_are_refused() {
    for name in ["", "Upper", "a/b", "../x", "a_b", "12345678901234567"] {
        let error = RunSpace::named(name).unwrap_err();
        assert!(error.to_string().contains("1 to 16 characters"), "{error}");
    }
}

#[test]
fn too_little_shared_memory_is_said_with_the_remedy() {
    let error = RunSpace::named("space")
        .unwrap()
        .preflight(1 << 60)
        .unwrap_err();
    println!("{error}");
    assert!(error.to_string().contains("--shm-size"));
    assert_eq!(error.exit_code(), 4);
}

#[test]
fn leftovers_of_a_dead_run_are_found_and_swept_and_living_runs_are_not() {
    let living = RunSpace::create().unwrap();
    let dead = format!("dead{}", std::process::id());
    let root = format!("/dev/shm/sillage-{dead}");
    for folder in [root.clone(), format!("{root}/members")] {
        DirBuilder::new().mode(0o700).create(folder).unwrap();
    }
    std::fs::write(format!("{root}/lock"), "").unwrap();
    // This process id with another start time: a process that is long gone.
    std::fs::write(
        format!("{root}/members/orchestrator"),
        format!("{} 1\n", std::process::id()),
    )
    .unwrap();
    std::fs::write(format!("/dev/shm/sillage{dead}_segment"), [0; 5000]).unwrap();
    let leftovers = RunSpace::leftovers().unwrap();
    assert!(leftovers.iter().all(|left| left.id != living.id()));
    let left = leftovers
        .iter()
        .find(|left| left.id == dead)
        .expect("the dead run is listed");
    println!("{left:?}");
    assert_eq!(left.files, 3);
    assert!(left.bytes >= 5000);
    left.sweep().unwrap();
    wait_until_gone(&dead);
}

#[test]
fn a_process_that_is_removing_its_run_outlives_a_sweep_of_it() {
    let run = format!("goes{}", std::process::id());
    // As `leave` of the last process of a run puts it aside before it removes it.
    let aside = format!("/dev/shm/.sillage-{run}.aside");
    DirBuilder::new().mode(0o700).create(&aside).unwrap();
    let mut last = Command::new("sleep")
        .arg("60")
        .envs([("SILLAGE_RUN", run.as_str()), ("SILLAGE_ORCHESTRATOR", "1")])
        .spawn()
        .unwrap();
    let left = Leftover {
        id: run.clone(),
        files: 0,
        bytes: 0,
    };
    left.sweep().unwrap();
    wait_until_gone(&run);
    let ended = last.try_wait().unwrap();
    last.kill().unwrap();
    last.wait().unwrap();
    assert_eq!(ended, None);
}
