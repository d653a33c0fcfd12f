//! Convection is left out while the flow creeps, and comes back in the step that does not.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::{Candidate, Request};
use fluid_solver::config::FluidConfig;
use fluid_solver::mesh::Rectangle;
use fluid_solver::solid::SolidFields;
use fluid_solver::state::State;
use fluid_solver::step::FluidSolver;
use protocol::scene::CREEPING_REYNOLDS;

const DT: f64 = 0.01;
/// A lid whose flow needs convection some steps after it began to move, not in the first.
const LID: f64 = 1.672e-2;

/// A cavity at rest whose lid begins to move.
fn cavity(lid: f64, creeping_below: Option<f64>) -> FluidSolver<2, 3> {
    let mesh = Rectangle::new([0.0; 2], [1.0; 2], [12, 12]).mesh().unwrap();
    let mut config = FluidConfig::new(1.0, 1.0)
        .with("all", Condition::NoSlip)
        .with("top", Condition::uniform([lid, 0.0]));
    config.creeping_below = creeping_below;
    FluidSolver::new(config, mesh).unwrap()
}

fn step(solver: &mut FluidSolver<2, 3>) -> Candidate<2> {
    let candidate = solver
        .advance(&Request::first(1, DT), &SolidFields::default())
        .unwrap()
        .clone();
    solver.commit().unwrap();
    candidate
}

/// ‖a − b‖ over ‖b‖ of the velocity.
fn difference(a: &State<2>, b: &State<2>) -> f64 {
    let pairs = a
        .now
        .superficial_velocity
        .iter()
        .zip(&b.now.superficial_velocity);
    let (mut error, mut size) = (0.0, 0.0);
    for (a, b) in pairs {
        error += (a - b).norm_squared();
        size += b.norm_squared();
    }
    f64::sqrt(error / size)
}

#[test]
fn what_is_left_out_changes_the_flow_by_less_than_its_reynolds_number() {
    println!("lid      steps  Re        change of v  factors");
    for lid in [1e-4, 1e-3, 1e-2] {
        let (mut as_needed, mut always) = (cavity(lid, Some(1.0)), cavity(lid, None));
        let (mut factors, mut reynolds) = (0.0, 0.0);
        for _ in 0..20 {
            let candidate = step(&mut as_needed);
            step(&mut always);
            assert_eq!(candidate.number("convection"), Some(0.0));
            factors += candidate.number("factorised").unwrap();
            reynolds = candidate.number("reynolds").unwrap();
        }
        let change = difference(as_needed.state(), always.state());
        println!("{lid:.1e}  20     {reynolds:.2e}  {change:.2e}     {factors}");
        assert!(change < reynolds && change > 1e-3 * reynolds);
        assert_eq!(factors, 1.0, "the matrix stays the same");
    }
}

#[test]
fn convection_comes_back_in_the_step_that_needs_it_and_stays() {
    let folder = tempfile::tempdir().unwrap();
    let mut solver = cavity(LID, Some(CREEPING_REYNOLDS));
    let mut since = None;
    println!("step  convection  Re");
    for number in 1..=12 {
        let before = solver.state().clone();
        let repeated = solver
            .advance(&Request::first(1, DT), &SolidFields::default())
            .unwrap()
            .clone();
        let candidate = step(&mut solver);
        assert_eq!(
            repeated.state, candidate.state,
            "the same request, other bits"
        );
        let reynolds = candidate.number("reynolds").unwrap();
        let convection = candidate.number("convection").unwrap();
        println!("{number:<4}  {convection:<10}  {reynolds:.3e}");
        // Either the bits of the equations with convection, or a flow that may do without.
        let mut always = cavity(LID, None);
        always.set_state(before);
        let full = step(&mut always);
        assert_eq!(
            convection == 1.0,
            since.is_some() || reynolds > CREEPING_REYNOLDS
        );
        if convection == 1.0 {
            since.get_or_insert(number);
            let [a, b] = [&candidate, &full].map(|c| &c.interstitial_velocity);
            assert_eq!(a, b);
        }
        // A checkpoint knows whether it came back.
        let file = folder.path().join("state");
        solver.state().save(&file).unwrap();
        let stored = State::load(&file, solver.mesh().node_count()).unwrap();
        assert_eq!(stored.convected, since.is_some());
        solver.set_state(stored);
    }
    assert!(since.is_some_and(|step| step > 2 && step < 12), "{since:?}");
}

/// Drag that holds the fluid back.
fn held(solver: &FluidSolver<2, 3>) -> Vec<f64> {
    vec![1e4; solver.mesh().node_count()]
}

#[test]
fn a_candidate_that_is_thrown_away_leaves_no_trace() {
    let begun = || {
        let mut solver = cavity(LID, Some(CREEPING_REYNOLDS));
        step(&mut solver);
        solver
    };
    let ask = |solver: &mut FluidSolver<2, 3>, dt: f64, pass: u32| {
        let request = Request { step: 2, pass, dt };
        let candidate = solver.advance(&request, &SolidFields::default()).unwrap();
        candidate.clone()
    };
    let (mut fresh, mut disturbed) = (begun(), begun());
    let large = ask(&mut disturbed, 100.0 * DT, 0);
    println!("large step: Re {:?}", large.number("reynolds"));
    assert_eq!(large.number("convection"), Some(1.0));
    for pass in 0..2 {
        let (one, other) = (ask(&mut fresh, DT, pass), ask(&mut disturbed, DT, pass));
        assert_eq!(one.number("convection"), Some(0.0));
        assert_eq!(one.number("convection"), other.number("convection"));
        assert_eq!(one.state, other.state);
        assert_eq!(one.pressure_gradient, other.pressure_gradient);
    }
    disturbed.commit().unwrap();
    assert!(!disturbed.state().convected);
}

#[test]
fn passes_of_a_step_do_not_differ_in_their_equations() {
    let mut solver = cavity(LID, Some(CREEPING_REYNOLDS));
    step(&mut solver);
    let drag = held(&solver);
    let held = SolidFields {
        drag: Some(&drag),
        ..SolidFields::default()
    };
    let request = |pass| Request {
        step: 2,
        pass,
        dt: 100.0 * DT,
    };
    let mut convection = |pass, fields: &SolidFields<'_>| {
        let candidate = solver.advance(&request(pass), fields).unwrap();
        candidate.number("convection").unwrap()
    };
    assert_eq!(convection(1, &held), 0.0, "alone it creeps");
    assert_eq!(convection(1, &SolidFields::default()), 1.0);
    assert_eq!(
        convection(2, &held),
        1.0,
        "a later pass of a step that does not"
    );
    assert_eq!(convection(1, &held), 0.0, "the step begun again");
    assert_eq!(convection(2, &SolidFields::default()), 1.0);
    assert_eq!(convection(4, &held), 1.0);
    solver.commit().unwrap();
    assert!(solver.state().convected);
}
