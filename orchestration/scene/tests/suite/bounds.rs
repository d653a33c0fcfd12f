//! Numbers that are each in range and together make no sense: refused with the key and what is allowed.

use std::path::Path;

use scene::Scene;

use crate::scene_errors::{self, CLEAR_FLUID};
use crate::schema;

const GRAINS: &str = r#"[[grains]]
density = 2400.0
radius = 1e-4
lattice = { lower = [0.0, 0.0], upper = [0.01, 0.01], spacing = 1e-3 }
[contact]
tolerance = 1e-3
[coupling]
scheme = "staggered"
"#;

fn load(settings: &[&str]) -> Result<Scene, String> {
    load_at(Path::new("case.toml"), settings)
}

/// The same as a file at `path`.
fn load_at(path: &Path, settings: &[&str]) -> Result<Scene, String> {
    let text = format!("{CLEAR_FLUID}{GRAINS}");
    // What these refuse is beyond any schema.
    scene_errors::load(path, &text, settings, schema::takes).map_err(|error| {
        assert_eq!(error.exit_code(), 2, "{error}");
        error.to_string()
    })
}

fn accepted(settings: &[&str]) -> Scene {
    load(settings).unwrap_or_else(|why| panic!("{settings:?}: {why}"))
}

/// Refused, with these words.
fn refused(settings: &[&str], parts: &[&str]) {
    let Err(why) = load(settings) else {
        panic!("accepted: {settings:?}");
    };
    println!("{why}");
    for part in parts {
        assert!(why.contains(part), "no {part:?} in {why:?}");
    }
}

#[test]
fn states_nearer_to_each_other_than_steps_are_refused() {
    accepted(&["output.every=0.1"]);
    accepted(&["output.every=0.15"]);
    refused(
        &["output.every=0.05"],
        &["output.every = 0.05", "at least run.coupling_step = 1e-1 s"],
    );
    refused(&["output.every=1e-300"], &["output.every", "at least"]);
    let adaptive = "coupling.adaptive={ step_min = 0.01, step_max = 0.2, courant = 0.5 }";
    accepted(&[adaptive, "output.every=0.05"]);
    refused(
        &[adaptive, "output.every=0.005"],
        &["at least coupling.adaptive.step_min = 1e-2 s"],
    );
}

#[test]
fn steps_that_no_sum_resolves_are_refused() {
    refused(
        &["run.coupling_step=1e-300"],
        &["run.coupling_step", "1e-12 of run.end_time"],
    );
    refused(
        &["coupling.adaptive={ step_min = 1e-20, step_max = 0.2, courant = 0.5 }"],
        &["coupling.adaptive.step_min", "1e-12 of run.end_time"],
    );
}

#[test]
fn a_slab_is_at_least_as_deep_as_its_spheres_are_wide() {
    accepted(&["coupling.geometry={ sphere = { depth = 2e-4 } }"]);
    refused(
        &["coupling.geometry={ sphere = { depth = 1.9e-4 } }"],
        &[
            "coupling.geometry.sphere.depth = 1.9e-4",
            "the diameter of the largest grain, 2e-4 m",
        ],
    );
}

#[test]
fn a_grain_wider_than_the_domain_is_refused_and_one_wider_than_a_cell_is_not() {
    let one = "grains[0].lattice={ lower = [0.0, 0.0], upper = [0.01, 0.02], spacing = 0.02 }";
    accepted(&["grains[0].radius=4e-3", one]);
    let alone = "grains=[{ density = 2400.0, radius = 6e-3, fixed = true, \
                 cloud = { centre = [5e-3, 1e-2], radius = 1e-6, count = 1, arrangement = \"sunflower\" } }]";
    let wide = ["grains[0]", "1.2e-2 m wide", "only 1e-2 m"];
    refused(&[alone], &wide);
    let periodic = ["fluid.boundaries.all=periodic", "fluid.mean_flow=zero"];
    refused(&[alone, periodic[0], periodic[1]], &wide);
    // Its own domain may be as wide as it likes: the fluid is not.
    let roomy = "particles.domain={ lower = [-0.01, 0.0], upper = [0.02, 0.02] }";
    refused(&[alone, roomy], &wide);
}

#[test]
fn lengths_without_a_square_are_refused() {
    let wall = |to: &str| format!("walls=[{{ from = [0.0, 0.0], to = [{to}, 0.0] }}]");
    for (setting, key) in [
        (
            "fluid.domain.rectangle.upper=[0.01, 1e300]".to_string(),
            "fluid.domain.rectangle.upper",
        ),
        (
            "fluid.domain.rectangle.upper=[1e-200, 1e-200]".to_string(),
            "fluid.domain.rectangle.upper",
        ),
        (wall("1e300"), "walls[0].to"),
        (wall("1e-200"), "walls[0].to"),
    ] {
        refused(&[&setting], &[key, "its square is no number"]);
    }
}

