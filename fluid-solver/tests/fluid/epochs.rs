//! Meshes that are graded, and that change between steps: the orders of the uniform mesh are kept.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::{FluidConfig, Nonlinear, TimeScheme};
use fluid_solver::equations::manufactured::{Exact, lethe, suspension};
use fluid_solver::mesh::{Place, Root, Zone};
use fluid_solver::refined::{self, Refined, Refinement};
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;
use space::Vector;

use crate::support::order;

const NEWTON: Nonlinear = Nonlinear::Newton {
    tolerance: 1e-11,
    iterations_max: 20,
};

/// A square of n × n cells.
fn root(lower: f64, n: usize) -> Root<2> {
    Root {
        lower: [lower; 2].into(),
        upper: [1.0; 2].into(),
        cells: [n; 2],
        periodic: [false; 2],
    }
}

/// Cells a quarter as large in a disk around this point.
fn fine(root: &Root<2>, centre: [f64; 2]) -> Refinement<2> {
    let place = Place::Ball {
        centre: centre.into(),
        radius: 0.15,
    };
    let size = 0.25 * root.size();
    Refinement {
        zones: vec![Zone { place, size }],
        growth: 0.5,
        largest: None,
    }
}

fn at_rest(root: &Root<2>) -> Refinement<2> {
    Refinement {
        zones: Vec::new(),
        ..fine(root, [0.0; 2])
    }
}

#[test]
fn a_graded_mesh_has_the_orders_of_a_uniform_one() {
    println!("flow         mesh      n  nodes   error v    error p   order v, p");
    let flows = [
        ("lethe 2", lethe(2), -1.0),
        ("β = 1e6", suspension(1e6, true), 0.0),
    ];
    for (name, exact, lower) in flows {
        for graded in [false, true] {
            let mut last: Option<(f64, f64)> = None;
            for n in [12, 24, 48] {
                let root = root(lower, n);
                let sizes = match graded {
                    true => fine(&root, [0.3, 0.4]),
                    false => at_rest(&root),
                };
                let mut config = exact.config();
                config.time_scheme = TimeScheme::Steady;
                config.nonlinear = NEWTON;
                let (mut solver, _) = refined::solver(config, &root, &sizes).unwrap();
                exact.step(&mut solver, 0.3).unwrap();
                let (ev, ep) = exact.errors(&solver, 0.3);
                let orders = last.map(|(v, p)| (order(v, ev), order(p, ep)));
                let (mesh, nodes) = (
                    if graded { "graded" } else { "uniform" },
                    solver.mesh().node_count(),
                );
                println!("{name:<10}  {mesh:<8} {n:3} {nodes:6}  {ev:.3e}  {ep:.3e}  {orders:.2?}");
                if n == 48 {
                    let (v, p) = orders.unwrap();
                    assert!(v >= 1.9 && p >= 1.5, "orders {v} {p}");
                }
                last = Some((ev, ep));
            }
        }
    }
}

/// Where the fine cells are at a time.
fn centre(t: f64) -> [f64; 2] {
    [0.3 + 0.8 * t, 0.5 + 0.4 * t]
}

/// The flow through grains of changing porosity from t = 0 to 0.5, in so many steps; the mesh follows after every
/// `every`-th, or never. Its errors at the end, and the solver.
fn moving(
    exact: Exact<2, 3>,
    n: usize,
    steps: usize,
    every: Option<usize>,
    scheme: TimeScheme,
) -> (FluidSolver<2, 3>, f64, f64) {
    let root = root(0.0, n);
    let mut config = exact.config();
    config.time_scheme = scheme;
    let first = fine(&root, centre(0.0));
    let (mut solver, mut follows): (_, Refined<2, 3>) =
        refined::solver(config, &root, &first).unwrap();
    let start = exact.start(solver.mesh());
    solver.set_state(start);
    let dt = 0.5 / steps as f64;
    let mut epochs = 1;
    for step in 0..steps {
        if every.is_some_and(|every| step > 0 && step % every == 0) {
            let time = solver.state().time;
            follows
                .adapt(&mut solver, &fine(&root, centre(time)))
                .unwrap();
            epochs += 1;
        }
        exact.step(&mut solver, dt).unwrap();
    }
    let (ev, ep) = exact.errors(&solver, 0.5);
    let nodes = solver.mesh().node_count();
    println!("{n:3} {nodes:6} nodes {steps:4} steps {epochs:3} epochs  {ev:.3e}  {ep:.3e}");
    (solver, ev, ep)
}

