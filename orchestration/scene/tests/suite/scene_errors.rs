//! Every class of error in a scene names file, line, key, value and what is allowed; exit code 2.

use std::path::Path;

use scene::document::Document;
use scene::{Error, Scene};

use crate::schema;

pub const CLEAR_FLUID: &str = r#"
[run]
end_time = 1.0
coupling_step = 0.1
[gravity]
acceleration = [0.0, -9.81]
[fluid]
density = 1200.0
dynamic_viscosity = 0.12
[fluid.domain]
rectangle = { lower = [0.0, 0.0], upper = [0.01, 0.02], cells = [4, 8] }
[fluid.boundaries]
all = "no-slip"
"#;

const GRAINS: &str = r#"
[[grains]]
density = 2400.0
radius = 1e-4
cloud = { centre = [5e-3, 1e-2], radius = 2e-3, solid_fraction = 0.2, seed = 1 }
[contact]
tolerance = 1e-3
[coupling]
scheme = "staggered"
"#;

fn coupled() -> String {
    format!("{CLEAR_FLUID}{GRAINS}")
}

/// The scene of this text as a file at `path`, with what the schema must say of it; or why not.
pub fn load(
    path: &Path,
    text: &str,
    settings: &[&str],
    schema: fn(&Document),
) -> Result<Scene, Error> {
    let settings: Vec<String> = settings.iter().map(|setting| setting.to_string()).collect();
    let document = Document::parse(path, text.to_string(), &settings)?;
    schema(&document);
    scene::from_document(&document, 1)
}

/// The message of a scene that program and schema must refuse, in one line a problem.
fn refusal(text: &str, settings: &[&str]) -> String {
    message(text, settings, schema::refuses)
}

/// The same of a scene that no schema can refuse.
fn refusal_beyond_schema(text: &str, settings: &[&str]) -> String {
    message(text, settings, schema::takes)
}

fn message(text: &str, settings: &[&str], schema: fn(&Document)) -> String {
    match load(Path::new("case.toml"), text, settings, schema) {
        Ok(_) => panic!("accepted: {settings:?}\n{text}"),
        Err(error) => {
            assert_eq!(error.exit_code(), 2, "{error}");
            println!("{error}");
            error.to_string()
        }
    }
}

fn accepted(text: &str, settings: &[&str]) -> Scene {
    let scene = load(Path::new("case.toml"), text, settings, schema::takes);
    scene.unwrap_or_else(|error| panic!("{error}"))
}

fn assert_names(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "no {part:?} in {message:?}");
    }
}

#[test]
fn the_length_that_all_grains_were_smoothed_over_is_refused_with_what_to_do() {
    let text = coupled() + "smoothing_length = 0.0\n";
    assert_names(
        &refusal(&text, &[]),
        &[
            "coupling.smoothing_length",
            "no longer a key",
            "remove this line",
        ],
    );
}

#[test]
fn unknown_key_is_refused_with_line_and_nearest_key() {
    let text = CLEAR_FLUID.replace("density", "densty");
    assert_names(
        &refusal(&text, &[]),
        &["case.toml:8", "fluid.densty", "did you mean density?"],
    );
    let message = refusal(&coupled().replace("solid_fraction", "solid_fracton"), &[]);
    assert_names(
        &message,
        &[
            "case.toml:18",
            "grains[0].cloud.solid_fracton",
            "solid_fraction?",
        ],
    );
    let message = refusal(&format!("{CLEAR_FLUID}\n[outptu]\nevery = 1.0\n"), &[]);
    assert_names(
        &message,
        &["case.toml:15", "outptu", "did you mean output?"],
    );
}

#[test]
fn wrong_type_is_refused_with_line_value_and_what_is_expected() {
    let text = CLEAR_FLUID.replace("1200.0", "\"heavy\"");
    assert_names(
        &refusal(&text, &[]),
        &["case.toml:8", "fluid.density", "\"heavy\"", "a number"],
    );
    let text = CLEAR_FLUID.replace("[4, 8]", "[4, 8.5]");
    assert_names(
        &refusal(&text, &[]),
        &["case.toml:11", "cells[1] = 8.5", "whole number"],
    );
    let text = CLEAR_FLUID.replace("[0.0, -9.81]", "-9.81");
    assert_names(
        &refusal(&text, &[]),
        &["case.toml:6", "gravity.acceleration", "two numbers"],
    );
}

