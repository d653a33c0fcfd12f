//! What a step costs, by phase.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::FluidConfig;
use fluid_solver::mesh::Rectangle;
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;

#[test]
fn costs_are_those_of_all_candidates_since_the_last_commit() {
    let mesh = Rectangle::new([0.0; 2], [1.0; 2], [16; 2]).mesh().unwrap();
    let mut config = FluidConfig::new(1000.0, 0.1).with("all", Condition::NoSlip);
    config.convection = false;
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    const PHASES: [&str; 4] = ["assembly", "factor", "solve", "powers"];
    println!("candidate         {PHASES:?} [s]");
    let costs = |name: &str, solver: &mut FluidSolver<2, 3>, pass: u32, dt: f64| {
        let source = vec![f64::from(pass); 2 * solver.mesh().node_count()];
        let fields = SolidFields {
            drag_source: Some(&source),
            ..SolidFields::default()
        };
        let request = Request { step: 1, pass, dt };
        let candidate = solver.advance(&request, &fields).unwrap();
        let costs = PHASES.map(|phase| candidate.number(&format!("seconds_{phase}")).unwrap());
        println!("{name:<16}  {costs:?}");
        (costs, candidate.number("factorised"))
    };
    let (first, _) = costs("first pass", &mut solver, 0, 0.01);
    assert!(first.iter().all(|&seconds| seconds > 0.0));
    let (second, factorised) = costs("second pass", &mut solver, 1, 0.01);
    assert_eq!(factorised, Some(0.0), "only the right-hand side is new");
    assert_eq!(
        second[1], first[1],
        "the factor of the first pass stays paid"
    );
    assert!([0, 2, 3].iter().all(|&phase| second[phase] > first[phase]));
    let (halved, factorised) = costs("halved step", &mut solver, 0, 0.005);
    assert_eq!(factorised, Some(1.0));
    assert!((0..4).all(|phase| halved[phase] > second[phase]));
    solver.commit().unwrap();
    let (next, _) = costs("after a commit", &mut solver, 0, 0.005);
    assert_eq!(next[1], 0.0, "the same matrix");
}
