//! Closed-form motion of a few disks, frictional and frictionless.

use crate::bench_box::*;
use particle_solver::Setup;

const G: f64 = 9.81;

/// Velocity down the slope after 1 s, spin times radius, and the worst distance from the slope.
fn slide_down(angle: f64, friction: f64, dt: f64) -> (f64, f64, f64) {
    let (sin, cos) = angle.sin_cos();
    let down = [cos, -sin];
    let setup = Setup {
        gravity: [0.0, -G].into(),
        walls: vec![wall([-50.0 * cos, 50.0 * sin], [50.0 * cos, -50.0 * sin])],
        wall_friction: friction,
        ..empty()
    };
    let radius = 0.1;
    let mut engine = engine(setup, &[disk(radius * sin, radius * cos, radius)]);
    let steps = (1.0 / dt).round() as u64;
    let mut off = 0.0f64;
    for number in 1..=steps {
        step(&mut engine, &request(number, dt));
        let [x, y] = xy(engine.accepted().position[0]);
        off = off.max((x * sin + y * cos - radius).abs());
    }
    let [vx, vy] = xy(engine.accepted().velocity[0]);
    (
        vx * down[0] + vy * down[1],
        -radius * engine.accepted().spin[0],
        off,
    )
}

#[test]
fn a_disk_on_a_slope_rolls_above_a_third_of_the_tangent_and_slides_below() {
    let angle = std::f64::consts::FRAC_PI_6;
    let third = angle.tan() / 3.0;
    println!("friction  dt     v after 1 s       exact             surface speed     off slope");
    for dt in [1e-2, 1e-3] {
        for friction in [0.0, 0.1, 0.99 * third, 1.01 * third, 0.5] {
            let (velocity, surface, off) = slide_down(angle, friction, dt);
            let rolls = friction > third;
            let slides = G * (angle.sin() - friction * angle.cos());
            let exact = if rolls {
                2.0 / 3.0 * G * angle.sin()
            } else {
                slides
            };
            println!(
                "{friction:8.4}  {dt:.0e}  {velocity:.12}  {exact:.12}  {surface:.12}  {off:.1e}"
            );
            assert!((velocity - exact).abs() < 1e-9);
            let rolling = if rolls {
                exact
            } else {
                2.0 * friction * G * angle.cos()
            };
            assert!((surface - rolling).abs() < 1e-9);
            assert!(off < 1e-12);
        }
    }
    let (rolling, sliding) = (
        slide_down(angle, 0.5, 1e-2).0,
        slide_down(angle, 0.1, 1e-2).0,
    );
    assert!((rolling - 3.27).abs() < 1e-9 && (sliding - 4.055429078887).abs() < 1e-9);
}

#[test]
fn a_sliding_ball_ends_up_rolling_at_two_thirds_of_its_speed() {
    let setup = Setup {
        gravity: [0.0, -G].into(),
        walls: vec![wall([-10.0, 0.0], [10.0, 0.0])],
        wall_friction: 0.3,
        ..empty()
    };
    let mut engine = engine(setup, &[disk(0.0, 0.5, 0.5).moving(3.0, 0.0)]);
    let mut rolling_since = None;
    for number in 1..=500 {
        step(&mut engine, &request(number, 1e-3));
        let slip = engine.accepted().velocity[0][0] + 0.5 * engine.accepted().spin[0];
        if slip.abs() < 1e-12 && rolling_since.is_none() {
            rolling_since = Some(number as f64 * 1e-3);
        }
    }
    let velocity = engine.accepted().velocity[0][0];
    let expected = 3.0 / (3.0 * 0.3 * G);
    println!("v = {velocity:.12}, exact 2; rolls since {rolling_since:?} s, exact {expected:.4}");
    assert!((velocity - 2.0).abs() < 1e-9);
    assert!((rolling_since.unwrap() - expected).abs() < 2e-3);
}

#[test]
fn a_head_on_inelastic_pair_moves_on_together() {
    println!("m1        m2        v                 exact");
    for (m1, m2) in [(1.0, 1.0), (1.0, 3.0), (2.0, 1e-3)] {
        let disks = [
            disk(0.0, 0.0, 1.0).of_mass(m1).moving(2.0, 0.5),
            disk(2.5, 0.0, 1.0).of_mass(m2),
        ];
        let disks = disks.map(|disk| {
            if disk.mass == m2 && disk.position[0] > 0.0 {
                disk.moving(-1.0, 0.5)
            } else {
                disk
            }
        });
        let mut engine = engine(empty(), &disks);
        for number in 1..=5 {
            step(&mut engine, &request(number, 0.1));
        }
        let exact = (2.0 * m1 - m2) / (m1 + m2);
        let velocity = &engine.accepted().velocity;
        println!("{m1:.2e}  {m2:.2e}  {:.12}  {exact:.12}", velocity[0][0]);
        for velocity in velocity {
            assert!((velocity[0] - exact).abs() < 1e-9 && (velocity[1] - 0.5).abs() < 1e-12);
        }
    }
}