#[test]
fn a_table_written_as_a_list_and_a_name_as_a_table_are_refused() {
    for (text, place) in [
        (
            CLEAR_FLUID
                .replace("acceleration = [0.0, -9.81]", "")
                .replace("[gravity]", "[[gravity]]"),
            ["case.toml:5", "gravity"],
        ),
        (
            coupled().replace("\"staggered\"", "{ iterated = [1e-3, 30] }"),
            ["case.toml:22", "coupling.scheme.iterated"],
        ),
        (
            format!("{CLEAR_FLUID}[limits]\n").replace("[limits]", "[[limits]]"),
            ["case.toml:14", "limits"],
        ),
    ] {
        let message = refusal(&text, &[]);
        assert_names(&message, &place);
        assert_names(&message, &["wrong type"]);
    }
    let message = refusal(CLEAR_FLUID, &["gravity=[[0.0, -9.81]]"]);
    assert_names(&message, &["--set gravity", "expected a table"]);
    let message = refusal(&coupled(), &["coupling.scheme={ staggered = {} }"]);
    assert_names(&message, &["coupling.scheme", "wrong type"]);
}

#[test]
fn numbers_out_of_range_are_all_reported_at_once() {
    let text = coupled()
        .replace("1200.0", "-1200.0")
        .replace("coupling_step = 0.1", "coupling_step = 0.0")
        .replace("radius = 1e-4", "radius = -1e-4")
        .replace("tolerance = 1e-3", "tolerance = 2.0");
    let message = refusal(&text, &[]);
    assert_eq!(message.lines().count(), 4, "{message}");
    assert_names(
        &message,
        &["case.toml:4", "run.coupling_step = 0.0", "greater than 0 s"],
    );
    assert_names(
        &message,
        &[
            "case.toml:8",
            "fluid.density = -1200.0",
            "greater than 0 kg/m³",
        ],
    );
    assert_names(
        &message,
        &[
            "case.toml:17",
            "grains[0].radius = -1e-4",
            "greater than 0 m",
        ],
    );
    assert_names(
        &message,
        &["case.toml:20", "contact.tolerance = 2.0", "between 0 and 1"],
    );
}

#[test]
fn meshes_beyond_any_memory_are_refused() {
    let message = refusal_beyond_schema(
        CLEAR_FLUID,
        &["fluid.domain.rectangle.cells=[100000, 100000]"],
    );
    assert_names(
        &message,
        &["rectangle.cells", "1.000e10 nodes", "this machine has"],
    );
}

#[test]
fn not_finite_numbers_are_refused() {
    for key in ["run.end_time", "fluid.density", "fluid.dynamic_viscosity"] {
        for value in ["nan", "inf"] {
            assert_names(
                &refusal(CLEAR_FLUID, &[&format!("{key}={value}")]),
                &[key, "finite"],
            );
        }
    }
    assert_names(
        &refusal(CLEAR_FLUID, &["gravity.acceleration=[0.0,nan]"]),
        &["finite"],
    );
}

#[test]
fn a_boundary_that_does_not_exist_is_refused_with_the_names_that_do() {
    let message = refusal_beyond_schema(&format!("{CLEAR_FLUID}lef = \"slip\"\n"), &[]);
    assert_names(
        &message,
        &[
            "case.toml:14",
            "fluid.boundaries.lef",
            "did you mean left?",
            "top",
        ],
    );
}

#[test]
fn a_name_goes_before_all_and_every_side_has_one_condition() {
    let scene = accepted(&format!("{CLEAR_FLUID}left = \"slip\"\n"), &[]);
    let Some(fluid) = scene.coupler.fluid else {
        panic!("no fluid")
    };
    println!("{:?}", fluid.boundaries);
    assert_eq!(fluid.boundaries.len(), 4);
    assert_eq!(fluid.boundaries["left"], protocol::scene::Boundary::Slip);
    assert_eq!(fluid.boundaries["right"], protocol::scene::Boundary::NoSlip);
}