#[test]
fn an_epoch_every_five_steps_keeps_the_orders_in_space() {
    let exact = suspension(10.0, false);
    for every in [None, Some(5)] {
        let mut last: Option<(f64, f64)> = None;
        for (n, steps) in [(8, 20), (16, 40), (32, 80)] {
            let (_, ev, ep) = moving(exact, n, steps, every, TimeScheme::Bdf2);
            let orders = last.map(|(v, p)| (order(v, ev), order(p, ep)));
            println!("order v, p: {orders:.2?}");
            if n == 32 {
                let (v, p) = orders.unwrap();
                assert!(v >= 1.9 && p >= 1.5, "orders {v} {p}");
            }
            last = Some((ev, ep));
        }
    }
}

#[test]
fn bdf2_is_second_order_in_time_through_epochs() {
    // Against a fine step with the same meshes at the same times: the errors in space cancel where 12μ/h² ≫ ρ/Δt,
    // as τ depends on Δt.
    let mut exact = suspension(10.0, false);
    exact.viscosity = 1.0;
    const EPOCHS: usize = 4;
    let end = |steps: usize| {
        let (solver, ..) = moving(exact, 32, steps, Some(steps / EPOCHS), TimeScheme::Bdf2);
        solver.state().now.interstitial_velocity()
    };
    let reference = end(256);
    let mut last: Option<f64> = None;
    for steps in [8, 16, 32] {
        let v: Vec<Vector<2>> = end(steps);
        let square: f64 = v
            .iter()
            .zip(&reference)
            .map(|(a, b)| (a - b).norm_squared())
            .sum();
        let error = (square / v.len() as f64).sqrt();
        let observed = last.map(|coarse| order(coarse, error));
        println!("{steps:3} steps  {error:.3e}  {observed:.2?}");
        if steps == 32 {
            assert!(observed.unwrap() >= 1.9);
        }
        last = Some(error);
    }
}

#[test]
fn a_linear_velocity_and_pressure_are_carried_over_as_they_are() {
    let root = root(0.0, 6);
    let exact = suspension(10.0, false);
    let first = fine(&root, [0.2, 0.3]);
    let (mut solver, mut follows) = refined::solver(exact.config(), &root, &first).unwrap();
    let mut start = exact.start(solver.mesh());
    let velocity = |x: &Vector<2>| Vector::from([1.0 + 2.0 * x[0] - x[1], 0.5 - 3.0 * x[1]]);
    for (node, x) in solver.mesh().position.iter().enumerate() {
        start.now.porosity[node] = 0.6 + 0.3 * x[0];
        start.now.superficial_velocity[node] = velocity(x) * start.now.porosity[node];
        start.pressure[node] = 7.0 - 2.0 * x[0] + x[1];
    }
    start.before = Some((start.now.clone(), 0.1));
    solver.set_state(start);
    follows
        .adapt(&mut solver, &fine(&root, [0.8, 0.6]))
        .unwrap();
    let (mut worst, state) = (0.0_f64, solver.state());
    let before = state.before.as_ref().unwrap();
    assert_eq!(before.1, 0.1);
    for (node, x) in solver.mesh().position.iter().enumerate() {
        for flow in [&state.now, &before.0] {
            let v = flow.superficial_velocity[node] / flow.porosity[node];
            worst = worst.max((v - velocity(x)).norm());
            worst = worst.max((flow.porosity[node] - 0.6 - 0.3 * x[0]).abs());
        }
        worst = worst.max((state.pressure[node] - 7.0 + 2.0 * x[0] - x[1]).abs());
    }
    println!("{} nodes, worst {worst:.1e}", solver.mesh().node_count());
    assert!(worst < 1e-13);
    // wishes that no memory holds leave all as it is
    let mut many = fine(&root, [0.5; 2]);
    many.zones[0].size = 1e-5;
    let words = follows.adapt(&mut solver, &many).unwrap_err().to_string();
    println!("{words}");
    assert!(words.contains("ask for larger ones"));
}

