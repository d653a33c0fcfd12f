//! The mean of a flow through periodic sides is what it is asked to be, and the pressure gradient that it
//! takes is the closed form.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::{FluidConfig, Nonlinear, TimeScheme};
use fluid_solver::mesh::{Mesh, Rectangle};
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;

use crate::balance::RandomSolid;
use crate::support::largest_difference;

const WATER: f64 = 1000.0;
const VISCOSITY: f64 = 1e-3;
const GRAVITY: f64 = -9.81;

fn mesh(cells: [usize; 2], periodic: [bool; 2]) -> Mesh<2, 3> {
    let mut rectangle = Rectangle::new([0.0; 2], [0.02, 0.01], cells);
    rectangle.periodic = periodic;
    rectangle.mesh().unwrap()
}

fn water(mean_flow: Option<[f64; 2]>) -> FluidConfig<2> {
    let mut config = FluidConfig::new(WATER, VISCOSITY).with("all", Condition::Periodic);
    config.gravity = [0.0, GRAVITY].into();
    config.mean_flow = mean_flow.map(Into::into);
    config
}

#[test]
fn without_sides_water_falls_unless_its_mean_flow_is_held() {
    for (mean_flow, expected) in [(None, 10.0 * GRAVITY), (Some([0.0; 2]), 0.0)] {
        let mut solver = FluidSolver::new(water(mean_flow), mesh([6, 5], [true; 2])).unwrap();
        for step in 1..=100 {
            let found = solver.advance(&Request::first(step, 0.1), &SolidFields::default());
            let gradient = found.unwrap().number("mean_pressure_gradient_y");
            let hydrostatic = mean_flow.map(|_| WATER * GRAVITY);
            assert_eq!(gradient.is_some(), hydrostatic.is_some());
            let error = gradient.zip(hydrostatic).map_or(0.0, |(g, h)| g / h - 1.0);
            assert!(error.abs() < 1e-12, "{error:e}");
            solver.commit().unwrap();
        }
        let u = &solver.state().now.superficial_velocity;
        let difference = largest_difference(u, |_| [0.0, expected].into());
        println!("{mean_flow:?}: {expected} m/s after 10 s but for {difference:e}");
        // At the end it crosses 3000 cells a step, whose convection cancels to round-off of the inertia.
        assert!(difference < 1e-10 * f64::abs(expected).max(1.0));
    }
}

#[test]
fn flow_through_a_uniform_bed_takes_the_gradient_of_its_drag() {
    println!("beta      gradient        error");
    for drag in [1e2, 1e5, 1e8] {
        let (porosity, speed) = (0.4, [3e-3, -1e-3]);
        let mesh = mesh([6, 5], [true; 2]);
        let n = mesh.node_count();
        let (phi, beta) = (vec![porosity; n], vec![drag; n]);
        let fields = SolidFields {
            porosity: Some(&phi),
            drag: Some(&beta),
            ..SolidFields::default()
        };
        let mut solver = FluidSolver::new(water(Some(speed)), mesh).unwrap();
        for step in 1..=2 {
            solver.advance(&Request::first(step, 1e9), &fields).unwrap();
            solver.commit().unwrap();
        }
        let found = solver.advance(&Request::first(3, 1e9), &fields).unwrap();
        for (axis, name) in ["x", "y"].iter().enumerate() {
            let gradient = found.number(&format!("mean_pressure_gradient_{name}"));
            let weight = [0.0, WATER * GRAVITY][axis];
            let exact = weight - drag * speed[axis] / porosity.powi(2);
            let error = gradient.unwrap() / exact - 1.0;
            println!("{drag:6.0e}  {exact:+.8e}  {error:+.0e}");
            assert!(error.abs() < 1e-9);
            let nodal = found.pressure_gradient[0][axis] / exact - 1.0;
            assert!(nodal.abs() < 1e-9);
        }
        let u = &found.state.now.superficial_velocity;
        assert!(largest_difference(u, |_| speed.into()) < 1e-12);
    }
}