#[test]
fn overlapping_boundaries_are_refused() {
    let twice = format!("{CLEAR_FLUID}left = \"slip\"\nleft = \"no-slip\"\n");
    assert_names(
        &refusal_beyond_schema(&twice, &[]),
        &["case.toml:15", "duplicate key"],
    );
    let all_named = ["left", "right", "bottom", "top"].map(|side| format!("{side} = \"slip\"\n"));
    let message = refusal_beyond_schema(&format!("{CLEAR_FLUID}{}", all_named.concat()), &[]);
    assert_names(
        &message,
        &["case.toml:13", "fluid.boundaries.all", "apply to none"],
    );
}

#[test]
fn a_boundary_without_condition_is_refused() {
    let text = CLEAR_FLUID.replace("all =", "left =");
    let message = refusal_beyond_schema(&text, &[]);
    assert_eq!(message.lines().count(), 3);
    assert_names(&message, &["fluid.boundaries.right", "missing"]);
}

#[test]
fn periodic_sides_come_in_pairs() {
    let text = format!("{CLEAR_FLUID}left = \"periodic\"\n");
    assert_names(
        &refusal_beyond_schema(&text, &[]),
        &["case.toml:14", "opposite side, right"],
    );
}

#[test]
fn inflow_without_a_way_out_is_refused() {
    let text = format!("{CLEAR_FLUID}bottom = {{ inflow = {{ velocity = [0.0, 0.5] }} }}\n");
    assert_names(
        &refusal_beyond_schema(&text, &[]),
        &["fluid.boundaries", "5e-3 m²/s", "open"],
    );
    accepted(
        &format!("{text}top = {{ open = {{ pressure = 0.0 }} }}\n"),
        &[],
    );
    let lid = format!("{CLEAR_FLUID}top = {{ inflow = {{ velocity = [1.0, 0.0] }} }}\n");
    accepted(&lid, &[]);
}

#[test]
fn a_mixture_that_nothing_holds_is_refused_unless_the_scene_says_what_it_does() {
    let all = |more: &str, sides: &str| {
        let text = CLEAR_FLUID.replace("all = \"no-slip\"", sides);
        text.replace("[fluid]", &format!("[fluid]\n{more}"))
    };
    let periodic = "all = \"periodic\"";
    let pipe = "all = \"slip\"\nbottom = \"periodic\"\ntop = \"periodic\"";
    let walls = "all = \"no-slip\"\nbottom = \"periodic\"\ntop = \"periodic\"";
    for sides in [periodic, pipe] {
        let parts = ["fluid.mean_flow", "missing", "\"zero\"", "\"free\""];
        assert_names(&refusal_beyond_schema(&all("", sides), &[]), &parts);
        accepted(&all("mean_flow = \"free\"", sides), &[]);
        accepted(&all("mean_flow = \"zero\"", sides), &[]);
        accepted(&all("mean_flow = { velocity = [0.0, 1e-3] }", sides), &[]);
        let still = all("", sides);
        accepted(&still, &["gravity.acceleration=[0.0, 0.0]"]);
        let steady = all("mean_flow = \"zero\"\ntime_scheme = \"steady\"", sides);
        assert_names(
            &refusal_beyond_schema(&steady, &[]),
            &["fluid.time_scheme", "uniform"],
        );
    }
    accepted(&all("", walls), &[]);
    accepted(&all("mean_flow = { velocity = [0.0, 1e-3] }", walls), &[]);
    let across = all("mean_flow = { velocity = [1e-3, 0.0] }", walls);
    assert_names(
        &refusal_beyond_schema(&across, &[]),
        &["fluid.mean_flow", "x must be 0"],
    );
    let shut = all("mean_flow = \"zero\"", "all = \"no-slip\"");
    assert_names(
        &refusal_beyond_schema(&shut, &[]),
        &["fluid.mean_flow", "no side is periodic"],
    );
}

