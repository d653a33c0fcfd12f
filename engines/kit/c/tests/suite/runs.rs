//! Engines in C in runs of real processes.

use crate::programs::{compile, kit, sillage, text};

#[test]
fn both_engines_in_c_make_a_run_whose_grains_move_as_the_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let [grains, stream] = ["examples/falling.c", "examples/stream.c"]
        .map(|source| compile(source, folder.path()).display().to_string());
    let scene = kit().join("../../prescribed-fluid/scene.toml");
    let run = folder.path().join("run");
    let output = sillage()
        .arg("run")
        .arg(&scene)
        .args([
            "--set",
            &format!("engines.particles.command=[\"{grains}\"]"),
        ])
        .args([
            "--set",
            &format!("engines.fluid.command=[\"{stream}\", \"0.01\", \"0.002\"]"),
        ])
        .args([
            "--set",
            "grains[0].density=1000.0",
            "--set",
            "grains[1].density=1000.0",
        ])
        .args([
            "--set",
            "run.end_time=0.2",
            "--set",
            "output.frames=false",
            "--out",
        ])
        .arg(&run)
        .output()
        .expect("started");
    assert!(output.status.success(), "{}", text(&output));
    let report = std::fs::read_to_string(run.join("run.json")).expect("run.json");
    assert!(report.contains("falling-c") && report.contains("stream-c"));
    let steps = std::fs::read_to_string(run.join("steps.csv")).expect("steps.csv");
    let column = |line: &str| -> f64 {
        let header = steps.lines().next().expect("a header");
        let place = header
            .split(',')
            .position(|name| name == "fall_speed")
            .expect("a column");
        line.split(',')
            .nth(place)
            .expect("a value")
            .parse()
            .expect("a number")
    };
    let rise = -column(steps.lines().last().expect("a row"));
    println!("neutral grains rise at {rise:.12} m/s in a stream of 0.002 m/s");
    assert!((rise - 0.002).abs() < 1e-9);
}
