//! Manufactured solutions: the source comes from exact derivatives, so that every term of the
//! equations is exercised.

use fluid_solver::config::{Nonlinear, TimeScheme};
use fluid_solver::equations::manufactured::{lethe, suspension};
use fluid_solver::mesh::Rectangle;
use fluid_solver::step::FluidSolver;
use space::Vector;

use crate::support::order;

const NEWTON: Nonlinear = Nonlinear::Newton {
    tolerance: 1e-11,
    iterations_max: 20,
};

#[test]
fn velocity_is_within_twice_lethe_q1_with_orders_two_and_one_and_a_half() {
    // L2 velocity errors printed by lethe's lethe-fluid-vans tests case0_vans_A … case2_vans_A.
    let published = [
        [3.790e-2, 1.010e-2, 2.595e-3],
        [7.471e-2, 1.992e-2, 5.120e-3],
        [4.581e-2, 1.205e-2, 3.052e-3],
    ];
    println!("case   n   error v     lethe   ratio  error p   order v  order p");
    for (case, published) in published.iter().enumerate() {
        let exact = lethe(case);
        let mut last: Option<(f64, f64)> = None;
        for (n, reference) in [16, 32, 64].into_iter().zip(published) {
            let mesh = Rectangle::new([-1.0; 2], [1.0; 2], [n; 2]).mesh().unwrap();
            let mut config = exact.config();
            config.time_scheme = TimeScheme::Steady;
            config.nonlinear = NEWTON;
            let mut solver = FluidSolver::new(config, mesh).unwrap();
            exact.step(&mut solver, 1.0).unwrap();
            let (ev, ep) = exact.errors(&solver, 1.0);
            let orders = last.map(|(v, p)| (order(v, ev), order(p, ep)));
            let ratio = ev / reference;
            println!(
                "{case:4} {n:3}  {ev:.3e} {reference:.3e}  {ratio:.2}  {ep:.3e}  {orders:.2?}"
            );
            assert!(ratio <= 2.0);
            if n == 64 {
                let (v, p) = orders.unwrap();
                assert!(v >= 1.9 && p >= 1.5, "orders {v} {p}");
            }
            last = Some((ev, ep));
        }
    }
}

#[test]
fn velocity_order_two_does_not_depend_on_the_drag() {
    println!("beta     n   error v    error p    order v  order p");
    for drag in [1e-3, 1.0, 1e3, 1e6, 1e9, 1e12] {
        let exact = suspension(drag, true);
        let mut last: Option<(f64, f64)> = None;
        for n in [16, 32, 64] {
            let mesh = Rectangle::new([0.0; 2], [1.0; 2], [n; 2]).mesh().unwrap();
            let mut config = exact.config();
            config.time_scheme = TimeScheme::Steady;
            config.nonlinear = NEWTON;
            let mut solver = FluidSolver::new(config, mesh).unwrap();
            exact.step(&mut solver, 0.3).unwrap();
            let (ev, ep) = exact.errors(&solver, 0.3);
            let orders = last.map(|(v, p)| (order(v, ev), order(p, ep)));
            println!("{drag:6.0e} {n:3}  {ev:.3e}  {ep:.3e}  {orders:.2?}");
            if n == 64 {
                assert!(orders.unwrap().0 >= 1.9 && ev < 5e-3);
            }
            last = Some((ev, ep));
        }
    }
}

/// Nodal v at t = 0.5 with step `dt`, from exact data at t = 0.
fn end_velocity(scheme: TimeScheme, dt: f64) -> Vec<Vector<2>> {
    // τ depends on Δt, so the error in space does too; where 12μ/h² ≫ ρ/Δt that is negligible.
    let mut exact = suspension(10.0, false);
    exact.viscosity = 1.0;
    let mesh = Rectangle::new([0.0; 2], [1.0; 2], [32; 2]).mesh().unwrap();
    let mut config = exact.config();
    config.time_scheme = scheme;
    let start = exact.start(&mesh);
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    solver.set_state(start);
    for _ in 0..(0.5 / dt).round() as usize {
        exact.step(&mut solver, dt).unwrap();
    }
    solver.state().now.interstitial_velocity()
}

#[test]
fn backward_euler_is_first_and_bdf2_second_order_in_time() {
    // Against a fine step of BDF2 on the same mesh: the error in space is the same and cancels.
    let reference = end_velocity(TimeScheme::Bdf2, 0.5 / 256.0);
    println!("scheme         dt        error     order");
    for (scheme, bound) in [(TimeScheme::BackwardEuler, 0.95), (TimeScheme::Bdf2, 1.9)] {
        let mut last: Option<f64> = None;
        for steps in [8, 16, 32] {
            let dt = 0.5 / f64::from(steps);
            let v = end_velocity(scheme, dt);
            let square: f64 = v
                .iter()
                .zip(&reference)
                .flat_map(|(a, b)| [0, 1].map(|d| (a[d] - b[d]).powi(2)))
                .sum();
            let error = (square / v.len() as f64).sqrt();
            let observed = last.map(|coarse| order(coarse, error));
            println!("{scheme:?} {dt:.5}  {error:.3e}  {observed:.2?}");
            if steps == 32 {
                assert!(observed.unwrap() >= bound);
            }
            last = Some(error);
        }
    }
}
