//! Implicit drag in the contact operator.

use crate::bench_box::*;
use particle_solver::{Forces, Setup};
use space::flat;

/// Two disks pressed together by −10 and 30 N, drag coefficients `drag`; the two bodies and the
/// force between them after each step against the joined body's backward Euler step.
fn pressed_pair(drag: [f64; 2], dt: f64, steps: u64) -> (f64, f64, f64, f64) {
    // The first grain stands on the right and is pushed by its neighbour against −10 N.
    let disks = [
        disk(2.0, 0.0, 1.0).of_mass(1.0),
        disk(0.0, 0.0, 1.0).of_mass(1.0),
    ];
    let mut engine = engine(empty(), &disks);
    let force = [-10.0, 0.0, 30.0, 0.0];
    let forces = Forces {
        drag: Some(&drag),
        force: flat::vectors(&force),
    };
    let (mut joined, mut worst, mut balance) = (0.0, 0.0f64, 0.0f64);
    let (mut velocity, mut normal) = (0.0, 0.0);
    for number in 1..=steps {
        let before = engine.accepted().velocity[0][0];
        joined = (2.0 * joined + dt * 20.0) / (2.0 + dt * (drag[0] + drag[1]));
        let candidate = engine
            .advance(&request(number, dt), &forces)
            .unwrap()
            .clone();
        engine.commit().unwrap();
        velocity = candidate.state.velocity[0][0];
        normal = candidate.active[0].force.normal;
        worst = worst.max(((velocity - joined) / joined).abs());
        let momentum = (velocity - before) / dt + 10.0 + drag[0] * velocity - normal;
        balance = balance.max(momentum.abs());
    }
    (velocity, normal, worst, balance)
}

#[test]
fn a_pressed_pair_with_implicit_drag_moves_as_one_body() {
    println!(
        "drag              v              exact          N          exact      worst v  balance"
    );
    let cases = [[1e2, 1.0], [1e4, 10.0], [1e6, 1e3], [1.0, 1.0], [0.0, 1e5]];
    for drag in cases {
        let (velocity, normal, worst, balance) = pressed_pair(drag, 1e-2, 200);
        let steady = 20.0 / (drag[0] + drag[1]);
        let carried = 10.0 + drag[0] * steady;
        println!(
            "{drag:?}  {velocity:.9e}  {steady:.9e}  {normal:.7}  {carried:.7}  {worst:.1e}  {balance:.1e}"
        );
        assert!(worst < 1e-9 && balance < 1e-9);
        if drag != [1.0, 1.0] {
            assert!((velocity / steady - 1.0).abs() < 1e-9);
            assert!((normal / carried - 1.0).abs() < 1e-9);
        }
    }
    let published = [
        ([1e2, 1.0], 0.19801980, 29.80198),
        ([1e4, 10.0], 1.998002e-3, 29.98002),
    ];
    for (drag, velocity, normal) in published {
        let (v, n, ..) = pressed_pair(drag, 1e-2, 200);
        assert!((v / velocity - 1.0).abs() < 1e-6 && (n / normal - 1.0).abs() < 1e-6);
    }
}

#[test]
fn the_overdamped_contact_force_does_not_depend_on_the_step() {
    println!("dt      N            v");
    for dt in [1e-4, 1e-2, 1.0] {
        let (velocity, normal, ..) = pressed_pair([1e6, 1e6], dt, 10);
        println!("{dt:.0e}  {normal:.9}  {velocity:.9e}");
        assert!((normal - 20.0).abs() < 1e-6);
    }
}

/// A heap on a floor under drag so stiff that velocities are 1e-5 of g dt.
fn stiff_heap(tolerance: f64, drag_over_mass: f64) -> (Engine, Vec<f64>) {
    let disks: Vec<Disk> = (0..30)
        .map(|n| disk(0.0, 1.0 + 2.0 * n as f64, 1.0).of_mass(1.0))
        .collect();
    let setup = Setup {
        gravity: [0.0, -9.81].into(),
        walls: vec![wall([-5.0, 0.0], [5.0, 0.0])],
        tolerance,
        ..empty()
    };
    (engine(setup, &disks), vec![drag_over_mass; 30])
}

