//! Steps in space that are solved by iteration: the same bits from the same accepted state, whatever was tried before,
//! and the same answer without coarser meshes.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::{Candidate, Request};
use fluid_solver::config::FluidConfig;
use fluid_solver::mesh::{Mesh, Place, Root, Zone};
use fluid_solver::refined::{self, Refined, Refinement};
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;
use space::{Vector, hypot};

type Solver = FluidSolver<3, 4>;

/// A box of water of 1 m, closed, with small cells about its middle.
fn config() -> FluidConfig<3> {
    let mut config = FluidConfig::new(1000.0, 0.1).with("all", Condition::NoSlip);
    config.gravity = Vector::from([0.0, 0.0, -9.81]);
    config
}

fn refinement(size: f64) -> Refinement<3> {
    let centre = Vector::repeat(0.5);
    let place = Place::Ball {
        centre,
        radius: 0.15,
    };
    Refinement {
        zones: vec![Zone { place, size }],
        growth: 0.4,
        largest: None,
    }
}

fn refined() -> (Solver, Refined<3, 4>) {
    let root = Root {
        lower: Vector::zeros(),
        upper: Vector::repeat(1.0),
        cells: [4; 3],
        periodic: [false; 3],
    };
    refined::solver(config(), &root, &refinement(0.02)).unwrap()
}

/// A cloud that falls, as far as `there` is not 0.
fn advance(solver: &mut Solver, request: Request, there: f64) -> Candidate<3> {
    let nodes = solver.mesh().position.iter();
    let inside = nodes.map(|x| hypot(&(x - Vector::repeat(0.5))) < 0.15);
    let share: Vec<f64> = inside
        .map(|inside| if inside { there } else { 0.0 })
        .collect();
    let times = |factor: f64| -> Vec<f64> { share.iter().map(|share| factor * share).collect() };
    let porosity: Vec<f64> = share.iter().map(|share| 1.0 - 0.2 * share).collect();
    let drag = times(1e6);
    let source: Vec<[f64; 3]> = share
        .iter()
        .map(|share| [0.0, 0.0, -300.0 * share])
        .collect();
    let entrained = times(0.199);
    let fields = SolidFields {
        porosity: Some(&porosity),
        drag: Some(&drag),
        drag_source: Some(source.as_flattened()),
        entrained_fraction: Some(&entrained),
        ..SolidFields::default()
    };
    solver.advance(&request, &fields).unwrap().clone()
}

fn iterations(candidate: &Candidate<3>) -> f64 {
    assert_eq!(candidate.number("krylov_fallbacks"), Some(0.0));
    candidate.number("krylov_iterations").unwrap()
}

#[test]
fn a_step_depends_on_the_accepted_state_alone() {
    let (mut solver, mut follows) = refined();
    let first = advance(&mut solver, Request::first(1, 0.01), 1.0);
    solver.commit().unwrap();
    let accepted = solver.state().clone();
    let second = Request::first(2, 0.01);
    // What is thrown away leaves no trace.
    advance(&mut solver, Request::first(2, 0.5), 0.3);
    advance(&mut solver, second, 0.6);
    let last = advance(&mut solver, Request { pass: 1, ..second }, 1.0);
    let (mut other, _) = refined();
    other.set_state(accepted);
    let again = advance(&mut other, Request { pass: 1, ..second }, 1.0);
    let nodes = solver.mesh().node_count();
    let (begin, further) = (iterations(&first), iterations(&last));
    println!("{nodes} nodes: {begin} iterations in the first step, {further} in the second");
    assert!(last.state == again.state && begin <= 13.0 && further <= begin);
    // A finer mesh begins where the old one ended.
    solver.commit().unwrap();
    follows.adapt(&mut solver, &refinement(0.016)).unwrap();
    let third = advance(&mut solver, Request::first(3, 0.01), 1.0);
    let nodes = solver.mesh().node_count();
    println!("{nodes} nodes: {} iterations", iterations(&third));
    assert!(iterations(&third) <= 13.0);
}

#[test]
fn coarser_meshes_change_the_iterations_and_not_the_flow() {
    let (mut solver, _) = refined();
    let with = advance(&mut solver, Request::first(1, 0.01), 1.0);
    let mesh: Mesh<3, 4> = solver.mesh().clone();
    let mut alone = FluidSolver::new(config(), mesh).unwrap();
    let without = advance(&mut alone, Request::first(1, 0.01), 1.0);
    let pairs = with.state.now.superficial_velocity.iter();
    let pairs = pairs.zip(&without.state.now.superficial_velocity);
    let (apart, most) = pairs.fold((0.0_f64, 0.0_f64), |(apart, most), (a, b)| {
        (apart.max((a - b).amax()), most.max(a.amax()))
    });
    let counts = [&with, &without].map(iterations);
    println!(
        "{counts:?} iterations, velocities {:.1e} apart",
        apart / most
    );
    assert!(counts[0] <= 13.0 && counts[1] <= 60.0 && apart < 1e-7 * most);
}

#[test]
fn fluid_rests_where_nothing_moves_it() {
    let (mut solver, _) = refined();
    for step in 1..=3 {
        let candidate = advance(&mut solver, Request::first(step, 0.1), 0.0);
        let velocity = candidate.interstitial_velocity.iter();
        let most = velocity.fold(0.0_f64, |most, v| most.max(v.amax()));
        let its = iterations(&candidate);
        println!(
            "step {step}: {its} iterations, {most:.1e} m/s of {:.1} m/s that gravity gives",
            0.981
        );
        assert!(most < 1e-9);
        solver.commit().unwrap();
    }
}
