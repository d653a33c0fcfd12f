//! Mesh files: what is wrong with one, and which boundaries it has, is found before anything is started.

use std::path::Path;

use protocol::scene::{Boundary, MeshSource};
use scene::document::Document;

use crate::schema;

const SQUARE: &str = include_str!("../../../../protocol/gmsh/tests/files/bare.msh");
const TWO: &str = include_str!("../../../../protocol/gmsh/tests/files/two.msh");
const CHANNEL: &str = include_str!("../../../../protocol/gmsh/tests/files/channel-overlap.msh");

fn scene_text(domain: &str, boundaries: &str) -> String {
    format!(
        "[run]\nend_time = 1.0\ncoupling_step = 0.1\n[gravity]\nacceleration = [0.0, -9.81]\n\
         [fluid]\ndensity = 1200.0\ndynamic_viscosity = 0.12\n\
         [fluid.domain]\nmesh = \"m.msh\"\n{domain}\n[fluid.boundaries]\n{boundaries}\n"
    )
}

fn load(mesh: &str, domain: &str, boundaries: &str) -> Result<scene::Scene, String> {
    load_with(mesh, domain, boundaries, schema::takes)
}

/// The same, with what the schema must say of the scene.
fn load_with(
    mesh: &str,
    domain: &str,
    boundaries: &str,
    schema: fn(&Document),
) -> Result<scene::Scene, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.toml");
    std::fs::write(folder.path().join("m.msh"), mesh).expect("written");
    std::fs::write(&path, scene_text(domain, boundaries)).expect("written");
    let document = Document::load(&path, &[]).expect("TOML");
    schema(&document);
    scene::from_document(&document, 1).map_err(|error| {
        assert_eq!(error.exit_code(), 2, "{error}");
        println!("{error}\n");
        error.to_string()
    })
}

fn refused(mesh: &str, domain: &str, boundaries: &str, parts: &[&str]) {
    let message = load(mesh, domain, boundaries).expect_err("refused");
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

#[test]
fn boundaries_without_a_name_are_given_by_number() {
    let scene = load(SQUARE, "", "\"1\" = \"slip\"\nall = \"no-slip\"").unwrap();
    let fluid = scene.coupler.fluid.expect("fluid");
    let names: Vec<&String> = fluid.boundaries.keys().collect();
    assert_eq!(names, ["1", "2", "3", "4"]);
    assert_eq!(fluid.boundaries["1"], Boundary::Slip);
    refused(
        SQUARE,
        "",
        "\"7\" = \"slip\"\nall = \"no-slip\"",
        &["fluid.boundaries.7", "1, 2, 3, 4"],
    );
}

#[test]
fn several_surfaces_are_refused_unless_the_scene_names_them() {
    let walls = "walls = \"no-slip\"";
    refused(
        TWO,
        "",
        walls,
        &[
            "case.toml:10",
            "several surfaces",
            "oil",
            "water",
            "surfaces = ",
        ],
    );
    let both = load(TWO, "surfaces = [\"water\", \"oil\"]", walls).unwrap();
    let MeshSource::File {
        surfaces, scale, ..
    } = &both.coupler.fluid.expect("fluid").mesh
    else {
        panic!("a file");
    };
    assert_eq!((surfaces.len(), *scale), (2, 1.0));
    let one = "surfaces = [\"water\"]";
    refused(TWO, one, walls, &["no condition", "belong to no curve"]);
    refused(
        TWO,
        "surfaces = [\"milk\"]",
        walls,
        &["\"milk\"", "\"oil\""],
    );
}

#[test]
fn a_curve_in_two_groups_is_told_and_refused_where_their_conditions_differ() {
    let rest = "outlet = { open = { pressure = 0.0 } }\nall = \"no-slip\"";
    let scene = load(CHANNEL, "scale = 1e-3", &format!("left = \"slip\"\n{rest}"));
    let scene = scene.expect_err("a curve of walls and left");
    assert!(scene.contains("differs") && scene.contains("\"walls\""));
    let scene = load(CHANNEL, "scale = 1e-3", rest).unwrap();
    println!("{:#?}", scene.warnings);
    assert!(
        scene
            .warnings
            .iter()
            .any(|w| w.contains("\"inlet\"") && w.contains("\"left\""))
    );
    let names: Vec<String> = scene
        .coupler
        .fluid
        .expect("fluid")
        .boundaries
        .into_keys()
        .collect();
    assert_eq!(names, ["inlet", "left", "outlet", "the disk", "walls"]);
}

#[test]
fn every_fault_of_a_mesh_is_told_before_anything_is_started() {
    let all = "all = \"no-slip\"";
    refused("nothing", "", all, &["m.msh", "MeshFormat"]);
    refused(
        &SQUARE.replace("4.1 0 8", "4 0 8"),
        "",
        all,
        &["line 2", "format 4"],
    );
    let hole = SQUARE.replacen("2 1 2 ", "2 1 15 ", 1);
    refused(&hole, "", all, &["m.msh"]);
    let zero = load_with(SQUARE, "scale = 0.0", all, schema::refuses).expect_err("no scale");
    assert!(zero.contains("fluid.domain.scale") && zero.contains("greater than 0"));
    let none = load(SQUARE, "", "\"1\" = \"slip\"").expect_err("a boundary without a condition");
    assert!(none.contains("fluid.boundaries.2") && none.contains("missing"));
}

#[test]
fn cells_that_are_too_flat_are_told() {
    let text = |cells: &str| scene_text("", "all = \"no-slip\"").replace("mesh = \"m.msh\"", cells);
    let warnings = |cells: &str| {
        let document = Document::parse(Path::new("case.toml"), text(cells), &[]);
        let document = document.expect("TOML");
        schema::takes(&document);
        let scene = scene::from_document(&document, 1).unwrap();
        println!("{:?}", scene.warnings);
        scene.warnings
    };
    let rectangle =
        |rest: &str| format!("rectangle = {{ lower = [0.0, 0.0], upper = [1.0, 1.0], {rest} }}");
    assert!(warnings(&rectangle("cells = [49, 1]")).is_empty());
    assert!(warnings(&rectangle("cells = [51, 1]"))[0].contains("51 times"));
    let graded = warnings(&rectangle("cells = [10, 40], grading = [1.0, 100.0]"));
    assert!(graded[0].contains("times as long as high"));
}

#[test]
fn what_flows_into_a_mesh_must_leave_it() {
    let inflow = |curve: u32, x: f64, profile: &str| {
        format!(
            "\"{curve}\" = {{ inflow = {{ velocity = [{x}, 0.0], profile = \"{profile}\" }} }}\n"
        )
    };
    let rest = "all = \"no-slip\"\n";
    let lonely = inflow(4, 1.0, "uniform") + rest;
    refused(
        SQUARE,
        "",
        &lonely,
        &["fluid.boundaries", "m²/s flow in", "open a boundary"],
    );
    let balanced = inflow(4, 1.5, "parabolic") + &inflow(2, 1.0, "uniform") + rest;
    load(SQUARE, "", &balanced).unwrap();
    let lid = inflow(1, 1.0, "uniform") + rest;
    load(SQUARE, "", &lid).unwrap();
    let around = "walls = { inflow = { velocity = [1.0, 0.0], profile = \"parabolic\" } }";
    let both = "surfaces = [\"water\", \"oil\"]";
    refused(
        TWO,
        both,
        around,
        &["fluid.boundaries.walls", "2 ends", "has 0"],
    );
}