#[test]
fn the_residual_bounds_forces_also_when_drag_makes_velocities_tiny() {
    println!("γdt/m   tolerance  floor force / weight - 1   worst v / free fall in drag");
    for stiffness in [0.0, 1e2, 1e5] {
        for tolerance in [1e-3, 1e-6] {
            let dt = 1e-2;
            let (mut engine, drag) = stiff_heap(tolerance, stiffness / dt);
            let forces = Forces {
                drag: Some(&drag),
                force: None,
            };
            let candidate = engine.advance(&request(1, dt), &forces).unwrap();
            let floor = candidate
                .active
                .iter()
                .find(|active| active.pair.key.second >= 30);
            let base = floor.unwrap().force.normal / (30.0 * 9.81) - 1.0;
            let free_fall = 9.81 * dt / (1.0 + stiffness);
            let fastest = candidate
                .state
                .velocity
                .iter()
                .map(|v| v[1].abs())
                .fold(0.0, f64::max);
            let ratio = fastest / free_fall;
            println!("{stiffness:.0e}  {tolerance:.0e}  {base:+.2e}  {ratio:.1e}");
            // Violations, U = 2 e g dt for equal grains, add up over the column of 30.
            let bound = 2.0 * 30.0 * tolerance;
            assert!(base.abs() < bound && ratio < bound);
        }
    }
}

#[test]
fn momentum_is_balanced_for_every_grain_of_a_pile_under_drag() {
    let disks = loose_disks(60, 6, 0.2, 11);
    let setup = Setup {
        gravity: [0.0, -9.81].into(),
        walls: box_walls(16.0, 60.0),
        friction: 0.3,
        wall_friction: 0.3,
        tolerance: 1e-4,
        ..empty()
    };
    let count = disks.len();
    let mut engine = engine(setup, &disks);
    let drag: Vec<f64> = (0..count).map(|n| 10f64.powi(n as i32 % 7 - 2)).collect();
    let force: Vec<f64> = (0..2 * count).map(|n| (n as f64).sin()).collect();
    let forces = Forces {
        drag: Some(&drag),
        force: flat::vectors(&force),
    };
    let dt = 5e-3;
    let mut worst = 0.0f64;
    for number in 1..=400 {
        let before = engine.accepted().velocity.clone();
        let tight = particle_solver::Request {
            tolerance: 1e-4,
            ..request(number, dt)
        };
        let candidate = engine.advance(&tight, &forces).unwrap().clone();
        let mut left: Vec<[f64; 2]> = (0..count)
            .map(|n| {
                let [vx, vy] = xy(candidate.state.velocity[n]);
                let mass = engine.grains().mass[n];
                [
                    mass * (vx - before[n][0]) / dt - force[2 * n] + drag[n] * vx,
                    mass * (vy - before[n][1]) / dt - force[2 * n + 1] + drag[n] * vy + mass * 9.81,
                ]
            })
            .collect();
        for (key, impulse) in &candidate.state.impulses.entries {
            let pair = candidate
                .active
                .iter()
                .find(|active| active.pair.key == *key);
            let Some(pair) = pair else { continue };
            let [nx, ny] = xy(pair.pair.normal);
            let (normal, tangential) = (impulse.normal, impulse.tangential);
            let push = [
                (normal * nx - tangential * ny) / dt,
                (normal * ny + tangential * nx) / dt,
            ];
            let first = key.first as usize;
            left[first] = [left[first][0] - push[0], left[first][1] - push[1]];
            if let Some(second) = left.get_mut(key.second as usize) {
                *second = [second[0] + push[0], second[1] + push[1]];
            }
        }
        engine.commit().unwrap();
        worst = left
            .iter()
            .flatten()
            .fold(worst, |worst, left| worst.max(left.abs()));
    }
    // Contacts below the tolerance are not listed as active: 1e-4 of a weight each.
    println!("worst force left over: {worst:.2e} N of weights around 30 N");
    assert!(worst < 1e-2);
}
