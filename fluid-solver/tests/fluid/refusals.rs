//! What is refused, and that the message names the number, the bound and the place.

use std::path::Path;

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::FluidConfig;
use fluid_solver::error::FluidError;
use fluid_solver::mesh::{Mesh, Rectangle, file};
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;
use gmsh::Options;

/// The message of an error, printed, with all these parts in it.
fn says<T>(result: Result<T, FluidError>, parts: &[&str]) {
    let message = result.err().expect("an error").to_string();
    println!("{message}");
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

#[test]
fn what_is_wrong_with_a_mesh_file_is_told() {
    let read = |name: &str| file::read::<2, 3>(Path::new(name), &Options::default(), |_| false);
    says(read("nowhere.msh"), &["nowhere.msh", "No such file"]);
}

#[test]
fn a_mesh_of_parts_that_do_not_fit_is_refused() {
    let square = |simplices: &[[usize; 3]], named: &[([usize; 2], usize)]| {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let position = corners.map(Into::into).to_vec();
        let names = vec!["floor".to_owned(), "rest".to_owned()];
        Mesh::<2, 3>::new(position, simplices.to_vec(), names, named, |t| t + 5)
    };
    let halves = [[0, 1, 2], [0, 2, 3]];
    let sides = [([0, 1], 0), ([1, 2], 1), ([2, 3], 1), ([3, 0], 1)];
    assert_eq!(square(&halves, &sides).unwrap().facets.len(), 4);
    let turned = [[0, 2, 1], [0, 2, 3]];
    says(
        square(&turned, &sides),
        &["triangle 5", "area", "counter-clockwise"],
    );
    says(
        square(&halves, &sides[1..]),
        &["no named boundary", "floor", "rest"],
    );
    let twice = [&sides[..], &[([1, 0], 1)]].concat();
    says(
        square(&halves, &twice),
        &["two boundaries", "floor", "rest"],
    );
    let inside = [&sides[..], &[([0, 2], 1)]].concat();
    says(
        square(&halves, &inside),
        &["lies inside the domain", "rest"],
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
