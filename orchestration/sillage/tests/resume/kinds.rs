//! Every kind of scene: a run that is resumed in its middle is the run that was not interrupted.

use std::path::Path;

use crate::background::{root, small_cloud};
use crate::leaving;
use crate::resume::same::{kept, resumed_from, run};

/// Run a scene for `steps` coupling steps, with states put out between checkpoints too, and resume it from its
/// middle with one and two threads: steps that it took.
fn halves(scene: &Path, steps: u64, more: &[&str]) -> usize {
    let text = std::fs::read_to_string(scene).expect("a scene");
    let keys: toml::Table = text.parse().expect("TOML");
    let dt = keys["run"]["coupling_step"].as_float().expect("a step");
    let mut settings = vec![
        format!("run.end_time={:e}", steps as f64 * dt),
        format!("output.every={:e}", 2.5 * dt),
    ];
    settings.extend(more.iter().map(|setting| setting.to_string()));
    let place = tempfile::tempdir().expect("a folder");
    let (folder, path) = (place.path().join("run"), scene.to_string_lossy());
    run(&path, &settings, 1, &folder);
    let all = kept(&folder);
    let middle = all[all.len() / 2];
    let mut taken = 0;
    for threads in [1, 2] {
        taken = resumed_from(&folder, middle, threads);
    }
    println!(
        "{:<28} {taken:>5} steps, resumed after {middle}",
        name(scene, more)
    );
    taken
}

fn name(scene: &Path, more: &[&str]) -> String {
    let name = scene.file_stem().expect("a name").to_string_lossy();
    format!("{name} {}", more.join(" "))
}

fn shipped(name: &str) -> std::path::PathBuf {
    root().join("scenes").join(name)
}

#[test]
fn a_run_of_every_kind_goes_on_to_the_bit() {
    for (name, more) in [
        // one way; two ways with convection; adaptive steps; BDF2, no grains; periodic; dry
        ("one-grain.toml", &[][..]),
        ("one-grain.toml", &["coupling.reaction=true"]),
        (
            "one-grain.toml",
            &["coupling.adaptive={courant=0.05,step_min=1e-4,step_max=2e-3}"],
        ),
        ("cylinder.toml", &[]),
        ("fixed-bed.toml", &[]),
        ("dry-collapse.toml", &[]),
    ] {
        halves(&shipped(name), 8, more);
    }
}

#[test]
fn a_run_that_grains_have_left_goes_on_to_the_bit() {
    let place = tempfile::tempdir().expect("a folder");
    let scene = place.path().join("hopper.toml");
    std::fs::write(&scene, leaving::SCENE).expect("written");
    halves(&scene, 60, &[]);
}

/// A cloud whose mesh follows it: an epoch every few steps.
pub const FOLLOWED: [&str; 5] = [
    "fluid.refinement.near_grains=1.2e-3",
    "fluid.refinement.margin=4e-4",
    "grains[0].radius=1.5e-4",
    "gravity.acceleration=[0.0, -40.0]",
    "fluid.time_scheme=bdf2",
];

#[test]
fn a_run_whose_mesh_follows_the_grains_goes_on_to_the_bit() {
    halves(&shipped("cloud.toml"), 30, &FOLLOWED);
}

/// A flow around a cylinder whose mesh follows it, from the triangles of a file.
const BENT: [&str; 2] = [
    "fluid.domain.mesh=meshes/cylinder-root.msh",
    "fluid.refinement.indicator={ jump = 0.3, smallest = 2.6e-3 }",
];

#[test]
fn a_run_whose_mesh_follows_the_flow_goes_on_to_the_bit() {
    halves(&shipped("cylinder.toml"), 12, &BENT);
}

/// A cloud of spheres on tetrahedra that follow it, too many for a direct factor.
const SPHERES: [&str; 4] = [
    "fluid.refinement.near_grains=1.24e-3",
    "fluid.refinement.margin=4e-4",
    "fluid.refinement.growth=0.4",
    "grains[0].radius=3.2e-4",
];

#[test]
fn runs_in_space_go_on_to_the_bit() {
    halves(&shipped("cloud-3d.toml"), 12, &SPHERES);
    halves(&shipped("settling-3d.toml"), 6, &[]);
    let friction = "contact.friction=0.3";
    halves(&shipped("dry-collapse-3d.toml"), 12, &[friction]);
}

#[test]
fn a_cloud_goes_on_from_every_step_to_the_bit() {
    let arguments = small_cloud(0.06);
    let settings: Vec<String> = arguments[1..]
        .iter()
        .filter(|word| *word != "--set")
        .cloned()
        .collect();
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("run");
    run(&arguments[0], &settings, 1, &folder);
    for step in kept(&folder) {
        let last = kept(&folder).last() == Some(&step);
        if !last {
            resumed_from(&folder, step, 1);
        }
    }
    println!("{} checkpoints", kept(&folder).len());
}

#[test]
fn engines_of_others_that_keep_their_state_go_on_to_the_bit() {
    let rapier = "engines.particles.command=[\"rapier-particles\"]";
    halves(&shipped("dry-collapse.toml"), 8, &[rapier]);
}

/// All shipped scenes, a hundred steps before and after: run by hand, it takes half an hour.
#[test]
#[ignore = "half an hour"]
fn every_shipped_scene_goes_on_to_the_bit() {
    let mut scenes: Vec<_> = std::fs::read_dir(root().join("scenes"))
        .expect("scenes")
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .collect();
    scenes.sort();
    for scene in scenes {
        halves(&scene, 200, &["output.frames=false"]);
    }
}