#[test]
fn the_plan_counts_steps_that_are_cut_where_states_are_put_out() {
    let counts = |every: &str| {
        let plan = scene::plan::plan(&accepted(&["run.coupling_step=0.02", every]));
        (plan.steps, plan.states)
    };
    assert_eq!(counts("output.every=0.1"), (Some(50), 11));
    assert_eq!(counts("output.every=0.05"), (Some(60), 21));
    // the last state is put out whenever it comes: 3 × 15 steps and 5
    assert_eq!(counts("output.every=0.3"), (Some(50), 5));
}

#[test]
fn what_no_machine_holds_is_counted_and_refused_before_it_is_made() {
    let lattice = |upper: &str, spacing: &str| {
        format!(
            "grains[0].lattice={{ lower = [0.0, 0.0], upper = [{upper}, {upper}], spacing = {spacing} }}"
        )
    };
    let cloud = "grains[0]={ density = 1.0, radius = 1e-9, \
                 cloud = { centre = [5e-3, 1e-2], radius = 4e-3, solid_fraction = 0.4 } }";
    for (settings, named) in [
        (&[lattice("1e15", "1e-3")][..], "1.000e36 grains"),
        (&[lattice("1e15", "1e-300")], "inf"),
        (
            &[lattice("1.0", "1e-5"), "grains[0].radius=1e-6".into()],
            "1.000e10 grains",
        ),
        (&[cloud.into()], "grains need about"),
        (
            &["fluid.domain.rectangle.cells=[4000000000, 4000000000]".into()],
            "1.600e19 nodes",
        ),
    ] {
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        let mut parts = vec![named];
        if !named.contains("inf") {
            parts.push("GB of memory, and this machine has");
        }
        refused(
            &settings,
            if named == "inf" {
                &["grains[0].lattice"]
            } else {
                &parts
            },
        );
    }
    refused(
        &["run.coupling_step=1e-6", "output.every=1e-6"],
        &["output.every", "1.0e6 states, at most 1e5"],
    );
}

#[test]
fn a_lattice_that_is_too_dense_is_told_what_is_not_yet_so() {
    let lattice = |rest: &str| {
        format!("grains[0].lattice={{ lower = [0.0, 0.0], upper = [0.01, 0.01], {rest} }}")
    };
    for (rest, advised, not) in [
        ("spacing = 1e-4", "raise the spacing", "fraction"),
        (
            "spacing = 1e-4, pattern = \"hexagonal\"",
            "raise the spacing",
            "hexagonal",
        ),
        (
            "solid_fraction = 0.85",
            "pattern = \"hexagonal\"",
            "spacing",
        ),
        (
            "solid_fraction = 0.9, pattern = \"hexagonal\"",
            "lower the solid fraction",
            "hexagonal",
        ),
    ] {
        let Err(why) = load(&[&lattice(rest)]) else {
            panic!("accepted: {rest}");
        };
        println!("{why}");
        assert!(why.contains(advised) && !why.contains(not), "{why}");
    }
}

#[test]
fn many_equal_lines_of_a_grain_file_are_refused_or_read_in_seconds() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |fixed: u8| {
        let row = format!("5e-3,1e-2,1e-4,{fixed}\n");
        let text = format!("x,y,radius,fixed\n{}", row.repeat(200_000));
        std::fs::write(folder.path().join("g.csv"), text).expect("written");
    };
    let file = |name: &str| -> Result<usize, String> {
        let grains = format!("grains=[{{ density = 2400.0, file = \"{name}\" }}]");
        let path = folder.path().join("case.toml");
        load_at(&path, &[&grains]).map(|scene| scene.grains.len())
    };
    let begun = std::time::Instant::now();
    write(0);
    let why = file("g.csv").expect_err("they overlap");
    println!("{why}");
    assert!(why.contains("grain 1 of this population"), "{why}");
    write(1);
    assert_eq!(file("g.csv"), Ok(200_000));
    println!("{:?}", begun.elapsed());
    assert!(begun.elapsed() < std::time::Duration::from_secs(10));
    for endless in ["/dev/zero", "."] {
        let why = file(endless).expect_err("no file");
        assert!(why.contains("is not a file"), "{why}");
    }
}