#[test]
fn sizes_that_no_mesh_can_have_are_refused() {
    // cells of 2.5e-3 m
    let with = |table: &str| format!("{}\n[fluid.refinement]\n{table}\n", coupled());
    accepted(&with("near_grains = 1e-3"), &[]);
    accepted(
        &with("regions = [{ ball = { centre = [0.0, 0.0], radius = 1e-3, size = 1e-3 } }]"),
        &[],
    );
    for (table, parts) in [
        (
            "near_grains = 3e-3",
            ["larger than the cells", "fewer cells"],
        ),
        ("near_grains = 1e-10", ["smaller than the smallest", "2."]),
        (
            "near_grains = 2e-8\nmargin = 1.0",
            ["need about", "larger cells"],
        ),
        (
            "near_grains = 1e-3\nmargin = 1e-6",
            ["margin", "largest grain"],
        ),
        ("near_grains = nan", ["near_grains", "must be"]),
        ("near_grains = 1e-3\ngrowth = nan", ["growth", "positive"]),
        (
            "indicator = { jump = 0.1, smallest = 3e-3 }",
            ["indicator.smallest", "larger than the cells"],
        ),
        (
            "indicator = { jump = inf, smallest = 1e-3 }",
            ["indicator.jump", "must be"],
        ),
        (
            "indicator = { jump = 0.1, smallest = nan }",
            ["indicator.smallest", "must be"],
        ),
        (
            "regions = [{ box = { lower = [1.0, 0.0], upper = [0.0, 0.0], size = 1e-3 } }]",
            ["regions[0]", "below lower"],
        ),
        (
            "regions = [{ ball = { centre = [1.0], radius = 0.0, size = 1e-3 } }]",
            ["regions[0]", "centre"],
        ),
    ] {
        let words = message(&with(table), &[], |_| {});
        println!("{words}");
        assert_names(&words, &parts);
    }
    let graded = coupled().replace("cells = [4, 8]", "cells = [4, 8], grading = [2.0, 1.0]");
    let words = refusal_beyond_schema(
        &format!("{graded}\n[fluid.refinement]\nnear_grains = 1e-3\n"),
        &[],
    );
    assert_names(&words, &["grading", "cells of one size"]);
    let scene = accepted(&with("near_grains = 1e-3"), &[]);
    println!("{:?}", scene.warnings);
    assert!(
        scene
            .warnings
            .iter()
            .any(|words| words.contains("makes cells of"))
    );
}

#[test]
fn a_mesh_that_is_read_is_refined_where_it_is_coarser_than_asked() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cylinder.toml");
    let text = std::fs::read_to_string(&path).expect("a scene");
    let with = |size: &str| {
        let setting = format!("fluid.refinement.indicator={{ jump = 0.1, smallest = {size} }}");
        load(&path, &text, &[&setting], schema::takes).map(drop)
    };
    with("1e-3").unwrap_or_else(|error| panic!("{error}"));
    let words = with("0.1").expect_err("refused").to_string();
    println!("{words}");
    assert_names(
        &words,
        &["largest cells of the mesh", "a mesh of larger ones"],
    );
}

#[test]
fn a_missing_mesh_file_is_refused_with_its_path() {
    let text = CLEAR_FLUID.replace(
        "rectangle = { lower = [0.0, 0.0], upper = [0.01, 0.02], cells = [4, 8] }",
        "mesh = \"no.msh\"",
    );
    assert_names(
        &refusal_beyond_schema(&text, &[]),
        &[
            "case.toml:11",
            "fluid.domain.mesh",
            "no.msh",
            "No such file",
        ],
    );
}

