//! Every scene with everything forced on (`run.leave_out = false`) and with what the run chooses by
//! itself: the same result, and what was saved.

use std::collections::BTreeMap;
use std::path::Path;

use crate::background::{Run, report, root};

/// Part of the answer that leaving convection out may change (fluid-solver/src/equations/creeping.rs).
const BOUND: f64 = 1e-3;

/// What makes a scene small: coarse meshes, fewer grains, some steps.
fn small(name: &str) -> (u64, &'static [&'static str]) {
    match name {
        "cavity" => (10, &["fluid.domain.rectangle.cells=[16, 16]"]),
        "cloud" => (
            8,
            &[
                "fluid.refinement.near_grains=1.236e-3",
                "grains[0].radius=1e-4",
            ],
        ),
        "cloud-uniform" | "cloud-12um" => (
            8,
            &[
                "fluid.domain.rectangle.cells=[20, 60]",
                "grains[0].radius=1e-4",
            ],
        ),
        "cloud-pair" => (
            8,
            &[
                "fluid.domain.rectangle.cells=[24, 60]",
                "grains[0].radius=1e-4",
                "grains[1].radius=1e-4",
            ],
        ),
        "cylinder" => (2, &[]),
        "dry-collapse" => (40, &[]),
        "migflow-drop" => (8, &["fluid.domain.rectangle.cells=[20, 30]"]),
        "rayleigh-taylor" => (10, &["fluid.domain.rectangle.cells=[20, 40]"]),
        "one-grain" | "settling-column" => (60, &[]),
        _ => (10, &[]),
    }
}

/// A finished run.
struct Done {
    report: serde_json::Value,
    steps: BTreeMap<String, Vec<f64>>,
    files: BTreeMap<String, Vec<u8>>,
    log: String,
}

fn run(path: &Path, settings: &[String]) -> Done {
    let mut arguments = vec![path.to_string_lossy().into_owned()];
    for setting in settings {
        arguments.extend(["--set".to_owned(), setting.clone()]);
    }
    let (code, words, _, folder) = Run::start(&arguments).finish();
    assert_eq!(code, Some(0), "{}: {words}", path.display());
    let text = std::fs::read_to_string(folder.path().join("steps.csv")).expect("steps");
    let mut rows = text.lines();
    let names: Vec<&str> = rows.next().expect("names").split(',').collect();
    let mut steps: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for row in rows {
        for (name, value) in names.iter().zip(row.split(',')) {
            let column = steps.entry((*name).to_owned()).or_default();
            column.push(value.parse().expect("a number"));
        }
    }
    let entries = std::fs::read_dir(folder.path().join("vtu")).expect("states");
    let files = entries.map(|entry| {
        let path = entry.expect("an entry").path();
        let name = path
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        (name, std::fs::read(&path).expect("a state"))
    });
    let log = |seat: &str| {
        std::fs::read_to_string(folder.path().join(format!("logs/{seat}.log"))).unwrap_or_default()
    };
    Done {
        report: report(folder.path()),
        steps,
        files: files.collect(),
        log: log("fluid") + &log("particles"),
    }
}

/// Numbers of a step that belong to how it was computed.
fn is_effort(name: &str) -> bool {
    ["wall", "cpu_", "reynolds", "convection"]
        .iter()
        .any(|part| name.starts_with(part))
        || matches!(name, "contact_searches" | "contact_wall_looks")
}

/// Numbers that are compared by size, each beside those of its kind; the rest is round-off.
fn kind(name: &str) -> Option<&'static str> {
    match name {
        "centre_x" | "centre_y" | "front" | "rear" | "width" | "width98" => Some("position"),
        "fall_speed" | "fluid_speed_max" => Some("speed"),
        "pressure_drop" => Some("pressure"),
        "porosity_min" => Some("porosity"),
        _ if name.starts_with("force_") => Some("force"),
        _ => None,
    }
}

