//! Flows with known answers: Poiseuille, Taylor–Green, lid-driven cavity, cylinder in a channel.

use std::f64::consts::PI;
use std::path::Path;

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::{Candidate, Request};
use fluid_solver::config::{FluidConfig, Nonlinear, TimeScheme};
use fluid_solver::mesh::Rectangle;
use fluid_solver::mesh::file;
use fluid_solver::solid::SolidFields;
use fluid_solver::state::{Flow, State};
use fluid_solver::step::FluidSolver;
use space::Vector;

use crate::support::{at_nodes, errors, nodal_energy, order};

const NEWTON: Nonlinear = Nonlinear::Newton {
    tolerance: 1e-11,
    iterations_max: 40,
};

#[test]
fn poiseuille_flow_has_order_two() {
    println!(" n  error v    order  pressure drop (exact 3.2)");
    let mut last: Option<f64> = None;
    for n in [8, 16, 32] {
        let mesh = Rectangle::new([0.0; 2], [4.0, 1.0], [4 * n, n])
            .mesh()
            .unwrap();
        let mut config = FluidConfig::new(1.0, 0.1)
            .with("all", Condition::NoSlip)
            .with("left", Condition::Parabolic([1.0, 0.0].into()))
            .with("right", Condition::Open(0.0));
        config.time_scheme = TimeScheme::Steady;
        config.nonlinear = NEWTON;
        let mut solver = FluidSolver::new(config, mesh).unwrap();
        let drop = solver
            .advance(&Request::first(1, 1.0), &SolidFields::default())
            .unwrap()
            .number("pressure_drop")
            .unwrap();
        solver.commit().unwrap();
        let exact = |x: &Vector<2>| [4.0 * x[1] * (1.0 - x[1]), 0.0].into();
        let (ev, _) = errors(solver.mesh(), solver.state(), exact, |x| 0.8 * (4.0 - x[0]));
        let observed = last.map(|coarse| order(coarse, ev));
        println!("{n:2}  {ev:.3e}  {observed:.2?}  {drop:.5}");
        if n == 32 {
            assert!(observed.unwrap() >= 1.9 && (drop / 3.2 - 1.0).abs() < 0.01);
        }
        last = Some(ev);
    }
}

/// Taylor–Green vortices in a slip box [0, π]², decaying as exp(−2νt): state at t = 1.
fn taylor_green(n: usize, dt: f64, viscosity: f64) -> FluidSolver<2, 3> {
    let mesh = Rectangle::new([0.0; 2], [PI; 2], [n; 2]).mesh().unwrap();
    let mut config = FluidConfig::new(1.0, viscosity).with("all", Condition::Slip);
    config.time_scheme = TimeScheme::Bdf2;
    let flow = |t: f64| {
        let decay = (-2.0 * viscosity * t).exp();
        let velocity = |x: &Vector<2>| {
            Vector::from([
                x[0].sin() * x[1].cos() * decay,
                -x[0].cos() * x[1].sin() * decay,
            ])
        };
        Flow {
            superficial_velocity: at_nodes(&mesh, velocity),
            porosity: vec![1.0; mesh.node_count()],
        }
    };
    let before = Some((flow(-dt), dt));
    let (now, pressure) = (flow(0.0), vec![0.0; mesh.node_count()]);
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    solver.set_state(State {
        time: 0.0,
        fresh: false,
        now,
        before,
        pressure,
        convected: false,
        mesh_change: None,
    });
    for _ in 0..(1.0 / dt).round() as usize {
        solver
            .advance(&Request::first(1, dt), &SolidFields::default())
            .unwrap();
        solver.commit().unwrap();
    }
    solver
}

#[test]
fn taylor_green_vortices_decay_with_order_two_in_space_and_time() {
    println!(" n   dt      error v    order  energy/exact - 1");
    let mut last: Option<f64> = None;
    for n in [16, 32, 64] {
        let viscosity = 0.05;
        let solver = taylor_green(n, 0.05, viscosity);
        let decay = (-2.0 * viscosity).exp();
        let velocity = |x: &Vector<2>| {
            Vector::from([
                x[0].sin() * x[1].cos() * decay,
                -x[0].cos() * x[1].sin() * decay,
            ])
        };
        let (ev, _) = errors(solver.mesh(), solver.state(), velocity, |_| 0.0);
        let energy = nodal_energy(solver.mesh(), &solver.state().now.interstitial_velocity());
        let exact = PI * PI / 4.0 * decay * decay;
        let observed = last.map(|coarse| order(coarse, ev));
        println!(
            "{n:2}  0.05   {ev:.3e}  {observed:.2?}  {:+.2e}",
            energy / exact - 1.0
        );
        assert!(n < 64 || observed.unwrap() >= 1.9);
        last = Some(ev);
    }
    println!(" n   dt      against dt/8 of the finest, same mesh");
    let reference = taylor_green(24, 1.0 / 160.0, 0.5).state().now.clone();
    let mut last: Option<f64> = None;
    for steps in [5, 10, 20] {
        let solver = taylor_green(24, 1.0 / f64::from(steps), 0.5);
        let pairs = solver
            .state()
            .now
            .superficial_velocity
            .iter()
            .zip(&reference.superficial_velocity);
        let square: f64 = pairs
            .map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2))
            .sum();
        let error = (square / reference.porosity.len() as f64).sqrt();
        let observed = last.map(|coarse| order(coarse, error));
        println!("24  1/{steps:<3}  {error:.3e}  {observed:.2?}");
        assert!(steps < 20 || observed.unwrap() >= 1.9);
        last = Some(error);
    }
}

