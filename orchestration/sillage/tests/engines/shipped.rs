//! The engines that are shipped beside the built-in ones: each passes `conform`, each runs its scene.

use std::collections::BTreeMap;
use std::process::Command;

use crate::background::{Run, need_programs, programs, report, root};

/// Seat, program, arguments.
const SHIPPED: [(&str, &str, &[&str]); 3] = [
    (
        "fluid",
        "prescribed-fluid",
        &["--velocity", "-0.1*y", "x*t", "--pressure", "sin(x)-y"],
    ),
    ("particles", "frozen-particles", &[]),
    ("particles", "rapier-particles", &["--frequency", "400"]),
];

#[test]
fn shipped_engines_pass_every_check() {
    need_programs();
    for (seat, program, arguments) in SHIPPED {
        let output = Command::new(env!("CARGO_BIN_EXE_sillage"))
            .args(["conform", "--as", seat, "--", program])
            .args(arguments)
            .output()
            .expect("started");
        let words = String::from_utf8_lossy(&output.stdout);
        println!("{words}");
        assert_eq!(output.status.code(), Some(0), "{program}");
        // grains cannot be taken out of rapier's world here, and what is prescribed keeps its mesh
        let skipped = usize::from(["rapier-particles", "prescribed-fluid"].contains(&program));
        let summary = format!("0 failed, {skipped} skipped");
        assert!(words.contains(&summary), "{program}");
    }
}

/// Run a shipped engine's scene with settings; the last row of steps.csv and the report.
fn run(engine: &str, settings: &[&str]) -> (BTreeMap<String, f64>, serde_json::Value) {
    let scene = root().join(format!("engines/{engine}/scene.toml"));
    let mut arguments = vec![scene.to_string_lossy().into_owned()];
    for setting in settings {
        arguments.extend(["--set".to_owned(), (*setting).to_owned()]);
    }
    let (code, words, _, folder) = Run::start(&arguments).finish();
    assert_eq!(code, Some(0), "{words}");
    let steps = std::fs::read_to_string(folder.path().join("steps.csv")).expect("steps.csv");
    let names = steps
        .lines()
        .next()
        .expect("a header")
        .split(',')
        .map(str::to_owned);
    let last = steps.lines().last().expect("a row").split(',');
    let last = last.map(|number| number.parse().expect("a number"));
    (names.zip(last).collect(), report(folder.path()))
}

#[test]
fn scenes_of_shipped_engines_are_valid_and_run() {
    for (seat, engine, _) in SHIPPED {
        let path = root().join(format!("engines/{engine}/scene.toml"));
        let loaded = scene::load(&path, &[], 1).unwrap_or_else(|error| panic!("{error}"));
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert!(loaded.text.starts_with("# "), "{engine}: no comment on top");
        let (last, report) = run(engine, &[]);
        println!("{engine}: {} steps, {}", last["step"], report["engines"]);
        let engines = report["engines"].to_string();
        assert!(engines.contains(engine), "{seat}: {engines}");
    }
}

#[test]
fn grains_that_are_frozen_resist_as_fixed_ones_do() {
    let (frozen, _) = run("frozen-particles", &[]);
    let (fixed, _) = run(
        "frozen-particles",
        &[
            "grains[0].fixed=true",
            "engines.particles.command=[\"sillage-particles\"]",
        ],
    );
    let (frozen, fixed) = (frozen["pressure_drop"], fixed["pressure_drop"]);
    println!("pressure drop: frozen {frozen:.9} Pa, fixed {fixed:.9} Pa");
    assert!((frozen - fixed).abs() < 1e-7 * fixed);
    assert!((frozen - 122.8).abs() < 0.1);
}

#[test]
fn a_neutral_grain_takes_the_velocity_of_a_prescribed_stream() {
    let settings = [
        "engines.fluid.command=[\"prescribed-fluid\", \"--velocity\", \"0.01\", \"0.005\"]",
        "grains[0].density=1000.0",
        "grains[1].density=1000.0",
        "grains[1].lattice.lower=[1e-3, 1e-3]",
        "run.end_time=0.2",
        "output.frames=false",
    ];
    let (last, _) = run("prescribed-fluid", &settings);
    let (rise, x) = (-last["fall_speed"], last["centre_x"]);
    println!("rise {rise:.9} m/s of 0.005, centre at {x:.9} m");
    assert!((rise - 0.005).abs() < 1e-6);
}

#[test]
fn beads_sink_with_the_contacts_of_rapier_as_with_the_built_in_ones() {
    let last = |engine: &str| {
        let command = format!("engines.particles.command=[\"{engine}\"]");
        let settings = [&command, "run.end_time=0.4", "output.frames=false"];
        run("rapier-particles", &settings).0
    };
    let (theirs, ours) = (last("rapier-particles"), last("sillage-particles"));
    println!("| at 0.4 s | rapier | built-in |");
    for name in [
        "centre_y",
        "front",
        "fall_speed",
        "width",
        "contacts",
        "cpu_particles",
    ] {
        println!("| {name} | {:.6e} | {:.6e} |", theirs[name], ours[name]);
    }
    let apart = |name: &str| (theirs[name] - ours[name]).abs() / ours[name].abs();
    assert!(apart("centre_y") < 1e-3 && apart("fall_speed") < 1e-2);
}

#[test]
fn a_wrong_formula_ends_prescribed_fluid_at_once() {
    need_programs();
    for (arguments, words) in [
        (
            ["--velocity", "z", "0"],
            "`z` is not known; variables are x, y and t",
        ),
        (["--velocity", "2*", "0"], "2*"),
    ] {
        let output = Command::new(programs().join("prescribed-fluid"))
            .args(arguments)
            .output()
            .expect("started");
        let said = String::from_utf8_lossy(&output.stderr);
        println!("{said}");
        assert_eq!(output.status.code(), Some(2));
        assert!(said.contains(words), "{said}");
    }
}
