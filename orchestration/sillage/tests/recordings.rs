//! Recordings made by real processes: the run is not touched, a killed run leaves a file that can be
//! used, and `replay` and `diff` tell sameness from difference by their exit codes.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;

use crate::background::{
    LEAVING_MAX, Run, is_alive, need_programs, programs, report, root, shared_memory_of,
    small_cloud,
};
use crate::schema;

fn sillage(arguments: &[&str]) -> Output {
    need_programs();
    schema::of_command(Path::new("."), arguments);
    Command::new(env!("CARGO_BIN_EXE_sillage"))
        .args(arguments)
        .output()
        .expect("started")
}

/// Exit code, standard output, standard error; printed.
fn told(arguments: &[&str]) -> (i32, String, String) {
    let output = sillage(arguments);
    let (out, err) = (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    );
    let code = output.status.code().expect("a code");
    println!("sillage {}: {code}\n{out}{err}", arguments.join(" "));
    (code, out, err)
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// A small cloud, run to the end; its folder.
fn recorded(end_time: f64, more: &[&str]) -> tempfile::TempDir {
    let mut arguments = small_cloud(end_time);
    arguments.extend(more.iter().map(|word| (*word).to_string()));
    let (code, words, _, folder) = Run::start(&arguments).finish();
    assert_eq!(code, Some(0), "{words}");
    folder
}

/// Content of the files of a folder, by name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    entries
        .map(|entry| {
            let content = std::fs::read(entry.path()).expect("content");
            (entry.file_name().to_string_lossy().into_owned(), content)
        })
        .collect()
}

#[test]
fn a_recorded_run_gives_the_same_bits_and_replays_without_difference() {
    let plain = recorded(0.11, &[]);
    let zstd = recorded(0.11, &["--record"]);
    let none = recorded(
        0.11,
        &["--record=all.mcap", "--set", "record.compression=none"],
    );
    let (plain, zstd, none) = (plain.path(), zstd.path(), none.path());
    println!("| compression | messages | bytes |");
    for (folder, file) in [(zstd, "exchange.mcap"), (none, "all.mcap")] {
        let recording = &report(folder)["recording"];
        println!(
            "| {} | {} | {} |",
            recording["compression"], recording["messages"], recording["bytes"]
        );
        assert_eq!(recording["complete"], true);
        assert_eq!(recording["file"], file);
        assert_eq!(files(&plain.join("vtu")), files(&folder.join("vtu")));
        let (code, out, _) = told(&["diff", text(plain), text(folder)]);
        assert_eq!(code, 0);
        assert!(out.contains("no recordings to compare"));
    }
    assert_eq!(report(plain)["recording"], Value::Null);
    let (code, out, _) = told(&["diff", text(zstd), text(none)]);
    assert_eq!(code, 0);
    assert!(out.contains("particles/grain_force") && out.contains("within the tolerance"));
    for seat in ["fluid", "particles"] {
        let recording = zstd.join("exchange.mcap");
        let (code, out, err) = told(&["replay", text(&recording), "--as", seat, "--json"]);
        assert_eq!(code, 0);
        assert!(!err.contains("warning"), "{err}");
        let document: Value = serde_json::from_str(&out).expect("one document");
        assert_eq!(document["ok"], true);
        assert_eq!(document["complete"], true);
        assert_eq!(document["steps"], 20);
        let fields = document["fields"].as_object().expect("fields");
        assert!(fields.len() >= 7);
        for (name, row) in fields {
            assert_eq!(row["unequal"], 0, "{name}");
            assert_eq!(row["max"], 0.0, "{name}");
        }
    }
    // The same by a command of one's own.
    let engine = programs().join("sillage-particles");
    let command = format!("'{}'", engine.display());
    let (code, ..) = told(&[
        "replay",
        text(zstd),
        "--as",
        "particles",
        "--engine",
        &command,
    ]);
    assert_eq!(code, 0);
}

#[test]
fn a_killed_run_leaves_a_recording_that_replays_up_to_its_last_whole_chunk() {
    let mut arguments = small_cloud(1000.0);
    arguments.push("--record".to_string());
    let mut run = Run::start(&arguments);
    run.wait_for_steps(5);
    // Chunks are written once a second.
    std::thread::sleep(Duration::from_millis(2500));
    let (children, _) = run.children();
    kill(Pid::from_raw(children["sillage-coupler"]), Signal::SIGKILL).expect("killed");
    let steps = run.rows();
    let (code, _, _, folder) = run.finish();
    assert_eq!(code, Some(5));
    assert_eq!(report(folder.path())["recording"]["complete"], false);
    let (code, out, err) = told(&["replay", text(folder.path()), "--as", "fluid", "--json"]);
    assert_eq!(code, 0);
    assert!(err.contains("it was cut"), "{err}");
    let document: Value = serde_json::from_str(&out).expect("one document");
    let replayed = document["steps"].as_u64().expect("steps");
    println!("{replayed} steps of {steps} replayed");
    assert_eq!(document["complete"], false);
    assert!(replayed > 5);
    assert!(document["fields"]["pressure_gradient"]["unequal"] == 0);
}

