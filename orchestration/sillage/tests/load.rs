//! Much at once, large, often, long: `cargo test --release --workspace --test commands -- --include-ignored load
//! --nocapture --test-threads 1 --skip soak`, and `… -- --ignored soak --nocapture` for the long one: two hours, or
//! other seconds in `SILLAGE_TEST_SOAK`.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use run::{Runner, Voice};
use show::picture::pictures;

use crate::background::{
    Run, beside_programs, need_programs, report, root, shared_memory_of, sillage, small_cloud,
};
use crate::resume::same::assert_same;

const MEGABYTE: f64 = 1e6;

#[test]
fn eight_runs_side_by_side_are_each_as_one_alone() {
    let arguments = small_cloud(0.22);
    let alone = Run::start(&arguments).finish();
    assert_eq!(alone.0, Some(0), "{}", alone.1);
    let begun = Instant::now();
    let all: Vec<Run> = (0..8).map(|_| Run::start(&arguments)).collect();
    let ended: Vec<_> = all.into_iter().map(Run::finish).collect();
    println!("one alone {:.2?}, eight {:.2?}", alone.2, begun.elapsed());
    for (code, words, _, folder) in &ended {
        assert_eq!(*code, Some(0), "{words}");
        assert_same(alone.3.path(), folder.path());
    }
}

/// Grains that fall, a thousand in a row, a thousand rows: some touch the floor.
const MILLION: &str = r#"
[run]
end_time = 1e-2
coupling_step = 1e-3
[gravity]
acceleration = [0.0, -9.81]
[[grains]]
density = 2500.0
radius = 5e-5
lattice = { lower = [0.0, 0.0], upper = [0.12, 0.12], spacing = 1.2e-4 }
[particles.domain]
lower = [0.0, 0.0]
upper = [0.12, 0.2]
[contact]
tolerance = 1e-3
[output]
every = 1e-2
frames = false
"#;

/// Run a scene of a million grains: what it took \[s\], and what its states have \[MB\].
fn million(folder: &Path, settings: &[&str]) -> (f64, f64) {
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, MILLION).expect("written");
    let out = folder.join("run");
    let (scene, place) = (scene.to_string_lossy(), out.to_string_lossy());
    let mut arguments = vec!["run", &scene, "--replace", "--out", &place];
    arguments.extend(settings.iter().flat_map(|setting| ["--set", setting]));
    let begun = Instant::now();
    let (code, _, words) = sillage(&arguments);
    let seconds = begun.elapsed().as_secs_f64();
    assert_eq!(code, Some(0), "{words}");
    let report = report(&out);
    let states = std::fs::read_dir(out.join("vtu"))
        .expect("states")
        .flatten();
    let sizes = states.map(|entry| entry.metadata().map_or(0, |about| about.len()));
    let megabytes = sizes.sum::<u64>() as f64 / MEGABYTE;
    println!(
        "{settings:?}: {} steps, states of {megabytes:.0} MB in {seconds:.1} s",
        report["steps"]
    );
    println!("{}", report["cost"]);
    let number = |name: &str| report["totals"][name].as_f64().expect("a number");
    let checkpoint = number("seconds_checkpoints") / number("checkpoints");
    println!(
        "a step waits {checkpoint:.2} s for a checkpoint, {:.3} % of 600 s",
        checkpoint / 6.0
    );
    assert_eq!(report["scene"]["grains"], 1_000_000);
    assert_eq!(report["steps"], 10);
    (seconds, megabytes)
}

#[test]
#[ignore = "takes minutes and gigabytes"]
fn a_million_grains_take_ten_steps() {
    let folder = tempfile::tempdir().expect("a folder");
    million(folder.path(), &[]);
    // Where nobody computes, what is left is writing.
    let frozen = "engines.particles.command=[\"frozen-particles\"]";
    let few = million(folder.path(), &[frozen]);
    let many = million(folder.path(), &[frozen, "output.every=1e-3"]);
    let (seconds, megabytes) = (many.0 - few.0, many.1 - few.1);
    println!(
        "nine states more: {megabytes:.0} MB in {seconds:.1} s, {:.0} MB/s",
        megabytes / seconds
    );
}

