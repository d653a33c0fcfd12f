//! (F1)–(F3) in numbers that can be done by hand.

use coupler::coupled::carry::{carried_force, lagged_pressure_force};
use coupler::coupled::defect::{Defect, Scales, measure};
use coupler::coupled::outcome::Pass;
use coupler::coupled::response::Model;
use coupler::state::{Candidate, Flow, Grains};
use coupler::transfer::Transfer;
use coupler::transfer::quantity::nodal_norm;
use space::{Dim, Dimension, Vector};

use crate::mesh::cube;

/// m = 3, V = ½, γ = 7, λ = ½, D = 0.1 of every grain.
fn model<const D: usize>(count: usize) -> Model<D> {
    Model {
        drag: vec![7.0; count],
        volume: vec![0.5; count],
        mobility: vec![0.1; count],
        lambda: vec![0.5; count],
        free_velocity: vec![Vector::zeros(); count],
        fixed: vec![false; count],
    }
}

/// A vector in the plane of the first two axes.
fn flat<const D: usize>(x: f64, y: f64) -> Vector<D> {
    let mut vector = Vector::zeros();
    (vector[0], vector[1]) = (x, y);
    vector
}

/// Defect of grains at these places with residuals of 0.03 and 0.04 times `signs`.
fn defect<const D: usize, const N: usize>(places: &[Vector<D>], signs: &[f64]) -> Defect
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(3, 0.0, false);
    let transfer = Transfer::new(&mesh, 1.0);
    let placement = transfer
        .place(places, &vec![0.0; places.len()])
        .expect("inside");
    let count = places.len();
    let grains = Grains {
        mass: vec![3.0; count],
        ..Grains::default()
    };
    let scales = Scales {
        density: 2.0,
        gravity: flat(0.0, -10.0),
        dt: 0.1,
    };
    let residual: Vec<Vector<D>> = signs.iter().map(|s| flat(0.03, 0.04) * *s).collect();
    let mean = vec![flat(1.0, 2.0); count];
    // q − γ v̄ + ρ V g = (3, 4)
    let force = vec![flat(10.0, 28.0); count];
    let vectors = [&force[..], &residual, &mean];
    measure(
        &scales,
        &transfer,
        &placement,
        &grains,
        &model(count),
        vectors,
    )
}

fn by_hand<const D: usize, const N: usize>()
where
    Dim<D>: Dimension<D>,
{
    let place = Vector::from_element(0.4);
    let one = defect::<D, N>(&[place], &[1.0]);
    // (γ + (m + ρV)/Δt) |r|
    let error = (7.0 + 40.0) * 0.05;
    // |(m − ρV) g| + |q − γ v̄ + ρ V g| and what is known of m|g| and of the slip
    let scale = 20.0 + 5.0 + 1e-7 * 30.0 + 1e-9 * 47.0 * 5.0_f64.sqrt();
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} for {b}");
    near(one.relative, error / scale);
    near(one.of_grains[0], error / scale);
    near(one.momentum, 7.0 * 0.05 / 20.0);
    // on the nodes forces of one cell cancel, in the grains they do not
    let two = defect::<D, N>(&[place, place], &[1.0, -1.0]);
    assert!(two.relative < 1e-15 && two.momentum < 1e-15);
    near(two.of_grains[1], error / scale);
    near(two.scale / one.scale, 2.0);
}

#[test]
fn the_defect_of_one_grain_is_its_force_over_its_scale() {
    by_hand::<2, 3>();
    by_hand::<3, 4>();
}

#[test]
fn round_off_of_the_forces_is_no_defect() {
    let scales = Scales {
        density: 1.0,
        gravity: flat::<2>(0.0, 0.0),
        dt: 1.0,
    };
    let mesh = cube::<2, 3>(2, 0.0, false);
    let transfer = Transfer::new(&mesh, 1.0);
    let placement = transfer
        .place(&[Vector::from([0.3, 0.3])], &[0.0])
        .expect("inside");
    let grains = Grains {
        mass: vec![0.5],
        ..Grains::default()
    };
    // it drifts with the fluid: q = γ v̄, and its slip is known to 1e-9
    let drift = [flat::<2>(3.0, 4.0)];
    let (force, residual) = ([drift[0] * 7.0], [drift[0] * 1e-12]);
    let vectors = [&force[..], &residual, &drift];
    let found = measure(&scales, &transfer, &placement, &grains, &model(1), vectors);
    assert!((found.relative / 1e-3 - 1.0).abs() < 1e-6, "{found:?}");
}

#[test]
fn the_norm_weighs_with_the_nodal_mass() {
    assert_eq!(nodal_norm(&[4.0, 9.0], &[2.0, 1.0]), 5.0);
    assert_eq!(
        nodal_norm(&[1.0, 4.0], &[flat::<2>(3.0, 4.0), flat(0.0, 6.0)]),
        13.0
    );
}

#[test]
fn what_is_owed_is_the_residual_and_the_lagged_pressure_force() {
    let pass = |relative: f64| Pass {
        flow: Flow::<2>::default(),
        force: Vec::new(),
        grains: Candidate::default(),
        residual: vec![flat(1.0, -2.0)],
        defect: Defect {
            relative,
            ..Defect::default()
        },
    };
    let lagged = [flat::<2>(0.5, 0.25)];
    let owed = |relative| carried_force(&pass(relative), &[3.0], &lagged)[0];
    assert_eq!(owed(1e-3), flat::<2>(3.5, -5.75));
    assert_eq!(owed(9.9e-3), flat::<2>(3.5, -5.75));
    // above it the carry would amplify
    assert_eq!(owed(1.1e-2), lagged[0]);
    let mesh = cube::<2, 3>(2, 0.0, false);
    let transfer = Transfer::new(&mesh, 1.0);
    let placement = transfer
        .place(&[Vector::from([0.3, 0.6])], &[0.0])
        .expect("inside");
    let uniform = |gradient: Vector<2>| Flow {
        velocity: Vec::new(),
        pressure_gradient: vec![gradient; transfer.node_count()],
    };
    let (old, new) = (uniform(flat(5.0, 1.0)), uniform(flat(1.0, -1.0)));
    let found = lagged_pressure_force(&transfer, &placement, &model(1), &old, &new)[0];
    // V A (G* − G), A = λ γ D = 0.35
    assert!((found - flat(0.5 * 0.35 * 4.0, 0.5 * 0.35 * 2.0)).norm() < 1e-15);
}
