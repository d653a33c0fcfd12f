//! The engines that are shipped beside the built-in ones: each passes `conform`, each runs its scene.

use std::collections::BTreeMap;
use std::process::Command;

use crate::background::{Run, need_programs, programs, report, root};

/// A closed box of water with spheres that lie, hang and never move.
const SPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/engines/space.toml");

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

/// The same in space, where a stream has a third component.
fn in_space() -> [(&'static str, &'static str, Vec<&'static str>); 3] {
    SHIPPED.map(|(seat, program, arguments)| {
        let depth = ["--velocity-z", "0.2*z-x"];
        let more = if program == "prescribed-fluid" {
            &depth[..]
        } else {
            &[]
        };
        (seat, program, [arguments, more].concat())
    })
}

fn pass_every_check(engines: &[(&str, &str, Vec<&str>)], scene: &[&str]) {
    need_programs();
    for (seat, program, arguments) in engines {
        let output = Command::new(env!("CARGO_BIN_EXE_sillage"))
            .args(["conform", "--as", seat])
            .args(scene)
            .args(["--", program])
            .args(arguments)
            .output()
            .expect("started");
        let words = String::from_utf8_lossy(&output.stdout);
        println!("{words}");
        assert_eq!(output.status.code(), Some(0), "{program}");
        // grains cannot be taken out of rapier's world here, and what is prescribed keeps its mesh
        let skipped = usize::from(["rapier-particles", "prescribed-fluid"].contains(program));
        let summary = format!("0 failed, {skipped} skipped");
        assert!(words.contains(&summary), "{program}");
    }
}

#[test]
fn shipped_engines_pass_every_check() {
    pass_every_check(
        &SHIPPED.map(|(seat, program, arguments)| (seat, program, arguments.to_vec())),
        &[],
    );
}

#[test]
fn shipped_engines_pass_every_check_in_space() {
    pass_every_check(&in_space(), &["--scene", SPACE]);
}

/// Run a shipped engine's scene with settings; the last row of steps.csv and the report.
fn run(engine: &str, settings: &[&str]) -> (BTreeMap<String, f64>, serde_json::Value) {
    let scene = root().join(format!("engines/{engine}/scene.toml"));
    run_scene(&scene.to_string_lossy(), settings)
}

/// The same of any scene.
fn run_scene(scene: &str, settings: &[&str]) -> (BTreeMap<String, f64>, serde_json::Value) {
    let mut arguments = vec![scene.to_owned()];
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
fn spheres_sink_with_the_contacts_of_rapier_as_with_the_built_in_ones() {
    let last = |engine: &str, end: &str| {
        let command = format!("engines.particles.command=[\"{engine}\"]");
        let settings = [
            &command,
            &format!("run.end_time={end}"),
            "output.frames=false",
            "coupling.scheme={ iterated = { tolerance = 1e-3, passes_max = 30 } }",
        ];
        run_scene(SPACE, &settings).0
    };
    println!("| | rapier | built-in |");
    for (end, within) in [("0.04", 1e-2), ("0.2", 1e-2)] {
        let (theirs, ours) = (
            last("rapier-particles", end),
            last("sillage-particles", end),
        );
        for name in [
            "centre_x",
            "centre_y",
            "centre_z",
            "front",
            "fall_speed",
            "contacts",
        ] {
            let (a, b) = (theirs[name], ours[name]);
            println!("| {name} at {end} s | {a:.6e} | {b:.6e} |");
        }
        let apart = |name: &str| (theirs[name] - ours[name]).abs() / ours[name].abs();
        for name in ["centre_x", "centre_y", "centre_z"] {
            assert!(apart(name) < within, "{name} at {end} s");
        }
    }
}

#[test]
fn neutral_spheres_take_the_velocity_of_a_prescribed_stream() {
    let settings = [
        "engines.fluid.command=[\"prescribed-fluid\", \"--velocity\", \"0.01\", \"0.005\", \"--velocity-z\", \"0.002\"]",
        "coupling.reaction=false",
        "grains[0].density=1000.0",
        "grains[1].density=1000.0",
        "grains[1].radius=5e-4",
        "grains[1].velocity=[0.0, 0.0, 0.0]",
        "grains[2].density=1000.0",
        "grains[2].fixed=false",
        "run.coupling_step=4e-3",
        "output.frames=false",
    ];
    let until = |end: &str| run_scene(SPACE, &[&settings[..], &[end]].concat()).0;
    let (first, last) = (until("run.end_time=4e-3"), until("run.end_time=0.4"));
    let [x, y, z] = ["centre_x", "centre_y", "centre_z"].map(|name| last[name] - first[name]);
    let rise = -last["fall_speed"];
    println!(
        "rise {rise:.9} m/s of 0.005; y/x {:.12} of 0.5, z/x {:.12} of 0.2",
        y / x,
        z / x
    );
    assert!((rise - 0.005).abs() < 1e-5);
    assert!((y / x - 0.5).abs() < 1e-9 && (z / x - 0.2).abs() < 1e-9);
}

#[test]
fn a_formula_of_space_is_refused_in_the_plane() {
    for (arguments, words) in [
        (
            r#""--velocity", "z", "0""#,
            "`z` depends on z, the scene has none",
        ),
        (
            r#""--velocity-z", "0.1""#,
            "--velocity-z is `0.1`, the scene has no third dimension",
        ),
    ] {
        let scene = root().join("engines/prescribed-fluid/scene.toml");
        let engine = format!("engines.fluid.command=[\"prescribed-fluid\", {arguments}]");
        let arguments = [
            scene.to_string_lossy().into_owned(),
            "--set".to_owned(),
            engine,
        ];
        let (code, said, _, _) = Run::start(&arguments).finish();
        println!("{said}");
        assert_eq!(code, Some(2));
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn a_wrong_formula_ends_prescribed_fluid_at_once() {
    need_programs();
    for (arguments, words) in [
        (
            ["--velocity", "w", "0"],
            "`w` is not known; variables are x, y, z and t",
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