#[test]
fn a_full_disk_ends_the_recording_and_not_the_run_and_both_are_told() {
    need_programs();
    let plain = recorded(0.055, &[]);
    let folder = tempfile::tempdir().expect("a folder");
    let link = folder.path().join("exchange.mcap");
    std::os::unix::fs::symlink("/dev/full", &link).expect("a link");
    // A folder of ours: of a run that was killed at its start.
    let mark = "{ \"versions\": { \"sillage\": \"0\" } }";
    std::fs::write(folder.path().join("run.json"), mark).expect("written");
    let arguments = small_cloud(0.055);
    let mut words: Vec<&str> = vec!["run"];
    words.extend(arguments.iter().map(String::as_str));
    words.extend(["--record", "--out", text(folder.path())]);
    let (code, _, err) = told(&words);
    assert_eq!(code, 0);
    assert!(
        err.contains("the recording is not complete, the run goes on"),
        "{err}"
    );
    let recording = &report(folder.path())["recording"];
    println!("{recording:#}");
    assert_eq!(recording["complete"], false);
    let why = recording["why"].as_str().expect("a reason");
    assert!(why.contains("No space left on device"), "{why}");
    let (code, ..) = told(&["diff", text(plain.path()), text(folder.path())]);
    assert_eq!(code, 0);
}

#[test]
fn a_recording_of_a_mesh_replays_without_the_mesh_file() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    let mesh = here.join("own.msh");
    std::fs::copy(root().join("scenes/meshes/cylinder-coarse.msh"), &mesh).expect("copied");
    let scene = std::fs::read_to_string(root().join("scenes/cylinder.toml")).expect("a scene");
    let scene = scene.replace("meshes/cylinder.msh", "own.msh");
    let file = here.join("cylinder.toml");
    std::fs::write(&file, scene).expect("written");
    let out = here.join("run");
    let (code, ..) = told(&[
        "run",
        text(&file),
        "--set",
        "run.end_time=0.03",
        "--record",
        "--out",
        text(&out),
    ]);
    assert_eq!(code, 0);
    std::fs::remove_file(&mesh).expect("removed");
    let (code, out, _) = told(&["replay", text(&out), "--as", "fluid"]);
    assert_eq!(code, 0);
    assert!(out.contains("3 steps, 3 answers, within the tolerance"));
}

#[test]
fn an_interrupted_replay_leaves_nothing_behind() {
    let folder = recorded(2.0, &["--record"]);
    let child = Command::new(env!("CARGO_BIN_EXE_sillage"))
        .args(["replay", text(folder.path()), "--as", "fluid"])
        .env("TMPDIR", folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let run = Run { child, folder };
    // What it needs lies in the private folder of its run.
    let replays = |id: &str| Path::new(&format!("/dev/shm/sillage-{id}/replay")).exists();
    let (mut children, mut id) = run.children();
    while children.is_empty() || id.is_empty() || !replays(&id) {
        std::thread::sleep(Duration::from_millis(5));
        (children, id) = run.children();
    }
    std::thread::sleep(Duration::from_millis(200));
    kill(Pid::from_raw(run.child.id() as i32), Signal::SIGINT).expect("signalled");
    let (code, words, _, folder) = run.finish();
    println!("{code:?}: {words}");
    assert_eq!(code, Some(130));
    let begun = Instant::now();
    while !shared_memory_of(&id).is_empty() || children.values().any(|&pid| is_alive(pid)) {
        assert!(begun.elapsed() < LEAVING_MAX, "{:?}", shared_memory_of(&id));
        std::thread::sleep(Duration::from_millis(20));
    }
    let left = files_in(folder.path());
    assert!(
        left.iter().all(|name| !name.starts_with("sillage-")),
        "{left:?}"
    );
}

fn files_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
}

/// Copy a recording; the pressure gradient of step 2 is changed at node 7 by this share of the
/// largest.
fn changed(from: &Path, to: &Path, share: f64) {
    let bytes = std::fs::read(from).expect("bytes");
    let options = mcap::WriteOptions::new().profile("sillage");
    let file = std::fs::File::create(to).expect("a file");
    let mut writer = options.create(file).expect("a writer");
    for message in mcap::MessageStream::new(&bytes).expect("messages") {
        let mut message = message.expect("a message");
        if message.channel.topic == "fluid/pressure_gradient"
            && message.log_time / 1_000_000_000 == 2
        {
            let mut data = message.data.to_vec();
            let (numbers, _) = data[64..].as_chunks_mut::<8>();
            let largest = numbers
                .iter()
                .map(|number| f64::from_le_bytes(*number).abs())
                .fold(0.0, f64::max);
            numbers[14] = (f64::from_le_bytes(numbers[14]) + share * largest).to_le_bytes();
            let sum = crc32c::crc32c_append(crc32c::crc32c(&data[..56]), &data[60..]);
            data[56..60].copy_from_slice(&sum.to_le_bytes());
            message.data = data.into();
        }
        writer.write(&message).expect("written");
    }
    writer.finish().expect("finished");
}

