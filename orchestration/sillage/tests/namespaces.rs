//! What this machine looks like from elsewhere: another pid namespace, another user, a small shared
//! memory. Each needs a right that not every machine gives its tests; without it, it says so.

use std::path::Path;
use std::process::{Command, Output};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::background::{Run, is_alive, need_programs, programs, shared_memory_of, small_cloud};

/// Does this work here? Says so where not.
fn possible(command: &[&str]) -> bool {
    let output = Command::new(command[0]).args(&command[1..]).output();
    let possible = output.is_ok_and(|output| output.status.success());
    if !possible {
        println!("skipped: {} is not possible here", command.join(" "));
    }
    possible
}

/// The program, started by another one.
fn through(command: &[&str], arguments: &[&str]) -> Output {
    Command::new(command[0])
        .args(&command[1..])
        .arg(programs().join("sillage"))
        .args(arguments)
        .output()
        .expect("started")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn doctor_in_another_pid_namespace_removes_dead_runs_and_no_living_one() {
    const ELSEWHERE: [&str; 4] = ["unshare", "--pid", "--fork", "--mount-proc"];
    if !possible(&[&ELSEWHERE[..], &["true"]].concat()) {
        return;
    }
    let mut living = Run::start(&small_cloud(100.0));
    living.wait_for_steps(2);
    let mut dead = Run::start(&small_cloud(100.0));
    dead.wait_for_steps(2);
    let (_, id) = living.children();
    let (children, gone) = dead.children();
    // Stopped first: nobody is left to remove anything.
    for &pid in children.values() {
        kill(Pid::from_raw(pid), Signal::SIGSTOP).expect("stopped");
    }
    dead.child.kill().expect("killed");
    for &pid in children.values() {
        kill(Pid::from_raw(pid), Signal::SIGKILL).expect("killed");
    }
    dead.finish();
    while children.values().any(|&pid| is_alive(pid)) {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let before = living.rows();
    let words = text(&through(&ELSEWHERE, &["doctor", "--clean"]));
    println!("{words}");
    assert!(!words.contains(&id), "{words}");
    assert!(shared_memory_of(&id).len() > 100);
    assert_eq!(shared_memory_of(&gone), Vec::<String>::new());
    living.wait_for_steps(before + 5);
    kill(Pid::from_raw(living.child.id() as i32), Signal::SIGINT).expect("told");
    let (code, words, ..) = living.finish();
    assert_eq!(code, Some(130), "{words}");
}

/// Where another user can start it: a copy of the program alone.
fn copied(folder: &Path) -> String {
    use std::os::unix::fs::PermissionsExt;
    let copy = folder.join("sillage");
    std::fs::copy(programs().join("sillage"), &copy).expect("copied");
    let open = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(folder, open).expect("open");
    copy.to_string_lossy().into_owned()
}

#[test]
fn another_user_sees_that_there_is_a_run_and_can_neither_hang_nor_remove_it() {
    const NOBODY: [&str; 4] = [
        "setpriv",
        "--reuid=65534",
        "--regid=65534",
        "--clear-groups",
    ];
    if !possible(&[&NOBODY[..], &["true"]].concat()) {
        return;
    }
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let program = copied(folder.path());
    let mut run = Run::start(&small_cloud(100.0));
    run.wait_for_steps(2);
    let (_, id) = run.children();
    let as_nobody = |command: &[&str]| {
        let output = Command::new(NOBODY[0])
            .args(&NOBODY[1..])
            .args(command)
            .output();
        text(&output.expect("started"))
    };
    let words = as_nobody(&[&program, "doctor", "--clean"]);
    println!("{words}");
    assert!(words.contains(&format!("{id} of user 0")), "{words}");
    assert!(words.contains("only that user"), "{words}");
    let lock = format!("/dev/shm/sillage-{id}/lock");
    let words = as_nobody(&["flock", &lock, "sleep", "5"]);
    assert!(words.contains("Permission denied"), "{words}");
    for segment in shared_memory_of(&id) {
        let words = as_nobody(&["cat", &segment]);
        assert!(words.contains("Permission denied"), "{segment}: {words}");
    }
    kill(Pid::from_raw(run.child.id() as i32), Signal::SIGINT).expect("told");
    assert_eq!(run.finish().0, Some(130));
}

/// A run of a few steps where shared memory has this many bytes, of which so many are free.
fn in_small_memory(size: u64, free: u64) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let script = format!(
        "mount -t tmpfs -o size={size} none /dev/shm && head -c {} /dev/zero > /dev/shm/full && \
         \"$0\" \"$@\"; code=$?; rm -f /dev/shm/full; ls -A /dev/shm; exit $code",
        size - free
    );
    let mut arguments = small_cloud(0.055);
    arguments.extend(["--set".to_owned(), "output.frames=false".to_owned()]);
    let output = Command::new("unshare")
        .args(["-m", "sh", "-c", &script])
        .arg(programs().join("sillage"))
        .arg("run")
        .args(arguments)
        .arg("--out")
        .arg(folder.path().join("run"))
        .output()
        .expect("started");
    (output.status.code(), text(&output))
}

#[test]
fn a_run_in_a_shared_memory_that_is_nearly_full_says_so() {
    if !possible(&["unshare", "-m", "mount", "-t", "tmpfs", "none", "/dev/shm"]) {
        return;
    }
    need_programs();
    const MIB: u64 = 1 << 20;
    let nearly_full = [0, 32, 64, 128].map(|kib| kib << 10);
    // Room for the first messages, and not for all that comes.
    let short = (16..48).map(|quarter| quarter * MIB / 4);
    println!("free KiB | exit code | last words");
    let mut enough = 0;
    for free in nearly_full.into_iter().chain(short) {
        let (code, words) = in_small_memory(16 * MIB, free);
        let last = words.lines().next_back().unwrap_or_default();
        println!("{:8} | {code:?} | {last}", free / 1024);
        enough += u32::from(code == Some(0));
        if code != Some(0) {
            assert_eq!(code, Some(4), "{words}");
            let named = words.contains("shared memory") && words.contains("--shm-size");
            assert!(named, "{words}");
        }
        assert!(!words.contains("sillage-"), "left behind: {words}");
        assert!(free > MIB || code != Some(0));
    }
    assert!(enough > 0, "no run had enough");
}

#[test]
fn too_few_open_files_are_said_and_end_no_process_without_a_word() {
    need_programs();
    let engine = programs().join("sillage-fluid");
    let run = format!("few{}", std::process::id());
    println!("files | exit code | last words");
    for files in (4..36).chain([40, 60, 80, 100, 120, 511]) {
        let script = format!("ulimit -n {files}; exec \"$0\"");
        let output = Command::new("sh")
            .args(["-c", &script])
            .arg(&engine)
            .env("SILLAGE_RUN", &run)
            .env("SILLAGE_CONNECT_LIMIT", "0.2")
            .env("RUST_BACKTRACE", "0")
            .output()
            .expect("started");
        let words = text(&output);
        let last = words.lines().next_back().unwrap_or_default();
        println!("{files:5} | {:?} | {last}", output.status.code());
        let silent = output.status.code() == Some(6);
        assert!(
            silent || output.status.code() == Some(4),
            "{files}: {words}"
        );
        assert!(silent || words.contains("files"), "{files}: {words}");
    }
    // One that could not even open the lock again left its folder: the next run removes it.
    drop(protocol::runspace::RunSpace::create().expect("another run"));
    assert_eq!(shared_memory_of(&run), Vec::<String>::new());
}