/// What a process holds: open files, threads, memory \[MB\].
fn held(process: u32) -> [f64; 3] {
    let place = Path::new("/proc").join(process.to_string());
    let count = |name: &str| std::fs::read_dir(place.join(name)).map_or(0, Iterator::count) as f64;
    let status = std::fs::read_to_string(place.join("status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    let memory = kilobytes.unwrap_or(0.0) * 1024.0 / MEGABYTE;
    [count("fd"), count("task"), memory]
}

/// Names in shared memory that are of runs, and in the folder of temporary files.
fn left() -> [usize; 2] {
    let of_run = |name: &str| name.contains("sillage") || name.contains("iox");
    let count = |folder: &Path, all: bool| {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.filter(|name| all || of_run(name)).count()
    };
    [
        count(Path::new("/dev/shm"), false),
        count(&std::env::temp_dir(), true),
    ]
}

/// Where the runs of one process are to be, in that process.
const PLACE: &str = "SILLAGE_TEST_PLACE";
/// Of one process.
const MANY: usize = 10_000;
/// At the same time: a run of two steps mostly waits.
const LANES: usize = 4;
/// Between two looks.
const ROUND: usize = 500;

#[test]
#[ignore = "takes a quarter of an hour"]
fn ten_thousand_runs_of_one_process_leave_nothing() {
    if let Some(place) = std::env::var_os(PLACE) {
        return run_many(Path::new(&place));
    }
    let place = tempfile::tempdir().expect("a folder");
    let program = beside_programs(place.path());
    // Its own folder for what is temporary, where nobody else leaves anything.
    let temporary = place.path().join("temporary");
    std::fs::create_dir(&temporary).expect("made");
    let status = Command::new(program)
        .args([
            "--exact",
            "load::ten_thousand_runs_of_one_process_leave_nothing",
        ])
        .args(["--ignored", "--nocapture"])
        .env(PLACE, place.path())
        .env("TMPDIR", &temporary)
        .status();
    assert!(status.expect("started").success());
    let temporary = std::fs::read_dir(temporary).expect("a folder");
    assert_eq!(temporary.count(), 0);
}

fn run_many(place: &Path) {
    let settings = [
        "run.end_time=4e-3",
        "output.frames=false",
        "output.every=4e-3",
    ];
    let settings = settings.map(str::to_owned);
    let scene = scene::load(&root().join("scenes/dry-collapse.toml"), &settings, 1);
    let scene = scene.unwrap_or_else(|error| panic!("{error}"));
    let runner = Runner::new(Voice::Quiet, pictures).expect("a runner");
    let run = &|lane: usize, count: usize| {
        let folder = place.join(format!("run-{lane}"));
        for _ in 0..count {
            let outcome = runner.run(&scene, &folder);
            let ending = outcome.unwrap_or_else(|error| panic!("{error}")).ending;
            assert_eq!(ending.code, 0, "{:?}", ending.why);
            std::fs::remove_dir_all(&folder).expect("removed");
        }
    };
    let (mut first, mut settled) = (None, None);
    println!("  runs  files  threads  memory [MB]  shared memory  temporary");
    for number in (ROUND..=MANY).step_by(ROUND) {
        std::thread::scope(|scope| {
            let lanes = (0..LANES).map(|lane| scope.spawn(move || run(lane, ROUND / LANES)));
            // Joined one by one: a scope alone waits for the work, not for the threads to be gone.
            let lanes: Vec<_> = lanes.collect();
            lanes
                .into_iter()
                .for_each(|lane| lane.join().expect("no panic"));
        });
        let ([files, threads, memory], [shared, temporary]) = (held(std::process::id()), left());
        println!("{number:>6} {files:>6} {threads:>8} {memory:>12.1} {shared:>14} {temporary:>10}");
        assert_eq!(*first.get_or_insert([files, threads]), [files, threads]);
        assert_eq!(temporary, 0);
        // Threads come and go: the allocator has its arenas only after many.
        if number > MANY / 10 {
            let most = *settled.get_or_insert(memory);
            assert!(memory < 1.1 * most, "{memory} MB, {most} MB after a tenth");
        }
    }
}

/// How long the soak is.
const SOAK: f64 = 7200.0;

#[test]
#[ignore = "takes two hours"]
fn soak_of_a_bed_that_is_kept_fluidised_holds_the_same_memory() {
    need_programs();
    let seconds = std::env::var("SILLAGE_TEST_SOAK")
        .ok()
        .and_then(|text| text.parse().ok());
    let soak = Duration::from_secs_f64(seconds.unwrap_or(SOAK));
    let mut arguments = vec![
        root()
            .join("scenes/fluidised-bed.toml")
            .to_string_lossy()
            .into_owned(),
    ];
    for setting in ["run.end_time=1e4", "output.every=5", "output.frames=false"] {
        arguments.extend(["--set".to_owned(), setting.to_owned()]);
    }
    let mut run = Run::start(&arguments);
    run.wait_for_steps(20);
    // Hours of progress are more than a pipe holds: read, so that the last words are heard.
    let words = run.child.stderr.take().map(|mut stderr| {
        std::thread::spawn(move || {
            let mut text = String::new();
            stderr.read_to_string(&mut text).map(|_| text)
        })
    });
    let (children, identity) = run.children();
    let mut processes: BTreeMap<String, u32> = children
        .into_iter()
        .map(|(name, process)| (name, process as u32))
        .collect();
    processes.insert("sillage".to_owned(), run.child.id());
    let (begun, mut samples) = (Instant::now(), Vec::new());
    while begun.elapsed() < soak {
        std::thread::sleep((soak / 120).min(Duration::from_secs(60)));
        let now: BTreeMap<&str, [f64; 3]> = processes
            .iter()
            .map(|(name, process)| (name.as_str(), held(*process)))
            .collect();
        samples.push((now, shared_memory_of(&identity).len()));
    }
    let rows = run.rows();
    kill(Pid::from_raw(run.child.id() as i32), Signal::SIGINT).expect("told to stop");
    let (code, _, _, folder) = run.finish();
    let words = words
        .and_then(|reader| reader.join().ok()?.ok())
        .unwrap_or_default();
    println!("{rows} steps, {} segments; exit {code:?}", samples[0].1);
    assert_eq!(code, Some(130), "{words}");
    println!("process            memory [MB] after a quarter, at the end   files   threads");
    let quarter = samples.len() / 4;
    for name in processes.keys() {
        let of = |sample: &(BTreeMap<&str, [f64; 3]>, usize)| sample.0[name.as_str()];
        let largest = |from: &[_]| from.iter().map(of).map(|held| held[2]).fold(0.0, f64::max);
        let (early, late) = (
            largest(&samples[..=quarter]),
            largest(&samples[3 * quarter..]),
        );
        let ([files, threads, _], last) = (of(&samples[quarter]), of(&samples[samples.len() - 1]));
        println!("{name:<18} {early:>25.1} {late:>12.1} {files:>7} {threads:>9}");
        assert!(late < 1.02 * early + 4.0, "{name} grew");
        assert_eq!([files, threads], [last[0], last[1]], "{name}");
    }
    assert_eq!(samples[quarter].1, samples[samples.len() - 1].1);
    assert!(shared_memory_of(&identity).is_empty());
    let table = std::fs::read_to_string(folder.path().join("steps.csv")).expect("steps.csv");
    assert_eq!(report(folder.path())["steps"], table.lines().count() - 1);
}
