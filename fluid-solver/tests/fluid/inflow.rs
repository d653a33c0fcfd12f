//! What flows in is what was asked for, on every mesh and beside every neighbour, and flows out again.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::{Candidate, Request};
use fluid_solver::config::FluidConfig;
use fluid_solver::mesh::{Mesh, Rectangle};
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;

const HEIGHT: f64 = 0.01;
const LENGTH: f64 = 0.03;
const SPEED: f64 = 0.01;
const MESHES: [[usize; 2]; 4] = [[1, 1], [12, 4], [24, 8], [48, 16]];

fn mesh(cells: [usize; 2], periodic: bool) -> Mesh<2, 3> {
    let mut rectangle = Rectangle::new([0.0; 2], [LENGTH, HEIGHT], cells);
    rectangle.periodic = [false, periodic];
    rectangle.mesh().unwrap()
}

/// Water with an inflow on the left, these two beside it, and an open side on the right.
fn through(
    mesh: Mesh<2, 3>,
    inflow: Condition<2>,
    beside: [Condition<2>; 2],
    dt: f64,
) -> Candidate<2> {
    let [bottom, top] = beside;
    let mut config = FluidConfig::new(1000.0, 1e-3)
        .with("left", inflow)
        .with("right", Condition::Open(0.0))
        .with("bottom", bottom)
        .with("top", top);
    config.gravity = [0.0, -9.81].into();
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    let candidate = solver.advance(&Request::first(1, dt), &SolidFields::default());
    candidate.unwrap().clone()
}

