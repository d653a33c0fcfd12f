//! Engines in C in runs of real processes.

use std::path::Path;
use std::process::Output;

use crate::programs::{compile, kit, sillage, text};

/// A column of `steps.csv`, as it stands there.
fn column(run: &Path, wanted: &str) -> Vec<f64> {
    let steps = std::fs::read_to_string(run.join("steps.csv")).expect("steps.csv");
    let mut lines = steps.lines();
    let mut names = lines.next().expect("a header").split(',');
    let place = names.position(|name| name == wanted).expect("a column");
    let value = |line: &str| line.split(',').nth(place).expect("a value").parse();
    lines.map(|line| value(line).expect("a number")).collect()
}

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
    let rise = -column(&run, "fall_speed").last().expect("a row");
    println!("neutral grains rise at {rise:.12} m/s in a stream of 0.002 m/s");
    assert!((rise - 0.002).abs() < 1e-9);
}

/// Twelve grains of these properties above an open bottom.
fn scene(folder: &Path, grains: &str, more: &str) -> std::path::PathBuf {
    let text = format!(
        r#"
run = {{ end_time = 0.1, coupling_step = 2e-3 }}
gravity.acceleration = [0.0, -9.81]
contact = {{ friction = 0.3, tolerance = 1e-3 }}
coupling = {{ drag = "dallavalle", scheme = "staggered", reaction = false }}
output = {{ every = 0.05, frames = false }}
checkpoint = {{ every_steps = 10, keep = 10 }}
[fluid]
density = 1000.0
dynamic_viscosity = 1e-3
domain.rectangle = {{ lower = [0.0, 0.0], upper = [0.02, 0.02], cells = [8, 8] }}
[fluid.boundaries]
top = {{ open = {{ pressure = 0.0 }} }}
bottom = {{ open = {{ pressure = 196.2 }} }}
all = "no-slip"
[[grains]]
radius = 2e-4
lattice = {{ lower = [2e-3, 1.5e-3], upper = [4e-3, 7e-3], spacing = 1e-3, pattern = "square" }}
{grains}
{more}
"#
    );
    let path = folder.join("scene.toml");
    std::fs::write(&path, text).expect("written");
    path
}

fn run(scene: &Path, engines: &[String], out: &Path) {
    let mut command = sillage();
    command.arg("run").arg(scene).arg("--out").arg(out);
    command.args(engines.iter().flat_map(|engine| ["--set", engine]));
    succeeded(&command.output().expect("started"));
}

fn succeeded(output: &Output) {
    assert!(output.status.success(), "{}", text(output));
}

/// v = (0.01, 0.05) m/s, of grains as heavy as the fluid: their mesh goes with them.
#[test]
fn a_mesh_in_c_follows_the_grains() {
    let place = tempfile::tempdir().expect("a folder");
    let [grains, stream] = ["examples/falling.c", "examples/stream.c"]
        .map(|source| compile(source, place.path()).display().to_string());
    let scene = scene(
        place.path(),
        "density = 1000.0\nvelocity = [0.01, 0.05]",
        "[fluid.refinement]\nnear_grains = 5e-4\nmargin = 1e-3",
    );
    let engines = [
        format!("engines.particles.command=[{grains:?}]"),
        format!("engines.fluid.command=[{stream:?}, \"0.01\", \"0.05\"]"),
    ];
    let out = place.path().join("run");
    run(&scene, &engines, &out);
    let [time, speed, nodes, epoch] =
        ["time", "fall_speed", "nodes", "epoch"].map(|name| column(&out, name));
    println!("time (s)  rise (m/s)       nodes  epoch");
    for k in (4..time.len()).step_by(5) {
        let rise = -speed[k];
        println!(
            "{:8.3}  {rise:.12}  {:6}  {:5}",
            time[k], nodes[k], epoch[k]
        );
    }
    let root = 9.0 * 9.0;
    assert!(
        nodes
            .iter()
            .all(|nodes| (2.0 * root..20.0 * root).contains(nodes))
    );
    assert!(epoch[time.len() - 1] >= epoch[0] + 4.0, "a margin each");
    assert!(speed.iter().all(|speed| (speed + 0.05).abs() < 1e-9));
}