/// Steady lid-driven cavity: u on the vertical centre line as (y, u), started from `from`.
fn cavity(n: usize, reynolds: f64, from: Option<State<2>>) -> (Vec<(f64, f64)>, State<2>) {
    let mut rectangle = Rectangle::new([0.0; 2], [1.0; 2], [n; 2]);
    rectangle.grading = [4.0; 2].into();
    let mut config = FluidConfig::new(1.0, 1.0 / reynolds)
        .with("all", Condition::NoSlip)
        .with("top", Condition::uniform([1.0, 0.0]));
    config.time_scheme = TimeScheme::Steady;
    config.nonlinear = NEWTON;
    config.grad_div = 0.1;
    let mut solver = FluidSolver::new(config, rectangle.mesh().unwrap()).unwrap();
    if let Some(state) = from {
        solver.set_state(state);
    }
    solver
        .advance(&Request::first(1, 1.0), &SolidFields::default())
        .unwrap();
    solver.commit().unwrap();
    let state = solver.state().clone();
    let nodes = solver
        .mesh()
        .position
        .iter()
        .zip(&state.now.superficial_velocity);
    let line = nodes
        .filter(|(x, _)| (x[0] - 0.5).abs() < 1e-9)
        .map(|(x, u)| (x[1], u[0]))
        .collect();
    (line, state)
}

/// Minimum of the parabola through the smallest value and its neighbours.
fn minimum(line: &[(f64, f64)]) -> f64 {
    let at = (1..line.len() - 1)
        .min_by(|&a, &b| line[a].1.total_cmp(&line[b].1))
        .unwrap();
    let [(a, fa), (b, fb), (c, fc)] = [line[at - 1], line[at], line[at + 1]];
    let (left, right) = ((fb - fa) / (b - a), (fc - fb) / (c - b));
    let curvature = (right - left) / (c - a);
    let middle = left + curvature * (b - a);
    fb - middle * middle / (4.0 * curvature)
}

#[test]
fn cavity_flow_has_the_published_extremum() {
    // Smallest u on the vertical centre line: Ghia et al. 1982 (table I, 129² multigrid), and the
    // later accurate values of Marchi et al. 2009 (Re 100, 400: 1024² extrapolated) and Botella
    // and Peyret 1998 (Re 1000, spectral). Ghia's own error is 1.5 % at Re 100 and 1000, so that
    // the accurate values are met to 1 % and Ghia's to 2 %.
    let table = [
        (100.0, -0.21090, -0.214_042),
        (400.0, -0.32726, -0.328_73),
        (1000.0, -0.38289, -0.388_57),
    ];
    println!("  Re  smallest u  Ghia     ratio   accurate  ratio");
    let mut state = None;
    for (reynolds, ghia, accurate) in table {
        let (line, next) = cavity(64, reynolds, state);
        let smallest = minimum(&line);
        println!(
            "{reynolds:4}  {smallest:.5}    {ghia:.5}  {:.4}  {accurate:.5}  {:.4}",
            smallest / ghia,
            smallest / accurate
        );
        assert!((smallest / accurate - 1.0).abs() <= 0.01);
        assert!((smallest / ghia - 1.0).abs() <= 0.02);
        state = Some(next);
    }
}

/// DFG 2D-1 (Schäfer and Turek 1996), Re = 20: drag and lift coefficients.
fn cylinder(file: &str) -> (usize, f64, f64, Candidate<2>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenes/meshes")
        .join(file);
    let mesh = file::read::<2, 3>(&path, &gmsh::Options::default(), |_| true).unwrap();
    let body = mesh.boundary("cylinder").unwrap();
    let nodes = mesh.node_count();
    let mut config = FluidConfig::new(1.0, 1e-3)
        .with("all", Condition::NoSlip)
        .with("inlet", Condition::Parabolic([0.3, 0.0].into()))
        .with("outlet", Condition::Open(0.0));
    config.time_scheme = TimeScheme::Steady;
    config.nonlinear = NEWTON;
    config.grad_div = 0.1;
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    let candidate = solver
        .advance(&Request::first(1, 1.0), &SolidFields::default())
        .unwrap()
        .clone();
    let scale = 2.0 / (0.2 * 0.2 * 0.1);
    let [drag, lift] = (candidate.forces[body] * scale).into();
    println!("nodes   c_d      c_l       iterations  drop");
    println!(
        "{nodes}  {drag:.5}  {lift:.6}  {}  {:.5}",
        candidate.number("iterations").unwrap(),
        candidate.number("pressure_drop").unwrap()
    );
    (nodes, drag, lift, candidate)
}

// c_d = 5.57953523384, c_l = 0.010618948146 (Nabh 1998, FEATFLOW).

#[test]
fn cylinder_forces_on_a_coarse_mesh_are_close() {
    let (_, drag, lift, candidate) = cylinder("cylinder-coarse.msh");
    assert!((drag - 5.5795).abs() <= 0.03 && (lift - 0.0106).abs() <= 1e-3);
    assert!(candidate.powers.defect().abs() <= 1e-9 * candidate.powers.scale());
}

#[test]
#[ignore = "takes 5 s: cargo test --release -p fluid-solver -- --ignored cylinder --nocapture"]
fn cylinder_forces_are_the_published_ones() {
    let (nodes, drag, lift, _) = cylinder("cylinder.msh");
    assert!(nodes <= 25_000);
    assert!((drag - 5.5795).abs() <= 0.01 && (lift - 0.0106).abs() <= 3e-4);
}