#[test]
fn a_channel_takes_the_gradient_of_poiseuille() {
    println!("cells  scheme   gradient        error   order");
    for (scheme, nonlinear) in [
        (TimeScheme::Steady, Nonlinear::Picard),
        (
            TimeScheme::Bdf2,
            Nonlinear::Newton {
                tolerance: 1e-10,
                iterations_max: 20,
            },
        ),
    ] {
        let mut last = None;
        for n in [8, 16, 32] {
            let mut config = water(Some([1e-3, 0.0]));
            config = config.with("top", Condition::NoSlip);
            config = config.with("bottom", Condition::NoSlip);
            (config.time_scheme, config.nonlinear) = (scheme, nonlinear);
            config.grad_div = 0.1;
            let mut solver = FluidSolver::new(config, mesh([2 * n, n], [true, false])).unwrap();
            for step in 1..=3 {
                let request = Request::first(step, 1e6);
                solver.advance(&request, &SolidFields::default()).unwrap();
                solver.commit().unwrap();
            }
            let request = Request::first(4, 1e6);
            let found = solver.advance(&request, &SolidFields::default()).unwrap();
            let exact = -12.0 * VISCOSITY * 1e-3 / 1e-4;
            let gradient = found.number("mean_pressure_gradient_x").unwrap();
            assert_eq!(found.number("mean_pressure_gradient_y"), None);
            let error: f64 = gradient / exact - 1.0;
            let order = last.map_or(f64::NAN, |last: f64| (last / error).log2());
            println!("{n:5}  {scheme:?}  {gradient:+.8e}  {error:+.1e}  {order:.2}");
            assert!(error.abs() < 2.0 / (n * n) as f64);
            assert!(order.is_nan() || order > 1.9);
            last = Some(error);
        }
    }
}

/// Whatever the solid is, the energy identity holds with the power that drives the flow, and a second
/// pass of the same step has the same bits as a first one.
#[test]
fn steering_keeps_the_energy_identity_and_the_bits_of_a_pass() {
    println!("drag    defect/scale   driving gradient");
    for (drag, seed) in [(1e1, 1), (1e4, 2), (1e7, 3)] {
        for periodic in [[true, true], [true, false]] {
            let mesh = mesh([7, 6], periodic);
            let solid = RandomSolid::new(&mesh, drag, seed);
            let mut config = water(Some([2e-3, 0.0]));
            if !periodic[1] {
                config = config.with("top", Condition::NoSlip);
                config = config.with("bottom", Condition::Slip);
            }
            let mut solver = FluidSolver::new(config, mesh).unwrap();
            for step in 1..=2 {
                let request = Request::first(step, 1e-2);
                solver.advance(&request, &solid.fields()).unwrap();
                solver.commit().unwrap();
            }
            let request = Request::first(3, 1e-2);
            let found = solver.advance(&request, &solid.fields()).unwrap().clone();
            let (defect, scale) = (found.powers.defect(), found.powers.scale());
            let gradient = found.number("mean_pressure_gradient_x").unwrap();
            println!("{drag:.0e}  {:+.1e}  {gradient:+.6e}", defect / scale);
            assert!(defect.abs() < 1e-11 * scale);
            let again = solver.advance(&request, &solid.fields()).unwrap();
            assert_eq!(again.state, found.state);
        }
    }
}

#[test]
fn a_mean_flow_that_is_not_free_to_be_given_is_refused() {
    let refused = |config: FluidConfig<2>, periodic| {
        let error = FluidSolver::new(config, mesh([3, 3], periodic)).err();
        let message = error.expect("an error").to_string();
        println!("{message}");
        message
    };
    let shut = water(Some([0.0; 2])).with("all", Condition::NoSlip);
    assert!(refused(shut, [false; 2]).contains("no side is periodic"));
    let walls = |config: FluidConfig<2>| {
        let config = config.with("top", Condition::NoSlip);
        config.with("bottom", Condition::NoSlip)
    };
    let across = walls(water(Some([0.0, 1e-3])));
    assert!(refused(across, [true, false]).contains("must be 0"));
}