/// Largest difference of the steps, each number over the largest of its kind.
fn difference(forced: &Done, chosen: &Done) -> f64 {
    let mut sizes: BTreeMap<&str, f64> = BTreeMap::new();
    for (name, column) in &forced.steps {
        if let Some(kind) = kind(name) {
            let size = sizes.entry(kind).or_insert(f64::MIN_POSITIVE);
            *size = column.iter().fold(*size, |size, x| size.max(x.abs()));
        }
    }
    let mut worst: f64 = 0.0;
    for (name, column) in &forced.steps {
        let Some(kind) = kind(name) else { continue };
        for (a, b) in column.iter().zip(&chosen.steps[name]) {
            worst = worst.max((a - b).abs() / sizes[kind]);
        }
    }
    worst
}

/// The same bits: every number of a step that is no effort, and every state written.
fn assert_same_bits(name: &str, forced: &Done, chosen: &Done) {
    for (column, values) in &forced.steps {
        if !is_effort(column) {
            assert_eq!(values, &chosen.steps[column], "{name}: {column}");
        }
    }
    let names = |done: &Done| done.files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(forced), names(chosen));
    for (file, bytes) in &forced.files {
        assert!(*bytes == chosen.files[file], "{name}: {file}");
    }
}

fn cpu(done: &Done, seat: &str) -> f64 {
    done.report["cost"][format!("cpu_{seat}")]
        .as_f64()
        .unwrap_or(0.0)
}

/// One row of the table; asserts that both runs agree.
fn compare(path: &Path, steps: u64, settings: &[&str]) {
    let name = path
        .file_stem()
        .expect("a name")
        .to_string_lossy()
        .into_owned();
    let scene = scene::load(path, &[], 1).expect("a valid scene");
    let end = steps as f64 * scene.coupler.coupling_step;
    let mut settings: Vec<String> = settings.iter().map(|text| (*text).to_owned()).collect();
    settings.extend([
        format!("run.end_time={end:e}"),
        format!("output.every={end:e}"),
        "output.frames=false".to_owned(),
    ]);
    let chosen = run(path, &settings);
    settings.push("run.leave_out=false".to_owned());
    let forced = run(path, &settings);
    let creeping = chosen.steps.get("convection").map_or(0, |column| {
        column.iter().filter(|&&there| there == 0.0).count()
    });
    let difference = difference(&forced, &chosen);
    if creeping == 0 {
        assert_same_bits(&name, &forced, &chosen);
    }
    let sum = |done: &Done, column: &str| -> f64 {
        done.steps
            .get(column)
            .map_or(0.0, |values| values.iter().sum())
    };
    let both = |of: &dyn Fn(&Done) -> f64, digits: usize| {
        format!("{:.digits$} → {:.digits$}", of(&forced), of(&chosen))
    };
    println!(
        "| {name} | {steps} | {creeping} | {} | {} | {} | {} | {} | {} |",
        both(&|done| sum(done, "contact_searches"), 0),
        both(&|done| sum(done, "contact_wall_looks"), 0),
        both(&|done| 1e3 * cpu(done, "fluid"), 0),
        both(&|done| 1e3 * cpu(done, "particles"), 1),
        both(&|done| 1e3 * sum(done, "wall_exchange"), 1),
        if creeping == 0 {
            "same bits".to_owned()
        } else {
            format!("{difference:.1e}")
        },
    );
    assert!(difference <= BOUND, "{name}: {difference:e}");
}