/// Flow up a channel through a held oblique layer, from rest: the pressure drop of every step.
fn through_a_layer(drag: f64, every: Option<usize>) -> (Vec<f64>, usize) {
    let root = Root {
        lower: [0.0, 0.0].into(),
        upper: [1.0, 4.0].into(),
        cells: [4, 16],
        periodic: [false; 2],
    };
    let config = FluidConfig::new(1.0, 1.0)
        .with("all", Condition::Slip)
        .with("bottom", Condition::uniform([0.0, 1.0]))
        .with("top", Condition::Open(0.0));
    // the edges of the layer are resolved throughout; a disk of still smaller cells goes up through it
    let sizes = |k: usize| Refinement {
        zones: vec![
            Zone {
                place: Place::Box {
                    lower: [0.0, 0.5].into(),
                    upper: [1.0, 3.5].into(),
                },
                size: 1.0 / 16.0,
            },
            Zone {
                place: Place::Ball {
                    centre: [0.5, 0.8 + 0.2 * k as f64].into(),
                    radius: 0.3,
                },
                size: 1.0 / 32.0,
            },
        ],
        growth: 0.5,
        largest: None,
    };
    let (mut solver, mut follows): (FluidSolver<2, 3>, _) =
        refined::solver(config, &root, &sizes(0)).unwrap();
    let mut drops = Vec::new();
    let mut epochs = 1;
    for step in 0..30 {
        if every.is_some_and(|every| step > 0 && step % every == 0) {
            follows.adapt(&mut solver, &sizes(epochs)).unwrap();
            epochs += 1;
        }
        // 0 to 1 within a quarter, so that every mesh holds the same layer
        let held = |x: &Vector<2>| {
            let along = x[1] + 0.7 * x[0];
            (4.0 * (along - 1.5))
                .clamp(0.0, 1.0)
                .min((4.0 * (3.2 - along)).clamp(0.0, 1.0))
        };
        let held: Vec<f64> = solver.mesh().position.iter().map(held).collect();
        let beta: Vec<f64> = held.iter().map(|h| h * drag).collect();
        let porosity: Vec<f64> = held.iter().map(|h| 1.0 - 0.6 * h).collect();
        let fields = SolidFields {
            porosity: Some(&porosity),
            drag: Some(&beta),
            fixed_drag: Some(&beta),
            ..SolidFields::default()
        };
        let candidate = solver.advance(&Request::first(1, 0.1), &fields).unwrap();
        drops.push(candidate.number("pressure_drop").unwrap());
        solver.commit().unwrap();
    }
    (drops, epochs)
}

#[test]
fn a_held_layer_drops_the_pressure_as_on_a_fixed_mesh_while_epochs_move_through_it() {
    println!("βΔt/ρ   epochs  drop [Pa]    largest difference of a step");
    for drag in [1e5, 1e7, 1e9] {
        let (fixed, _) = through_a_layer(drag, None);
        let (moving, epochs) = through_a_layer(drag, Some(3));
        let differences = fixed.iter().zip(&moving).map(|(a, b)| (b / a - 1.0).abs());
        let worst = differences.fold(0.0, f64::max);
        println!(
            "{:.0e}    {epochs}      {:.4e}   {worst:.1e}",
            0.1 * drag,
            fixed[29]
        );
        assert!(worst < 0.01);
    }
}
