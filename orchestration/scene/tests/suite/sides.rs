//! The sides of grains and fluid: the same ones, or refused, or told.

use std::path::Path;

use protocol::scene::{Boundary, Wall};
use scene::document::Document;

use crate::schema;

/// A rectangle of fluid with a grain in its middle.
fn scene(boundaries: &str, more: &str) -> Result<scene::Scene, String> {
    scene_with([0.01, 0.01], boundaries, more)
}

/// The same with the grain at another place.
fn scene_with(place: [f64; 2], boundaries: &str, more: &str) -> Result<scene::Scene, String> {
    let document = document(place, boundaries, more);
    schema::takes(&document);
    scene::from_document(&document, 1).map_err(|error| error.to_string())
}

fn document([x, y]: [f64; 2], boundaries: &str, more: &str) -> Document {
    let text = format!(
        "run = {{ end_time = 1.0, coupling_step = 0.1 }}\n\
         gravity.acceleration = [0.0, -9.81]\n\
         contact.tolerance = 1e-3\n\
         coupling.scheme = \"staggered\"\n\
         grains = [{{ density = 2e3, radius = 1e-3, cloud = {{ centre = [{x}, {y}], radius = 1e-3, count = 1, arrangement = \"sunflower\" }} }}]\n\
         {more}\n\
         [fluid]\n\
         density = 1e3\n\
         dynamic_viscosity = 1e-3\n\
         domain.rectangle = {{ lower = [0.0, 0.0], upper = [0.02, 0.02], cells = [4, 4] }}\n\
         boundaries = {{ {boundaries} }}\n"
    );
    Document::parse(Path::new("sides.toml"), text, &[]).expect("TOML")
}

fn refused(boundaries: &str, more: &str, words: &[&str]) {
    let why = scene(boundaries, more).expect_err(more);
    println!("{why}");
    assert!(words.iter().all(|word| why.contains(word)), "{words:?}");
}

/// Of words that the schema knows as well.
fn misspelt(boundaries: &str, words: &[&str]) {
    let document = document([0.01, 0.01], boundaries, "");
    schema::refuses(&document);
    let why = scene::from_document(&document, 1).expect_err(boundaries);
    let why = why.to_string();
    assert!(words.iter().all(|word| why.contains(word)), "{why}");
}

const ALL: &str = "all = \"no-slip\"";
const PERIODIC: &str = "left = \"periodic\", right = \"periodic\", all = \"no-slip\"";
const THROUGH: &str = "left = { inflow = { velocity = [0.1, 0.0] } }, \
                       right = { open = { pressure = 0.0 } }, all = \"no-slip\"";

fn domain(more: &str) -> String {
    format!("particles.domain = {{ lower = [0.0, 0.0], upper = [0.02, 0.02]{more} }}")
}

fn walls(boundaries: &str, more: &str) -> Vec<Wall> {
    let scene = scene(boundaries, more).unwrap_or_else(|why| panic!("{why}"));
    scene.coupler.particles.expect("grains").walls
}

#[test]
fn a_no_slip_side_may_move_along_itself() {
    let moving = "top = { no-slip = { velocity = [0.1, 0.0] } }, all = \"no-slip\"";
    let fluid = scene(moving, "")
        .expect("a lid")
        .coupler
        .fluid
        .expect("a fluid");
    let velocity = vec![0.1, 0.0];
    assert_eq!(fluid.boundaries["top"], Boundary::MovingWall { velocity });
    let lid = "top = { inflow = { velocity = [0.1, 0.0] } }, all = \"no-slip\"";
    let across = "left = { inflow = { velocity = [0.1, 0.1] } }, \
                  right = { open = { pressure = 0.0 } }, all = \"no-slip\"";
    for (boundaries, side, velocity) in [
        (moving, 3, Some(vec![0.1, 0.0])),
        (lid, 3, Some(vec![0.1, 0.0])),
        (across, 0, None),
        (ALL, 3, None),
    ] {
        assert_eq!(walls(boundaries, "")[side].velocity, velocity);
    }
    let sideways = "top = { no-slip = { velocity = [0.1, 0.1] } }, all = \"no-slip\"";
    refused(sideways, "", &["fluid.boundaries.top", "along itself"]);
    misspelt("all = \"open\"", &["sides.toml", "open = { pressure"]);
    misspelt("all = \"no-slp\"", &["no-slip", "did you mean"]);
    misspelt(
        "all = { no-slip = { speed = 1.0 } }",
        &["speed", "velocity"],
    );
}

#[test]
fn what_grains_meet_at_inflow_and_open_sides_may_be_chosen() {
    assert_eq!(walls(THROUGH, "").len(), 3);
    let both = "particles.boundaries = { left = \"open\", right = \"wall\" }";
    let right = &walls(THROUGH, both)[0].corners;
    assert_eq!(right[..], [[0.02, 0.0], [0.02, 0.02]]);
    refused(
        THROUGH,
        "particles.boundaries.top = \"open\"",
        &["only inflow and open"],
    );
    refused(
        THROUGH,
        "particles.boundaries.lid = \"open\"",
        &["no boundary", "left, right"],
    );
    let twice = format!("particles.boundaries.left = \"open\"\n{}", domain(""));
    refused(THROUGH, &twice, &["particles.domain"]);
}

#[test]
fn sides_that_are_periodic_for_one_of_both_are_refused() {
    let periodic = domain(", periodic = [true, false]");
    assert_eq!(walls(PERIODIC, &periodic).len(), 2);
    refused(
        ALL,
        &periodic,
        &["particles.domain.periodic", "left", "right"],
    );
    let open = domain(", open = [\"left\"]");
    refused(
        PERIODIC,
        &open,
        &["particles.domain.periodic", "would leave"],
    );
    let wider =
        "particles.domain = { lower = [0.0, 0.0], upper = [0.03, 0.02], periodic = [true, false] }";
    refused(PERIODIC, wider, &["particles.domain.upper", "period"]);
    let walled = scene(PERIODIC, &domain("")).expect("grains between walls");
    println!("{:?}", walled.warnings);
    assert_eq!(walled.warnings.len(), 2);
    assert!(walled.warnings[0].contains("the fluid is periodic there"));
}

#[test]
fn walls_that_only_one_side_sees_are_told() {
    let warnings = |more: &str| scene(ALL, more).expect("accepted").warnings;
    assert!(warnings("").is_empty() && warnings(&domain("")).is_empty());
    let within = warnings("particles.domain = { lower = [0.0, 0.0], upper = [0.02, 0.015] }");
    println!("{within:?}");
    assert_eq!(within.len(), 2);
    assert!(
        within[1].contains("no wall at left, right, top"),
        "{within:?}"
    );
    let open = warnings(&domain(", open = [\"top\"]"));
    assert!(open[0].contains("no wall at top"), "{open:?}");
    let inside = warnings("walls = [{ from = [0.0, 5e-3], to = [0.02, 5e-3] }]");
    assert!(inside[0].contains("only grains see"), "{inside:?}");
}

#[test]
fn a_grain_beside_the_fluid_is_refused_whatever_the_domain_of_the_grains() {
    let wide = "particles.domain = { lower = [-1.0, -1.0], upper = [1.0, 1.0] }";
    assert!(scene(ALL, wide).is_ok());
    let why = scene_with([0.021, 0.01], ALL, wide).expect_err("beside the fluid");
    println!("{why}");
    assert!(why.contains("grains[0]") && why.contains("outside the fluid"));
}
