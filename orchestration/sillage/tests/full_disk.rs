//! A disk that stays full: a file system of its own, of two megabytes, and somebody else who takes what is left;
//! and a folder that is removed.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use run::folder::Ending;
use run::vtu::read::{self, State};
use run::{Runner, Voice};
use show::picture::pictures;

use crate::background::{beside_programs, report, small_cloud};

/// Where the file system is, in the process that runs on it.
const DISK: &str = "SILLAGE_TEST_DISK";
/// Told by the shell when nothing may be mounted.
const NOT_MOUNTED: i32 = 77;

#[test]
fn a_disk_that_stays_full_ends_the_run_with_all_that_is_written_whole() {
    if let Some(disk) = std::env::var_os(DISK) {
        fill(Path::new(&disk));
        return vanish(Path::new(&disk));
    }
    let place = tempfile::tempdir().expect("a folder");
    let disk = place.path().join("disk");
    std::fs::create_dir(&disk).expect("made");
    let program = beside_programs(place.path());
    let test = "full_disk::a_disk_that_stays_full_ends_the_run_with_all_that_is_written_whole";
    let script = format!(
        "mount -t tmpfs -o size=2m none \"$0\" || exit {NOT_MOUNTED}\n\
         exec \"$1\" --exact {test} --nocapture"
    );
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", &script])
        .args([&disk, &program])
        .env(DISK, &disk)
        .output();
    let Ok(output) = output else {
        return println!("not tried: there is no unshare");
    };
    let words = String::from_utf8_lossy(&output.stderr);
    println!("{}\n{words}", String::from_utf8_lossy(&output.stdout));
    if words.starts_with("unshare:") || output.status.code() == Some(NOT_MOUNTED) {
        return println!("not tried: nothing may be mounted here");
    }
    assert_eq!(output.status.code(), Some(0));
}

/// Run a cloud that puts out every step, in a folder on this disk, beside somebody: how it ends.
fn run_beside(disk: &Path, neighbour: fn(&Path, &AtomicBool)) -> Ending {
    let arguments = small_cloud(0.22);
    let settings = arguments[1..].iter().filter(|word| *word != "--set");
    let more = ["output.every=0.0055", "output.frames=false"].map(str::to_owned);
    let settings: Vec<String> = settings.cloned().chain(more).collect();
    let scene = scene::load(Path::new(&arguments[0]), &settings, 1);
    let scene = scene.unwrap_or_else(|error| panic!("{error}"));
    let runner = Runner::new(Voice::Aloud, pictures).expect("a runner");
    let runner = Runner {
        patience: Duration::from_millis(300),
        ..runner
    };
    let over = Arc::new(AtomicBool::new(false));
    let neighbour = std::thread::spawn({
        let (over, disk) = (Arc::clone(&over), disk.to_path_buf());
        move || neighbour(&disk, &over)
    });
    let outcome = runner.run(&scene, &disk.join("run"));
    over.store(true, Ordering::SeqCst);
    neighbour.join().expect("a neighbour");
    let ending = outcome.unwrap_or_else(|error| panic!("{error}")).ending;
    println!(
        "exit {}: {}",
        ending.code,
        ending.why.as_deref().unwrap_or_default()
    );
    ending
}

fn rows(disk: &Path) -> usize {
    let table = std::fs::read_to_string(disk.join("run/steps.csv")).unwrap_or_default();
    table.lines().count()
}

/// The folder goes while steps are computed: the run does not compute for nobody.
fn vanish(disk: &Path) {
    std::fs::remove_file(disk.join("neighbour")).expect("removed");
    std::fs::remove_dir_all(disk.join("run")).expect("removed");
    let ending = run_beside(disk, |disk, over| {
        while !over.load(Ordering::SeqCst) && rows(disk) <= 5 {
            std::thread::sleep(Duration::from_millis(1));
        }
        while std::fs::rename(disk.join("run"), disk.join("gone")).is_err() {}
    });
    let why = ending.why.unwrap_or_default();
    assert_eq!(ending.code, 4);
    assert!(
        why.contains("No such file") && why.contains("also after 0.3 s"),
        "{why}"
    );
    assert!(!disk.join("run").exists(), "made again");
}

/// The disk is full from the fifth step on.
fn fill(disk: &Path) {
    let folder = disk.join("run");
    let ending = run_beside(disk, take_the_rest);
    let why = ending.why.unwrap_or_default();
    assert_eq!(ending.code, 4);
    assert!(why.contains("No space left on device") && why.contains("also after 0.3 s"));

    let report = report(&folder);
    assert_eq!(report["exit"]["code"], 4);
    assert_eq!(report["exit"]["why"], why);
    let table = std::fs::read_to_string(folder.join("steps.csv")).expect("steps.csv");
    let rows: Vec<usize> = table.lines().map(|row| row.split(',').count()).collect();
    let steps = rows.len() - 1;
    println!("{steps} steps of 40 are written");
    assert!((2..40).contains(&steps) && table.ends_with('\n'));
    assert!(rows.iter().all(|count| *count == rows[0]));
    assert_eq!(report["steps"], steps);
    assert!(
        why.contains(&format!("complete to step {steps}, t = ")),
        "{why}"
    );
    states_are_whole(&folder, report["time_reached"].as_f64().expect("a time"));
}

/// From the fifth step on, every block of the disk that is free.
fn take_the_rest(disk: &Path, over: &AtomicBool) {
    let mut file = File::create(disk.join("neighbour")).expect("a file");
    let mut taken = 0;
    while !over.load(Ordering::SeqCst) {
        match rows(disk) > 5 {
            true => taken += file.write(&[7; 4096]).unwrap_or(0),
            false => std::thread::sleep(Duration::from_millis(1)),
        }
    }
    println!("the neighbour took {taken} bytes");
}

/// Every state that is listed is there, and nothing that is not; the last is of the last step, or of the one
/// before, whose own could not be written.
fn states_are_whole(folder: &Path, reached: f64) {
    let mut files: Vec<PathBuf> = Vec::new();
    for phase in ["fluid", "grains"] {
        let listed = read::list(&folder.join(format!("{phase}.pvd")));
        let listed = listed.unwrap_or_else(|error| panic!("{error}"));
        let (last, _) = listed.last().expect("a state");
        println!(
            "{phase}: {} states, the last of {last} s, {reached} s reached",
            listed.len()
        );
        assert!((0.0..0.006).contains(&(reached - last)));
        for (time, name) in listed {
            let file = folder.join(name);
            let text = std::fs::read_to_string(&file).expect("a state");
            assert!(text.ends_with("</VTKFile>\n"), "{}", file.display());
            let state = State::from_text(text);
            assert_eq!(state.numbers("TimeValue").expect("read"), Some(vec![time]));
            files.push(file);
        }
    }
    let states = std::fs::read_dir(folder.join("vtu"))
        .expect("states")
        .flatten();
    for entry in states {
        assert!(files.contains(&entry.path()), "{}", entry.path().display());
    }
    let left = std::fs::read_dir(folder).expect("a folder").flatten();
    for name in left.map(|entry| entry.file_name().to_string_lossy().into_owned()) {
        assert!(!name.ends_with(".part") && name != ".reserve", "{name}");
    }
}