fn inflows() -> [(&'static str, Condition<2>, f64); 3] {
    let step = |_: space::Vector<2>, _: f64| [SPEED, 2.0 * SPEED].into();
    [
        ("uniform", Condition::uniform([SPEED, 0.0]), SPEED * HEIGHT),
        (
            "parabolic",
            Condition::Parabolic([1.5 * SPEED, 0.0].into()),
            SPEED * HEIGHT,
        ),
        (
            "function",
            Condition::Function(std::sync::Arc::new(step)),
            SPEED * HEIGHT,
        ),
    ]
}

/// Neighbours with what they add to the inflow.
fn neighbours() -> Vec<(&'static str, Condition<2>, f64)> {
    let jet = Condition::Parabolic([0.0, 0.3 * SPEED].into());
    vec![
        ("no-slip", Condition::NoSlip, 0.0),
        ("slip", Condition::Slip, 0.0),
        ("open", Condition::Open(0.0), 0.0),
        ("moving", Condition::uniform([0.7 * SPEED, 0.0]), 0.0),
        (
            "belt",
            Condition::MovingWall([0.7 * SPEED, 0.0].into()),
            0.0,
        ),
        ("inflow", jet, 0.2 * SPEED * LENGTH),
        ("periodic", Condition::Periodic, 0.0),
    ]
}

#[test]
fn every_mesh_takes_in_what_is_asked_for_whatever_the_neighbours_are_and_lets_it_out() {
    println!("inflow      below     above     cells      inflow          error    in - out");
    let mut pairs = Vec::new();
    for (below, one, more) in neighbours() {
        for (above, other, _) in neighbours() {
            // A second jet would leave by the top, so the top has none; periodic sides are two.
            if above != "inflow" && (above == "periodic") == (below == "periodic") {
                pairs.push((below, one.clone(), more, above, other));
            }
        }
    }
    for (profile, inflow, asked) in inflows() {
        for (below, one, more, above, other) in &pairs {
            for cells in MESHES {
                let mesh = mesh(cells, *below == "periodic");
                let beside = [one.clone(), other.clone()];
                let found = through(mesh, inflow.clone(), beside, 0.1);
                let (entered, left) = (found.number("inflow"), found.number("outflow"));
                let (entered, left) = (entered.unwrap(), left.unwrap());
                let asked = asked + more;
                let (error, kept) = (entered / asked - 1.0, (entered - left) / asked);
                println!(
                    "{profile:10}  {below:8}  {above:8}  {cells:?}  {entered:.9e}  {error:+.0e}  {kept:+.0e}"
                );
                assert!(error.abs() < 1e-13 && kept.abs() < 1e-11);
                let powers = &found.powers;
                assert!(powers.defect().abs() < 1e-9 * powers.scale());
            }
        }
    }
}

/// What passes the middle of a channel between walls, by the velocity of its nodes.
#[test]
fn all_of_the_inflow_passes_a_channel_between_walls() {
    println!("cells     middle/asked");
    for cells in [[12, 4], [24, 8], [48, 16]] {
        let mesh = mesh(cells, false);
        let (row, mass) = (cells[0] + 1, mesh.nodal_mass.clone());
        let found = through(
            mesh,
            Condition::uniform([SPEED, 0.0]),
            [Condition::NoSlip, Condition::NoSlip],
            1e3,
        );
        let inner = |n: &usize| (n % row) * 4 >= cells[0] && (n % row) * 4 <= 3 * cells[0];
        let u = &found.state.now.superficial_velocity;
        let nodes = || (0..mass.len()).filter(inner);
        let flow: f64 = nodes().map(|n| mass[n] * u[n][0]).sum();
        let size: f64 = nodes().map(|n| mass[n]).sum();
        let share = flow / size / SPEED;
        println!("{cells:?}  {share:.6}");
        assert!((share - 1.0).abs() * (cells[1] as f64) < 0.15);
    }
}

/// A bed between no-slip sides: its layer at the wall is far thinner than a cell, and its pressure falls as
/// between slip sides.
#[test]
fn the_pressure_drop_of_a_bed_between_walls_is_that_of_the_asked_flow() {
    println!("cells     pressure drop   error");
    for cells in [[6, 2], [14, 7], [48, 16]] {
        let mesh = mesh(cells, false);
        let n = mesh.node_count();
        let (porosity, drag) = (vec![0.4; n], vec![1e7; n]);
        let fields = SolidFields {
            porosity: Some(&porosity),
            drag: Some(&drag),
            ..SolidFields::default()
        };
        let config = FluidConfig::new(1000.0, 1e-3)
            .with("all", Condition::NoSlip)
            .with("left", Condition::uniform([SPEED, 0.0]))
            .with("right", Condition::Open(0.0));
        let mut solver = FluidSolver::new(config, mesh).unwrap();
        let found = solver.advance(&Request::first(1, 1.0), &fields).unwrap();
        let drop = found.number("pressure_drop").unwrap();
        let error = drop / (1e7 * SPEED / 0.16 * LENGTH) - 1.0;
        println!("{cells:?}  {drop:.6e}  {error:+.1e}");
        assert!(error.abs() < 0.02);
    }
}

/// A parabola in and a uniform flow out leave nothing over, on any mesh.
#[test]
fn profiles_balance_in_a_closed_domain() {
    for cells in [[6, 2], [12, 4], [24, 7]] {
        let config = FluidConfig::new(1000.0, 1e-3)
            .with("all", Condition::NoSlip)
            .with("left", Condition::Parabolic([1.5 * SPEED, 0.0].into()))
            .with("right", Condition::uniform([SPEED, 0.0]));
        let mut solver = FluidSolver::new(config, mesh(cells, false)).unwrap();
        let found = solver.advance(&Request::first(1, 0.1), &SolidFields::default());
        let entered = found.unwrap().number("inflow").unwrap();
        println!("{cells:?}: {entered:e} m²/s");
        assert!((entered / (SPEED * HEIGHT) - 1.0).abs() < 1e-13);
    }
}

/// Two vessels that do not touch, flat cells in both: each has its own pressure, and its own balance.
#[test]
fn parts_that_do_not_touch_are_solved_each_for_itself() {
    let mut rectangle = Rectangle::new([0.0; 2], [1.0, 1.0], [30, 30]);
    rectangle.grading = [1.0, 100.0].into();
    let one = rectangle.mesh().unwrap();
    let n = one.node_count();
    let mut position = one.position.clone();
    position.extend(
        one.position
            .iter()
            .map(|x| x + space::Vector::from([3.0, 0.5])),
    );
    let mut simplices = one.simplices.clone();
    simplices.extend(one.simplices.iter().map(|t| t.map(|node| node + n)));
    let names = ["left", "right", "bottom", "top", "lid"];
    let mut named: Vec<([usize; 2], usize)> =
        one.facets.iter().map(|f| (f.node, f.boundary)).collect();
    let beside = one
        .facets
        .iter()
        .map(|f| (f.node.map(|node| node + n), f.boundary));
    named.extend(beside.map(|(nodes, boundary)| (nodes, if boundary == 3 { 4 } else { boundary })));
    let names = names.map(String::from).to_vec();
    let both: Mesh<2, 3> = Mesh::new(position, simplices, names, &named, |t| t).unwrap();
    let mut config = FluidConfig::new(1000.0, 1e-3).with("all", Condition::NoSlip);
    config = config.with("lid", Condition::uniform([1e-3, 0.0]));
    config.gravity = [0.0, -9.81].into();
    let mut solver = FluidSolver::new(config, both).unwrap();
    let found = solver.advance(&Request::first(1, 0.1), &SolidFields::default());
    let state = found.unwrap().state.clone();
    let speed = |nodes: std::ops::Range<usize>| {
        let u = state.now.superficial_velocity[nodes].iter();
        u.map(|u| u.norm()).fold(0.0, f64::max)
    };
    let (still, stirred) = (speed(0..n), speed(n..2 * n));
    println!(
        "{still:e} {stirred:e} m/s; pressures {:e} {:e}",
        state.pressure[0], state.pressure[n]
    );
    assert!(still < 1e-9 && (stirred - 1e-3).abs() < 1e-12);
    assert_eq!((state.pressure[0], state.pressure[n]), (0.0, 0.0));
}
