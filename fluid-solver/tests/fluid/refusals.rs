//! What is refused, and that the message names the number, the bound and the place.

use std::path::Path;

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::FluidConfig;
use fluid_solver::error::FluidError;
use fluid_solver::mesh::{Rectangle, gmsh};
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;

/// A unit square of two triangles; curves 1…4 are bottom, right, top, left.
const SQUARE: &str = r#"$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
1 1 "floor"
1 2 "rest"
2 3 "fluid"
$EndPhysicalNames
$Entities
0 4 1 0
1 0 0 0 1 0 0 1 1 0
2 1 0 0 1 1 0 1 2 0
3 0 1 0 1 1 0 1 2 0
4 0 0 0 0 1 0 1 2 0
1 0 0 0 1 1 0 1 3 4 1 2 3 4
$EndEntities
$Nodes
1 4 1 4
2 1 0 4
1
2
3
4
0 0 0
1 0 0
1 1 0
0 1 0
$EndNodes
$Elements
5 6 1 6
1 1 1 1
1 1 2
1 2 1 1
2 2 3
1 3 1 1
3 3 4
1 4 1 1
4 4 1
2 1 2 2
5 1 2 3
6 1 3 4
$EndElements
"#;

fn parse(text: &str) -> Result<fluid_solver::mesh::Mesh<2, 3>, FluidError> {
    gmsh::parse(Path::new("square.msh"), text)
}

/// The message of an error, printed, with all these parts in it.
fn says<T>(result: Result<T, FluidError>, parts: &[&str]) {
    let message = result.err().expect("an error").to_string();
    println!("{message}");
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

#[test]
fn a_gmsh_square_is_read_with_its_boundaries() {
    let mesh = parse(SQUARE).unwrap();
    assert_eq!(
        (mesh.node_count(), mesh.simplices.len(), mesh.facets.len()),
        (4, 2, 4)
    );
    assert_eq!(mesh.boundary_names, ["floor", "rest"]);
    assert_eq!(mesh.facets.iter().filter(|e| e.boundary == 0).count(), 1);
}

#[test]
fn mesh_errors_name_file_line_and_place() {
    says(
        gmsh::read(Path::new("nowhere.msh")),
        &["nowhere.msh", "No such file"],
    );
    says(
        parse(&SQUARE.replace("4.1 0 8", "2.2 0 8")),
        &["square.msh, line 2", "2.2", "4.1"],
    );
    says(
        parse(&SQUARE.replace("4.1 0 8", "4.1 1 8")),
        &["line 2", "binary", "ASCII"],
    );
    says(
        parse(&SQUARE.replace("1 1 0\n0 1 0", "1 x 0\n0 1 0")),
        &["line 27", "3 numbers"],
    );
    says(
        parse(&SQUARE.replace("5 1 2 3", "5 1 2 9")),
        &["line", "node 9 does not exist"],
    );
    says(
        parse(&SQUARE.replace("2 1 2 2\n", "2 1 3 2\n")),
        &["element type 3", "triangles (2)"],
    );
    says(
        parse(&SQUARE.replace("5 1 2 3", "5 1 3 2")),
        &["triangle 5", "area", "counter-clockwise"],
    );
    says(
        parse(&SQUARE.replace("4 0 0 0 0 1 0 1 2 0", "4 0 0 0 0 1 0 0 0")),
        &["no named boundary", "floor", "rest"],
    );
    says(
        parse(&SQUARE.replace("1 0 0 0 1 0 0 1 1 0", "1 0 0 0 1 0 0 2 1 2 0")),
        &["two boundaries", "floor", "rest"],
    );
    says(
        parse(&SQUARE.replace("4 4 1\n", "4 1 3\n")),
        &["lies inside the domain", "rest"],
    );
    says(
        parse(SQUARE.split("$EndElements").next().unwrap()),
        &["line", "ends here"],
    );
    says(
        parse(SQUARE.split("$Elements").next().unwrap()),
        &["no triangles"],
    );
}

#[test]
fn rectangle_errors_name_the_number() {
    says(
        Rectangle::new([0.0; 2], [0.0, 1.0], [2, 2]).mesh(),
        &["upper x = 0", "lower x = 0"],
    );
    says(
        Rectangle::new([0.0; 2], [1.0; 2], [2, 0]).mesh(),
        &["0 cells in y"],
    );
}

fn solver(config: FluidConfig<2>) -> Result<FluidSolver<2, 3>, FluidError> {
    FluidSolver::new(config, Rectangle::new([0.0; 2], [1.0; 2], [4; 2]).mesh()?)
}

#[test]
fn boundary_errors_name_the_boundary_and_what_is_allowed() {
    let base = || FluidConfig::new(1.0, 1.0);
    says(
        solver(base().with("left", Condition::NoSlip)),
        &["\"right\"", "no condition", "no-slip"],
    );
    says(
        solver(
            base()
                .with("all", Condition::NoSlip)
                .with("lid", Condition::Slip),
        ),
        &["\"lid\"", "left", "all"],
    );
    says(
        solver(
            base()
                .with("all", Condition::NoSlip)
                .with("left", Condition::uniform([1.0, 0.0])),
        ),
        &["closed domain", "net", "open boundary"],
    );
    says(
        solver(
            base()
                .with("all", Condition::NoSlip)
                .with("top", Condition::Periodic),
        ),
        &["\"top\"", "periodic", "opposite"],
    );
    says(solver(FluidConfig::new(0.0, 1.0)), &["density", "positive"]);
}

#[test]
fn bad_fields_are_refused_with_the_node() {
    let mut solver = solver(FluidConfig::new(1.0, 1.0).with("all", Condition::NoSlip)).unwrap();
    let n = solver.mesh().node_count();
    let mut field = vec![0.5; n];
    let mut advance = |field: &[f64], dt: f64| {
        let fields = SolidFields {
            porosity: Some(field),
            ..SolidFields::default()
        };
        solver.advance(&Request::first(1, dt), &fields).map(|_| ())
    };
    says(advance(&field[1..], 0.1), &["porosity", "24", "25"]);
    says(advance(&field, -0.1), &["dt", "positive"]);
    field[7] = -0.25;
    says(
        advance(&field, 0.1),
        &["-2.5e-1", "node 7", "5e-1 m", "2.5e-1 m"],
    );
    field[7] = f64::NAN;
    says(advance(&field, 0.1), &["porosity", "NaN", "node 7"]);
    says(solver.commit(), &["without a candidate"]);
}