#[test]
fn differences_are_told_with_their_place_and_exit_code_1_unless_they_are_tolerated() {
    let folder = recorded(0.022, &["--record"]);
    let sound = folder.path().join("exchange.mcap");
    let other = folder.path().join("other.mcap");
    changed(&sound, &other, 1e-6);
    for (tolerance, expected) in [("0", 1), ("1e-9", 1), ("1e-5", 0)] {
        let (code, out, _) = told(&[
            "replay",
            text(&other),
            "--as",
            "fluid",
            "--tolerance",
            tolerance,
        ]);
        assert_eq!(code, expected);
        assert!(out.contains("step 2 pass 1, number 7 component 0"), "{out}");
        let (code, out, _) = told(&["diff", text(&sound), text(&other), "--tolerance", tolerance]);
        assert_eq!(code, expected);
        assert!(out.contains("step 2 pass 1, number 7 component 0"), "{out}");
    }
    let (code, out, _) = told(&["replay", text(&other), "--as", "fluid", "--json"]);
    assert_eq!(code, 1);
    let document: Value = serde_json::from_str(&out).expect("one document");
    assert_eq!(document["ok"], false);
    assert_eq!(document["fields"]["pressure_gradient"]["place"]["index"], 7);
    assert_eq!(document["fields"]["pressure_gradient"]["unequal"], 1);
    // Other steps, other physics.
    let longer = recorded(0.033, &["--record"]);
    let (code, out, _) = told(&["diff", text(folder.path()), text(longer.path())]);
    assert_eq!(code, 1);
    assert!(out.contains("4 and 6 steps: OUTSIDE"), "{out}");
    assert!(out.contains("only in the second, from step 5"), "{out}");
    assert!(out.contains("scene.end_time: 0.022 and 0.033"), "{out}");
    let thick = recorded(
        0.022,
        &["--record", "--set", "fluid.dynamic_viscosity=0.13"],
    );
    let (code, out, _) = told(&["diff", text(folder.path()), text(thick.path()), "--json"]);
    assert_eq!(code, 1);
    let document: Value = serde_json::from_str(&out).expect("one document");
    assert_eq!(document["steps"]["columns"]["fall_speed"]["within"], false);
    assert_eq!(document["recordings"]["scenes_differ"], true);
}

#[test]
fn what_cannot_be_recorded_replayed_or_compared_is_refused_with_the_reason() {
    let folder = recorded(0.011, &["--record", "--set", "limits.connect=2.0"]);
    let here = text(folder.path());
    let scene = root().join("scenes/cloud.toml");
    let scene = text(&scene);
    let cavity = recorded_cavity();
    let cavity = text(cavity.path());
    let damaged = folder.path().join("damaged.mcap");
    let mut bytes = std::fs::read(folder.path().join("exchange.mcap")).expect("bytes");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&damaged, &bytes).expect("written");
    for (arguments, expected, words) in [
        (
            vec!["run", scene, "--record=notes.txt"],
            2,
            "must name a file that ends in .mcap",
        ),
        (
            vec!["run", scene, "--set", "record.file=run.json"],
            2,
            "record.file",
        ),
        (
            vec!["run", scene, "--set", "record.compression=lzma"],
            2,
            "(allowed: zstd, none)",
        ),
        (
            vec!["replay", scene, "--as", "fluid"],
            2,
            "is not a recording of Sillage: it is no MCAP file",
        ),
        (
            vec!["replay", "no/such.mcap"],
            2,
            "cannot read the recording no/such.mcap",
        ),
        (
            vec!["replay", cavity, "--as", "particles"],
            2,
            "has no particles: the scene does without",
        ),
        (
            vec!["replay", here, "--as", "fluid", "--engine", "false"],
            5,
            "fluid ended with exit code 1",
        ),
        (
            vec!["replay", here, "--as", "fluid", "--engine", " "],
            2,
            "--engine names no program",
        ),
        (
            vec!["replay", here, "--as", "fluid", "--engine", "sleep 30"],
            6,
            "did not send Hello within 2 s",
        ),
        (
            vec!["replay", text(&damaged), "--as", "fluid"],
            2,
            "is damaged",
        ),
        (vec!["diff", here, "no/such"], 2, "no/such does not exist"),
        (vec!["diff", text(&damaged), here], 2, "is damaged"),
        (
            vec!["diff", "/dev", "/dev"],
            2,
            "cannot read /dev/steps.csv",
        ),
        (
            vec!["replay", here, "--as", "fluid", "--tolerance=-1"],
            2,
            "must be a number, 0 or more",
        ),
    ] {
        let (code, out, err) = told(&arguments);
        assert_eq!(code, expected, "{arguments:?}");
        assert!(format!("{out}{err}").contains(words), "{arguments:?}");
    }
}

fn recorded_cavity() -> tempfile::TempDir {
    let arguments = [
        text(&root().join("scenes/cavity.toml")).to_string(),
        "--set".to_string(),
        "run.end_time=0.4".to_string(),
        "--set".to_string(),
        "fluid.domain.rectangle.cells=[8,8]".to_string(),
        "--record".to_string(),
    ];
    let (code, words, _, folder) = Run::start(&arguments).finish();
    assert_eq!(code, Some(0), "{words}");
    folder
}