#[test]
fn a_touching_chain_hit_by_one_moves_as_one() {
    println!("n    v_first           v_last            exact       sweeps");
    for count in [2, 5, 20, 100] {
        let mut disks: Vec<Disk> = (0..count).map(|n| disk(2.0 * n as f64, 0.0, 1.0)).collect();
        disks[0].velocity = [1.0, 0.0];
        let mut engine = engine(empty(), &disks);
        let candidate = step(&mut engine, &request(1, 1e-3));
        let velocity = &engine.accepted().velocity;
        let exact = 1.0 / count as f64;
        let sweeps = candidate.report.sweeps;
        let (first, last) = (velocity[0][0], velocity[count - 1][0]);
        println!("{count:3}  {first:.12}  {last:.12}  {exact:.8}  {sweeps}");
        assert!(
            velocity
                .iter()
                .all(|v| (v[0] - exact).abs() < 1e-9 && v[1] == 0.0)
        );
    }
}

#[test]
fn a_notch_carries_its_disk_with_the_closed_form_force() {
    println!("angle   N left       N right      exact");
    for degrees in [10.0f64, 30.0, 45.0, 60.0, 80.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let setup = Setup {
            gravity: [0.0, -G].into(),
            walls: vec![
                wall([-9.0 * cos, 9.0 * sin], [0.0, 0.0]),
                wall([0.0, 0.0], [9.0 * cos, 9.0 * sin]),
            ],
            ..empty()
        };
        let mut engine = engine(setup, &[disk(0.0, 1.0 / cos, 1.0).of_mass(2.0)]);
        let mut forces = Vec::new();
        for number in 1..=20 {
            let candidate = step(&mut engine, &request(number, 1e-2));
            forces = candidate
                .active
                .iter()
                .map(|active| active.force.normal)
                .collect();
        }
        let exact = 2.0 * G / (2.0 * cos);
        println!(
            "{degrees:5}  {:.9}  {:.9}  {exact:.9}",
            forces[0], forces[1]
        );
        assert_eq!(forces.len(), 2);
        assert!(
            forces
                .iter()
                .all(|force| (force - exact).abs() < 1e-9 * exact)
        );
        assert!(engine.accepted().velocity[0].iter().all(|v| v.abs() < 1e-9));
    }
}

#[test]
fn a_column_of_a_thousand_presses_on_the_floor_with_its_weight() {
    let setup = Setup {
        gravity: [0.0, -G].into(),
        walls: vec![wall([-5.0, 0.0], [5.0, 0.0])],
        tolerance: 1e-10,
        ..empty()
    };
    let disks: Vec<Disk> = (0..1000)
        .map(|n| disk(0.0, 1.0 + 2.0 * n as f64, 1.0).of_mass(1.0))
        .collect();
    let mut engine = engine(setup, &disks);
    println!("step  floor force / weight - 1  sweeps   residual   worst force error / weight");
    for number in 1..=3 {
        let candidate = step(&mut engine, &request(number, 1e-3));
        let above = |grain: u32| f64::from(1000 - grain) * G;
        let mut base = 0.0;
        let mut worst = 0.0f64;
        for active in &candidate.active {
            let carried = match active.pair.key.second >= 1000 {
                true => above(0),
                false => above(active.pair.key.second),
            };
            if active.pair.key.second >= 1000 {
                base = active.force.normal / carried - 1.0;
            }
            worst = worst.max((active.force.normal - carried).abs() / (1000.0 * G));
        }
        let report = candidate.report;
        println!(
            "{number}     {base:+.2e}                 {:6}   {:.1e}    {worst:.1e}",
            report.sweeps, report.residual.rms
        );
        assert!(base.abs() < 1e-6 && report.contacts == 1000);
        assert!(candidate.contact.iter().all(|&contact| contact == 2));
    }
}

#[test]
fn a_ball_rolls_over_joints_of_a_floor_as_over_one_floor() {
    let rolled = |pieces: usize| {
        let floor = (0..pieces).map(|n| {
            let at = |n: usize| [10.0 * n as f64 / pieces as f64, 0.0];
            wall(at(n), at(n + 1))
        });
        let setup = Setup {
            gravity: [0.0, -G].into(),
            walls: floor.collect(),
            wall_friction: 0.2,
            ..empty()
        };
        let mut engine = engine(setup, &[disk(1.0, 0.5, 0.5).moving(2.0, 0.0)]);
        for number in 1..=200 {
            step(&mut engine, &request(number, 1e-2));
        }
        (engine.accepted().position[0], engine.accepted().velocity[0])
    };
    let whole = rolled(1);
    println!("pieces  x            y     vx");
    for pieces in [1, 7, 100] {
        let (position, velocity) = rolled(pieces);
        println!(
            "{pieces:5}  {:.9}  {:.3}  {:.9}",
            position[0], position[1], velocity[0]
        );
        assert!((position[0] - whole.0[0]).abs() < 1e-9 && (position[1] - 0.5).abs() < 1e-9);
        assert!((velocity[0] - whole.1[0]).abs() < 1e-9);
    }
}
