//! Walls of grains: the sides of the fluid's mesh, at rest and moving.

#[path = "../../orchestration/scene/tests/suite/validator.rs"]
#[expect(dead_code, reason = "other tests name keys")]
mod validator;

use std::f64::consts::TAU;
use std::path::Path;

use coupler::simulation::Simulation;
use protocol::engine::InitialGrains;
use protocol::scene::{Boundary, CouplerScene, GrainBoundary, MeshSource, Wall};
use scene::document::Document;
use tests::grains::disks;
use tests::meshes::square_without_disk;
use tests::{box_walls, couple, fluid, particles, scene};

const DISK: f64 = 0.05;
const AROUND: usize = 32;

/// Edges of the disk that is cut out, fluid on the left.
fn edges() -> Vec<Wall> {
    let place = |k: usize| {
        let (sine, cosine) = (TAU * k as f64 / AROUND as f64).sin_cos();
        [0.5 + DISK * cosine, 0.5 + DISK * sine]
    };
    (0..AROUND)
        .map(|k| Wall::segment(place(k + 1), place(k)))
        .collect()
}

/// A fluid of density 1 around a disk, and a mesh of it.
fn around_a_disk(folder: &Path, walls: Vec<Wall>) -> CouplerScene {
    let file = folder.join("disk.msh");
    square_without_disk(&file, DISK, AROUND, 10);
    let gravity = [0.0, -1.0];
    let mut fluid = fluid(1.0, 1e-3, gravity, [0.0, 0.0], [1.0, 1.0], [1, 1]);
    fluid.mesh = MeshSource::File {
        path: file.to_string_lossy().into_owned(),
        scale: 1.0,
        surfaces: Vec::new(),
    };
    fluid.boundaries = ["sides", "disk"]
        .map(|name| (name.to_owned(), Boundary::NoSlip))
        .into();
    let mut grains = particles(gravity);
    grains.walls = walls;
    let mut scene = scene(Some(fluid), Some(grains), 5e-3, 400);
    let meets = ["sides", "disk"].map(|name| (name.to_owned(), GrainBoundary::Wall));
    scene.grain_boundaries = Some(meets.into());
    scene
}

/// From the grain's centre to the nearest edge over a run, and how many steps it touched something.
fn nearest(simulation: &mut Simulation<2, 3>) -> (f64, usize) {
    let (mut nearest, mut touched) = (f64::INFINITY, 0);
    let edges = edges();
    while simulation.state.time < simulation.scene.end_time - 1e-9 {
        let dt = simulation.scene.coupling_step;
        simulation
            .advance(dt)
            .unwrap_or_else(|error| panic!("{error}"));
        let grains = &simulation.state.grains;
        let place = grains.position[0];
        let distances = edges.iter().map(|edge| edge.distance(place.as_slice()));
        nearest = distances.fold(nearest, f64::min);
        touched += usize::from(grains.contact[0] != coupler::state::Contact::Free);
    }
    (nearest, touched)
}

#[test]
fn a_grain_never_comes_nearer_than_its_radius_to_a_disk_cut_out_of_the_mesh() {
    const RADIUS: f64 = 5e-3;
    println!("x      walls of the scene   nearest    steps in contact   ends at");
    for (x, of_scene) in [(0.5, 4), (0.5, 0), (0.507, 4), (0.54, 0)] {
        let folder = tempfile::tempdir().expect("a folder");
        let walls = match of_scene {
            0 => Vec::new(),
            _ => box_walls([0.0, 0.0], [1.0, 1.0]),
        };
        let scene = around_a_disk(folder.path(), walls);
        let grains = disks(&[[x, 0.7]], &[RADIUS], 1000.0);
        let mut simulation = couple(scene, &grains);
        let (nearest, touched) = nearest(&mut simulation);
        let end = simulation.state.grains.position[0];
        println!("{x:.3}  {of_scene}                   {nearest:.6}   {touched}          {end:?}");
        assert!(nearest >= RADIUS - 1e-4, "{nearest}");
        assert!(touched > 0);
        assert!(end[1] >= RADIUS - 1e-4, "through the floor: {end:?}");
    }
}

/// A scene of a disk of 1 mm on the floor of a thin fluid.
fn on_a_floor_text(floor: &str, more: &str) -> String {
    format!(
        "run = {{ end_time = 0.05, coupling_step = 5e-4 }}\n\
         gravity.acceleration = [0.0, -9.81]\n\
         contact = {{ friction = 0.5, tolerance = 1e-8 }}\n\
         coupling.scheme = {{ iterated = {{ tolerance = 1e-3, passes_max = 30 }} }}\n\
         {more}\n\
         [fluid]\n\
         density = 1e-3\n\
         dynamic_viscosity = 1e-8\n\
         domain.rectangle = {{ lower = [0.0, 0.0], upper = [0.06, 0.02], cells = [12, 4] }}\n\
         [fluid.boundaries]\n\
         all = \"no-slip\"\n\
         bottom = {floor}\n\
         [[grains]]\n\
         density = 1000.0\n\
         radius = 1e-3\n\
         cloud = {{ centre = [0.02, 1e-3], radius = 1e-3, count = 1, arrangement = \"sunflower\" }}\n"
    )
}

