//! Manufactured solutions in space, on Kuhn's tetrahedra of equal cells.

use fluid_solver::config::{Nonlinear, TimeScheme};
use fluid_solver::equations::manufactured::{
    Exact, lethe_in_space, straining_in_space, suspension_in_space,
};
use fluid_solver::mesh::Root;
use fluid_solver::refined::solver_on_cells;
use fluid_solver::step::FluidSolver;
use space::Vector;

use crate::support::order;

/// A cube of n cells each way.
fn cube(lower: f64, n: usize) -> Root<3> {
    Root {
        lower: Vector::repeat(lower),
        upper: Vector::repeat(1.0),
        cells: [n; 3],
        periodic: [false; 3],
    }
}

/// The steady flow on a cube.
fn steady(exact: &Exact<3, 4>, root: &Root<3>, time: f64) -> FluidSolver<3, 4> {
    let mut config = exact.config();
    config.time_scheme = TimeScheme::Steady;
    config.nonlinear = Nonlinear::Newton {
        tolerance: 1e-9,
        iterations_max: 20,
    };
    let mut solver = solver_on_cells(config, root).unwrap();
    exact.step(&mut solver, time).unwrap();
    solver
}

/// L2 errors of velocity and pressure on these cells, printed; orders between the last two.
fn errors(label: &str, exact: &Exact<3, 4>, lower: f64, cells: &[usize]) -> (Vec<f64>, [f64; 2]) {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut orders = [f64::NAN; 2];
    for &n in cells {
        let solver = steady(exact, &cube(lower, n), 0.3);
        let (ev, ep) = exact.errors(&solver, 0.3);
        if let Some((v, p)) = found.last() {
            orders = [order(*v, ev), order(*p, ep)];
        }
        let nodes = solver.mesh().node_count();
        println!("| {label} | {n} | {nodes} | {ev:.3e} | {ep:.3e} | {orders:.2?} |");
        found.push((ev, ep));
    }
    (found.into_iter().map(|(v, _)| v).collect(), orders)
}

/// L2 errors of the velocity that lethe prints for clear fluid on trilinear hexahedra (its test `mms3d_gls`): 4³ and
/// 8³ cells of (−1, 1)³.
const LETHE: [f64; 2] = [4.186e-1, 1.099e-1];

#[test]
fn velocity_in_space_is_within_three_times_lethe_q1_of_as_many_nodes() {
    println!("| case | n | nodes | error v | error p | orders |");
    let (found, _) = errors("clear fluid", &lethe_in_space(0), -1.0, &[4, 8]);
    let ratios = [found[0] / LETHE[0], found[1] / LETHE[1]];
    println!("over lethe's: {ratios:.2?}");
    assert!(ratios.iter().all(|ratio| *ratio <= 3.0));
}

/// `cargo test --release --workspace --test fluid manufactured_in_space -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn velocity_in_space_is_of_order_two_and_pressure_of_one_and_a_half() {
    println!("| case | n | nodes | error v | error p | orders |");
    for (case, label) in [
        "clear fluid",
        "porosity ½",
        "porosity varies",
        "exponential porosity",
    ]
    .into_iter()
    .enumerate()
    {
        let (_, [v, p]) = errors(label, &lethe_in_space(case), 0.0, &[8, 16, 32]);
        assert!(v >= 1.8 && p >= 1.5, "{label}: orders {v} {p}");
    }
    for drag in [1e-3, 1e3, 1e6, 1e12] {
        let label = format!("β {drag:.0e}");
        let exact = suspension_in_space(drag, true);
        let (_, [v, _]) = errors(&label, &exact, 0.0, &[4, 8, 16]);
        assert!(v >= 1.8, "{label}: order {v}");
    }
}

#[test]
fn backward_euler_is_first_and_bdf2_second_order_in_space_too() {
    let exact = straining_in_space();
    println!("| scheme | steps to ½ s | error v | order |");
    for (scheme, bound) in [(TimeScheme::BackwardEuler, 0.9), (TimeScheme::Bdf2, 1.85)] {
        let mut last: Option<f64> = None;
        for steps in [16, 32, 64] {
            let mut config = exact.config();
            config.time_scheme = scheme;
            let mut solver = solver_on_cells(config, &cube(0.0, 3)).unwrap();
            solver.set_state(exact.start(solver.mesh()));
            for _ in 0..steps {
                exact.step(&mut solver, 0.5 / f64::from(steps)).unwrap();
            }
            let (error, _) = exact.errors(&solver, 0.5);
            let observed = last.map(|coarse| order(coarse, error));
            println!("| {scheme:?} | {steps} | {error:.3e} | {observed:.2?} |");
            if steps == 64 {
                assert!(observed.unwrap() >= bound);
            }
            last = Some(error);
        }
    }
}