#[test]
fn what_has_no_default_must_be_written() {
    for (key, text) in [
        (
            "gravity",
            CLEAR_FLUID.replace("[gravity]\nacceleration = [0.0, -9.81]\n", ""),
        ),
        ("run.end_time", CLEAR_FLUID.replace("end_time = 1.0\n", "")),
        (
            "contact",
            coupled().replace("[contact]\ntolerance = 1e-3\n", ""),
        ),
        (
            "contact.tolerance",
            coupled().replace("tolerance = 1e-3", "friction = 0.1"),
        ),
        (
            "coupling.scheme",
            coupled().replace("[coupling]\nscheme = \"staggered\"\n", ""),
        ),
        (
            "passes_max",
            coupled().replace("\"staggered\"", "{ iterated = { tolerance = 1e-3 } }"),
        ),
        (
            "grains[0].density",
            coupled().replace("density = 2400.0\n", ""),
        ),
        ("grains[0].radius", coupled().replace("radius = 1e-4\n", "")),
    ] {
        assert_names(&refusal(&text, &[]), &["case.toml:", key, "missing"]);
    }
    assert_names(
        &refusal(
            "[run]\nend_time=1.0\ncoupling_step=0.1\n[gravity]\nacceleration=[0,0]\n",
            &[],
        ),
        &["nothing to compute"],
    );
}

#[test]
fn a_population_is_exactly_one_kind() {
    let text = coupled().replace("[contact]", "file = \"grains.csv\"\n[contact]");
    assert_names(
        &refusal(&text, &[]),
        &["grains[0]", "exactly one of cloud, lattice, box and file"],
    );
    let text = coupled().replace("solid_fraction = 0.2,", "solid_fraction = 0.2, count = 3,");
    assert_names(
        &refusal(&text, &[]),
        &["grains[0].cloud", "exactly one of solid_fraction and count"],
    );
}

#[test]
fn grains_outside_the_domain_and_overlapping_grains_are_refused() {
    let message = refusal_beyond_schema(&coupled(), &["grains[0].cloud.centre=[1e-3,1e-2]"]);
    assert_names(&message, &["grains[0]", "left side"]);
    let again = "[[grains]]\ndensity = 2400.0\nradius = 1e-4\n\
                 cloud = { centre = [5e-3, 1e-2], radius = 2e-3, count = 300, arrangement = \"sunflower\" }\n";
    let message = refusal_beyond_schema(
        &coupled().replace("[contact]", &format!("{again}[contact]")),
        &[],
    );
    assert_names(&message, &["grains[1]", "overlaps another grain"]);
}

#[test]
fn too_dense_for_random_placing_is_refused_with_the_bound() {
    let message = refusal_beyond_schema(&coupled(), &["grains[0].cloud.solid_fraction=0.7"]);
    assert_names(&message, &["grains[0].cloud", "at most 0.5", "lattice"]);
}

#[test]
fn a_grain_file_is_refused_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene_path = folder.path().join("case.toml");
    let text = coupled().replace(
        "radius = 1e-4\ncloud = { centre = [5e-3, 1e-2], radius = 2e-3, solid_fraction = 0.2, seed = 1 }",
        "file = \"g.csv\"",
    );
    std::fs::write(&scene_path, text).expect("written");
    let document = Document::load(&scene_path, &[]).expect("TOML");
    schema::takes(&document);
    for (csv, parts) in [
        (
            "x,y,radius\n5e-3,5e-3,1e-4\n5e-3,6e-3,-1e-4\n",
            ["g.csv:3", "radius = -1e-4"],
        ),
        (
            "x,y,radius\n5e-3,five,1e-4\n",
            ["g.csv:2", "y = five is not a number"],
        ),
        (
            "x,y,radius\n5e-3,5e-3\n",
            ["g.csv:2", "2 values in 3 columns"],
        ),
        ("x,y,diameter\n", ["g.csv", "unknown column diameter"]),
        ("x,y\n", ["g.csv", "column radius is missing"]),
        ("x,y,radius\n", ["g.csv", "no grain"]),
        (
            "x [ft],y,radius\n",
            ["unit [ft] of x is not known", "allowed: m, cm, mm"],
        ),
        (
            "x,y,radius,fixed [m]\n",
            ["unit [m] of fixed is not known", "it has none"],
        ),
        ("x [m,y,radius\n", ["g.csv", "has no closing ]"]),
    ] {
        std::fs::write(folder.path().join("g.csv"), csv).expect("written");
        let message = scene::load(&scene_path, &[], 1).expect_err(csv).to_string();
        println!("{message}");
        assert_names(&message, &parts);
    }
}