fn on_a_floor(floor: &str, more: &str) -> (CouplerScene, InitialGrains) {
    let text = on_a_floor_text(floor, more);
    let document = Document::parse(Path::new("belt.toml"), text, &[]).expect("TOML");
    assert_eq!(validator::complaint(&document), None);
    let scene = scene::from_document(&document, 1).unwrap_or_else(|error| panic!("{error}"));
    println!("{:?}", scene.warnings);
    let (places, _) = scene.grains.position.as_chunks();
    let mut grains = disks(places, &scene.grains.radius, 1000.0);
    grains.velocity.clone_from(&scene.grains.velocity);
    (scene.coupler, grains)
}

#[test]
fn a_disk_from_rest_rolls_at_a_third_of_the_speed_of_a_belt_however_it_is_written() {
    const BELT: f64 = 0.1;
    let walls = "particles = { walls = \"none\" }\n\
                 walls = [{ from = [0.0, 0.0], to = [0.06, 0.0], velocity = [0.1, 0.0] }]";
    let domain = "particles.domain = { lower = [0.0, 0.0], upper = [0.06, 0.01] }";
    println!("floor                                      v/U after 50 ms, exact 0.333333");
    for (floor, more) in [
        ("{ no-slip = { velocity = [0.1, 0.0] } }", ""),
        ("{ inflow = { velocity = [0.1, 0.0] } }", ""),
        ("{ no-slip = { velocity = [0.1, 0.0] } }", domain),
        ("\"no-slip\"", walls),
    ] {
        let (scene, grains) = on_a_floor(floor, more);
        let mut simulation = couple(scene, &grains);
        while simulation.state.time < simulation.scene.end_time - 1e-9 {
            let dt = simulation.scene.coupling_step;
            simulation
                .advance(dt)
                .unwrap_or_else(|error| panic!("{error}"));
        }
        let share = simulation.state.grains.velocity[0][0] / BELT;
        println!("{floor:42} {share:.6}");
        assert!((share - 1.0 / 3.0).abs() < 1e-4);
    }
}

/// A scene on a mesh of the unit square without a disk, with a grain at `centre`.
fn on_a_mesh(folder: &Path, centre: [f64; 2], more: &str) -> Result<scene::Scene, String> {
    square_without_disk(&folder.join("disk.msh"), DISK, AROUND, 10);
    let [x, y] = centre;
    let text = format!(
        "run = {{ end_time = 1.0, coupling_step = 0.1 }}\n\
         gravity.acceleration = [0.0, -1.0]\n\
         contact.tolerance = 1e-3\n\
         coupling.scheme = \"staggered\"\n\
         fluid = {{ density = 1.0, dynamic_viscosity = 1e-3, domain.mesh = \"disk.msh\", \
         boundaries.all = \"no-slip\" }}\n\
         grains = [{{ density = 1000.0, radius = 5e-3, cloud = {{ centre = [{x}, {y}], radius = 5e-3, \
         count = 1, arrangement = \"sunflower\" }} }}]\n\
         {more}\n"
    );
    let document = Document::parse(&folder.join("mesh.toml"), text, &[]).expect("TOML");
    // What is refused here is beyond a schema: where grains and walls are.
    assert_eq!(validator::complaint(&document), None);
    scene::from_document(&document, 1).map_err(|error| error.to_string())
}

#[test]
fn a_grain_in_a_hole_of_the_mesh_is_refused_and_walls_of_one_side_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |centre, more| on_a_mesh(folder.path(), centre, more);
    for outside in [[0.5, 0.5], [0.5, 0.4527], [1.2, 0.5]] {
        let why = at(outside, "").expect_err("not in the fluid");
        println!("{why}");
        assert!(why.contains("mesh.toml") && why.contains("grains[0]") && why.contains("hole"));
    }
    let scene = at([0.5, 0.44], "").expect("below the disk");
    let sides = scene.coupler.grain_boundaries.expect("walls of the mesh");
    assert_eq!(sides["disk"], GrainBoundary::Wall);
    let warnings = |more| at([0.5, 0.7], more).expect("above the disk").warnings;
    let square = "particles.domain = { lower = [0.0, 0.0], upper = [1.0, 1.0] }";
    let inside = "walls = [{ from = [0.1, 0.2], to = [0.9, 0.2] }]";
    let none = "particles.walls = \"none\"";
    println!("{:?}\n{:?}", warnings(inside), warnings(none));
    assert!(warnings("").is_empty() && warnings(square).is_empty());
    assert!(warnings(inside)[0].contains("only grains see the wall"));
    assert!(warnings(none)[0].contains("no wall at disk, sides"));
    let why = at([0.5, 0.7], "particles.boundaries.disk = \"open\"").expect_err("a wall");
    println!("{why}");
    assert!(why.contains("particles.boundaries.disk") && why.contains("only inflow and open"));
}