/// The same engines in a box: v = (0.01, 0.05, −0.02) m/s, and tetrahedra go with the grains.
#[test]
fn both_engines_in_c_make_a_run_in_space() {
    let place = tempfile::tempdir().expect("a folder");
    let [grains, stream] = ["examples/falling.c", "examples/stream.c"]
        .map(|source| compile(source, place.path()).display().to_string());
    let text = r#"
run = { end_time = 0.1, coupling_step = 2e-3 }
gravity.acceleration = [0.0, -9.81, 0.0]
contact = { friction = 0.3, tolerance = 1e-3 }
coupling = { drag = "dallavalle", scheme = "staggered", reaction = false }
output = { every = 0.05, frames = false }
[fluid]
density = 1000.0
dynamic_viscosity = 1e-3
domain.box = { lower = [0.0, 0.0, 0.0], upper = [0.02, 0.02, 0.02], cells = [4, 4, 4] }
refinement = { near_grains = 2.5e-3, margin = 2e-3 }
[fluid.boundaries]
all = "no-slip"
[[grains]]
density = 1000.0
radius = 2e-4
velocity = [0.01, 0.05, -0.02]
lattice = { lower = [2e-3, 1.5e-3, 9e-3], upper = [4e-3, 7e-3, 11e-3], spacing = 1e-3, pattern = "cubic" }
"#;
    let scene = place.path().join("scene.toml");
    std::fs::write(&scene, text).expect("written");
    let engines = [
        format!("engines.particles.command=[{grains:?}]"),
        format!("engines.fluid.command=[{stream:?}, \"0.01\", \"0.05\", \"-0.02\"]"),
    ];
    let out = place.path().join("run");
    run(&scene, &engines, &out);
    let names = [
        "time",
        "fall_speed",
        "centre_x",
        "centre_z",
        "nodes",
        "epoch",
    ];
    let [time, speed, x, z, nodes, epoch] = names.map(|name| column(&out, name));
    println!("time (s)  rise (m/s)       x (m)      z (m)      nodes  epoch");
    for k in (4..time.len()).step_by(15) {
        println!(
            "{:8.3}  {:.12}  {:.7}  {:.7}  {:6}  {:5}",
            time[k], -speed[k], x[k], z[k], nodes[k], epoch[k]
        );
    }
    let last = time.len() - 1;
    let gone = |along: &[f64]| (along[last] - along[0]) / (time[last] - time[0]);
    assert!(speed.iter().all(|speed| (speed + 0.05).abs() < 1e-9));
    assert!((gone(&x) - 0.01).abs() < 1e-9 && (gone(&z) + 0.02).abs() < 1e-9);
    assert!(epoch[last] > epoch[0] && nodes.iter().all(|&nodes| nodes > 125.0));
}

/// Grains that touch nobody move as those of the built-in engine, and a run goes on from where some have left.
#[test]
fn grains_in_c_leave_and_a_run_without_them_goes_on_to_the_bit() {
    let place = tempfile::tempdir().expect("a folder");
    let program = compile("examples/falling.c", place.path())
        .display()
        .to_string();
    let scene = scene(place.path(), "density = 2500.0", "");
    let [own, built_in] = [program.as_str(), "sillage-particles"].map(|program| {
        let out = place
            .path()
            .join(program.rsplit('/').next().expect("a name").to_owned() + "-run");
        run(
            &scene,
            &[format!("engines.particles.command=[{program:?}]")],
            &out,
        );
        out
    });
    let told = |out: &Path| {
        ["time", "grains", "removed_grains", "fall_speed", "centre_y"].map(|name| column(out, name))
    };
    let (mine, theirs) = (told(&own), told(&built_in));
    let [time, left, gone, speed, _] = &mine;
    println!("time (s)  grains  gone  fall_speed (m/s)  built-in");
    for k in (4..time.len()).step_by(5) {
        let (a, b) = (speed[k], theirs[3][k]);
        println!(
            "{:8.3}  {:6}  {:4}  {a:.10}      {b:.10}",
            time[k], left[k], gone[k]
        );
    }
    assert_eq!((&mine[..3], left.last()), (&theirs[..3], Some(&4.0)));
    for (a, b) in mine[3..].iter().flatten().zip(theirs[3..].iter().flatten()) {
        assert!((a - b).abs() <= 1e-12 * b.abs(), "{a:e} and {b:e}");
    }
    let resumed = sillage()
        .arg("resume")
        .arg(&own)
        .args(["--from", "30"])
        .output();
    succeeded(&resumed.expect("started"));
    assert!(left[29] < 12.0, "some have left before it");
    assert_eq!(told(&own), mine);
}