fn compare_all(size: impl Fn(&str) -> (u64, &'static [&'static str])) {
    println!(
        "| scene | steps | without convection | searches for contacts | looks at walls | \
         CPU fluid (ms) | CPU grains (ms) | exchange (ms) | difference |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut paths: Vec<_> = std::fs::read_dir(root().join("scenes"))
        .expect("scenes")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .collect();
    paths.sort();
    for path in paths {
        let (steps, settings) = size(&path.file_stem().expect("a name").to_string_lossy());
        compare(&path, steps, settings);
    }
}

#[test]
fn every_scene_gives_the_same_result_with_everything_forced_on() {
    compare_all(small);
}

/// The table of docs/leaving-out.md: the scenes as they are, some of their first steps.
#[test]
#[ignore = "two minutes"]
fn every_scene_as_it_is_gives_the_same_result_with_everything_forced_on() {
    compare_all(|name| {
        let steps = match name {
            "cylinder" | "cloud-12um" => 5,
            "one-grain" | "settling-column" | "dry-collapse" => 200,
            _ => 20,
        };
        (steps, &[])
    });
}

#[test]
fn grains_that_are_all_fixed_need_no_particle_process() {
    let path = root().join("scenes/fixed-bed.toml");
    // convection there in both: what is left is to the bit
    let settings = ["fluid.convection=true", "output.frames=false"].map(str::to_owned);
    let chosen = run(&path, &settings);
    let forced = run(
        &path,
        &[&settings[..], &["run.leave_out=false".to_owned()]].concat(),
    );
    let processes = |done: &Done| -> Vec<String> {
        let used = done.report["cost"]["cpu_process"].as_object();
        used.expect("CPU of every process")
            .keys()
            .cloned()
            .collect()
    };
    println!("{:?} → {:?}", processes(&forced), processes(&chosen));
    assert_eq!(processes(&forced), ["coupler", "fluid", "particles"]);
    assert_eq!(processes(&chosen), ["coupler", "fluid"]);
    for (column, values) in &chosen.steps {
        if !is_effort(column) {
            assert_eq!(values, &forced.steps[column], "{column}");
        }
    }
    assert_eq!(chosen.files, forced.files);
}

/// When was this part first there, and how many steps did without it?
fn left_out(done: &Done, part: &str) -> (Option<u64>, u64) {
    let parts = done.report["left_out"].as_array().expect("a list");
    let found = parts.iter().find(|entry| entry["part"] == part);
    let entry = found.unwrap_or_else(|| panic!("{part} is not in {parts:?}"));
    (
        entry["first_step_with"].as_u64(),
        entry["steps_without"].as_u64().expect("a number"),
    )
}

#[test]
fn convection_comes_back_when_the_flow_has_grown_and_the_run_says_in_which_step() {
    let path = root().join("scenes/rayleigh-taylor.toml");
    let settings = [
        "fluid.domain.rectangle.cells=[20, 40]",
        "fluid.dynamic_viscosity=0.24",
        "run.end_time=0.05",
    ];
    let done = run(&path, &settings.map(str::to_owned));
    let (numbers, there) = (&done.steps["reynolds"], &done.steps["convection"]);
    for (step, (reynolds, there)) in numbers.iter().zip(there).enumerate() {
        println!(
            "step {:>2}: Re {reynolds:.2e}, convection {there}",
            step + 1
        );
    }
    let (first, without) = left_out(&done, "convection");
    assert!(first.is_some_and(|first| first > 2), "{first:?}");
    assert_eq!(Some(without + 1), first, "it stays");
    assert!(
        done.log.contains("convection is there from now on"),
        "{}",
        done.log
    );
}

#[test]
fn contacts_come_back_when_grains_begin_to_meet_and_the_run_says_in_which_step() {
    // Apart at first: a loose lattice falls on the floor.
    let path = root().join("scenes/dry-collapse.toml");
    let settings = [
        "grains[0].lattice.lower=[0.0, 0.02]",
        "grains[0].lattice.spacing=0.03",
        "run.end_time=0.1",
    ];
    let done = run(&path, &settings.map(str::to_owned));
    let first_contact = done.steps["contacts"].iter().position(|&n| n > 0.0);
    let (first, without) = left_out(&done, "contacts");
    println!(
        "near enough in step {first:?} after {without} steps without, first contact after {first_contact:?}"
    );
    let (first, first_contact) = (
        first.expect("they meet"),
        first_contact.expect("they touch"),
    );
    assert!(first > 2 && first <= first_contact as u64 + 1);
    assert!(done.log.contains("near enough to meet"), "{}", done.log);
}
