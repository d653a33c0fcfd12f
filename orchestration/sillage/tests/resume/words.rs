//! What is said of checkpoints, and what may change on the way.

use std::path::Path;

use crate::background::{report, root, sillage, small_cloud};
use crate::resume::same::{kept, resume, run};

fn scene() -> String {
    let path = root().join("scenes/one-grain.toml");
    path.to_string_lossy().into_owned()
}

fn short(folder: &Path) {
    run(&scene(), &["run.end_time=0.01".to_owned()], 4, folder);
}

#[test]
fn a_run_that_is_over_says_so_and_goes_on_when_it_is_extended() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("run");
    short(&folder);
    let (code, said, words) = resume(&folder, &[]);
    println!("{said}{words}");
    assert_eq!(code, Some(0));
    assert!(said.contains("has reached its end"), "{said}");
    let (code, said, words) = resume(&folder, &["--set", "run.end_time=0.02"]);
    println!("{said}{words}");
    assert_eq!(code, Some(0));
    let document = report(&folder);
    assert_eq!(document["steps"], 20);
    assert_eq!(document["resumed"][0]["step"], 10);
    assert_eq!(kept(&folder).last(), Some(&20));
    // … as a run of that length does where its steps are the same.
    let other = place.path().join("long");
    run(&scene(), &["run.end_time=0.02".to_owned()], 4, &other);
    let steps = |folder: &Path| {
        let text = std::fs::read_to_string(folder.join("steps.csv")).expect("steps");
        let centre = text.lines().next().expect("heads");
        let place = centre
            .split(',')
            .position(|head| head == "centre_y_mid")
            .expect("there");
        let value = |line: &str| line.split(',').nth(place)?.parse::<f64>().ok();
        text.lines().skip(1).filter_map(value).collect::<Vec<_>>()
    };
    // The steps before the first end were cut to meet it, by round-off here.
    let (ours, theirs) = (steps(&folder), steps(&other));
    assert_eq!((ours.len(), theirs.len()), (20, 20));
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12 * b.abs();
    assert!(ours.iter().zip(&theirs).all(near), "{ours:?} {theirs:?}");
}

#[test]
fn keys_that_would_change_the_past_are_refused_by_name() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("run");
    short(&folder);
    for (setting, word) in [
        ("fluid.density=900", "fluid.density"),
        ("run.coupling_step=1e-4", "run.coupling_step"),
        ("run.end_time=-1", "must be positive"),
        ("checkpoint.keep=x", "whole number"),
    ] {
        let (code, _, words) = resume(&folder, &["--set", setting]);
        println!("{words}");
        assert_eq!(code, Some(2), "{setting}");
        assert!(words.contains(word), "{words}");
    }
    let (code, _, words) = resume(&folder, &["--from", "3"]);
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(words.contains("there are: 4, 8, 10"), "{words}");
    // A scene that was changed by hand since.
    let path = folder.join("scene.json");
    let text = std::fs::read_to_string(&path).expect("read");
    let changed = text.replace("\"dynamic_viscosity\": ", "\"dynamic_viscosity\": 1");
    assert_ne!(text, changed);
    std::fs::write(&path, changed).expect("written");
    let (code, _, words) = resume(&folder, &["--set", "run.end_time=0.02"]);
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(words.contains("scene.json has changed since"), "{words}");
}

#[test]
fn a_run_that_has_not_reached_its_end_is_not_replaced_by_the_way() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("run");
    let out = folder.to_str().expect("UTF-8");
    let scene = scene();
    // A step that no scheme can make: the state before it is kept.
    let arguments = ["run", &scene, "--out", out, "--set", "run.end_time=0.01"];
    let hard = [
        "--set",
        "fluid.convection=true",
        "--set",
        "fluid.nonlinear={newton={tolerance=1e-30,iterations_max=1}}",
    ];
    let (code, _, words) = sillage(&[&arguments[..], &hard].concat());
    println!("{words}");
    assert_eq!(code, Some(8));
    assert!(words.contains("to go on from step"), "{words}");
    // The step that failed, all its tries.
    let dump = folder.join("failed-step.mcap");
    let dump = dump.to_str().expect("UTF-8");
    for seat in ["fluid", "particles"] {
        let (code, said, words) = sillage(&["replay", dump, "--as", seat]);
        println!("{said}{words}");
        assert_eq!(code, Some(0), "{seat}");
    }
    let (code, _, words) = sillage(&arguments);
    println!("{words}");
    assert_eq!(code, Some(2));
    assert!(words.contains("sillage resume"), "{words}");
    let (code, _, words) = sillage(&[&arguments[..], &["--replace"]].concat());
    assert_eq!(code, Some(0), "{words}");
}

#[test]
fn nothing_is_kept_where_that_is_wished_or_an_engine_cannot() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("run");
    run(
        &scene(),
        &["run.end_time=0.01", "checkpoint.keep=0"].map(str::to_owned),
        4,
        &folder,
    );
    assert!(kept(&folder).is_empty());
    let (code, said, _) = sillage(&["plan", &scene(), "--set", "checkpoint.keep=0"]);
    assert_eq!(code, Some(0));
    assert!(said.contains("the run cannot be resumed"), "{said}");
    let (_, said, _) = sillage(&["plan", &small_cloud(0.1)[0]]);
    assert!(said.contains("every 600 s and at its end"), "{said}");
}