/// Units in the header count; marks of an encoding, ends of lines, semicolons and empty lines of
/// spreadsheets do not.
#[test]
fn a_grain_file_is_read_in_its_units_whatever_wrote_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene_path = folder.path().join("case.toml");
    let text = coupled().replace(
        "density = 2400.0\nradius = 1e-4\ncloud = { centre = [5e-3, 1e-2], radius = 2e-3, solid_fraction = 0.2, seed = 1 }",
        "file = \"g.csv\"",
    );
    assert!(text.contains("g.csv"), "{text}");
    std::fs::write(&scene_path, text).expect("written");
    let document = Document::load(&scene_path, &[]).expect("TOML");
    schema::takes(&document);
    for csv in [
        "x,y,radius,density,vx\n5e-3,0.01,1e-4,2500,0.25\n",
        "x [mm], y [cm], radius [um], density [g/cm3], vx [mm/s]\n5,1,100,2.5,250\n",
        "\u{feff}x [mm];y [m];radius [µm];density [kg/m³];vx [cm/s]\r\n\r\n5;0.01;100;2500;25\r\n\r\n",
    ] {
        std::fs::write(folder.path().join("g.csv"), csv).expect("written");
        let scene =
            scene::load(&scene_path, &[], 1).unwrap_or_else(|error| panic!("{csv}: {error}"));
        let row = scene.grains.to_csv();
        println!("{}", row.lines().last().unwrap_or_default());
        let numbers: Vec<f64> = row
            .lines()
            .last()
            .expect("a grain")
            .split(',')
            .map(|word| word.parse().expect("a number"))
            .collect();
        for (found, right) in numbers.iter().zip([5e-3, 0.01, 1e-4, 2500.0, 0.25]) {
            assert!(
                (found / right - 1.0).abs() < 1e-14,
                "{csv}: {found} for {right}"
            );
        }
    }
}

#[test]
fn settings_of_the_command_line_reach_every_key_and_are_named_in_messages() {
    let scene = accepted(
        &coupled(),
        &[
            "coupling.scheme=staggered",
            "fluid.density=1300",
            "output.every=0.5",
        ],
    );
    assert_eq!(scene.coupler.fluid.expect("fluid").density, 1300.0);
    assert_eq!(scene.coupler.output_every, Some(0.5));
    assert_names(
        &refusal(&coupled(), &["fluid.density=-1"]),
        &["--set fluid.density", "-1"],
    );
    assert_names(
        &refusal(&coupled(), &["fluid.densty=1"]),
        &["fluid.densty", "did you mean density?"],
    );
    assert_names(&refusal(&coupled(), &["fluid.density"]), &["KEY=VALUE"]);
    assert_names(
        &refusal(&coupled(), &["grains[3].density=1"]),
        &["grains[3].density"],
    );
}

#[test]
fn broken_toml_is_refused_with_its_line() {
    let text = CLEAR_FLUID.replace("end_time = 1.0", "end_time = = 1.0");
    assert_names(&refusal(&text, &[]), &["case.toml:3", "not valid TOML"]);
}

#[test]
fn an_unknown_output_field_is_refused() {
    let text = format!("{CLEAR_FLUID}[output]\nfields = [\"presure\"]\n");
    assert_names(
        &refusal(&text, &[]),
        &["case.toml:15", "presure", "did you mean pressure?"],
    );
    // known to the protocol, and in no file
    let written = [
        "no field of this name is written",
        "interstitial_velocity, pressure",
    ];
    for name in ["grain_force", "grain_drag", "drag", "nodal_mass"] {
        let text = format!("{CLEAR_FLUID}[output]\nfields = [\"{name}\"]\n");
        assert_names(&refusal(&text, &[]), &[&[name], &written[..]].concat());
    }
    let without_grains = format!("{CLEAR_FLUID}[output]\nfields = [\"grain_velocity\"]\n");
    assert_names(&refusal_beyond_schema(&without_grains, &[]), &written);
    accepted(
        &coupled(),
        &["output.fields=[\"grain_velocity\", \"porosity\"]"],
    );
}
