//! Closed-form motion of a few disks, frictional and frictionless.

use crate::bench_box::*;
use particle_solver::{ContactEngine, Facet, Grains, Request, Setup, State};

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

/// Velocity and slip of a grain of moment κ m r² after a second on a belt, from rest.
fn on_a_belt(inertia_factor: f64, velocity: [f64; 2], pieces: usize) -> (f64, f64) {
    let length = 8.0 / pieces as f64;
    let belt = (0..pieces).map(|k| {
        let from = -4.0 + length * k as f64;
        Facet {
            velocity: velocity.into(),
            ..wall([from, 0.0], [from + length, 0.0])
        }
    });
    let setup = Setup {
        gravity: [0.0, -G].into(),
        walls: belt.collect(),
        wall_friction: 0.5,
        inertia_factor,
        ..empty()
    };
    let mut engine = engine(setup, &[disk(0.0, 0.5, 0.5)]);
    for number in 1..=1000 {
        let candidate = step(&mut engine, &request(number, 1e-3));
        assert_eq!(candidate.contact, [2]);
    }
    let (velocity_now, spin) = (engine.accepted().velocity[0], engine.accepted().spin[0]);
    assert!(
        (engine.accepted().position[0][1] - 0.5).abs() < 1e-12 && velocity_now[1].abs() < 1e-12
    );
    let slip = velocity_now[0] + 0.5 * spin - velocity[0];
    (velocity_now[0] / velocity[0], slip)
}

#[test]
fn a_disk_on_a_belt_rolls_at_a_third_of_its_speed_and_a_sphere_at_two_sevenths() {
    println!("I/(m r²)  pieces  v/U              exact   slip");
    for (inertia_factor, exact) in [(0.5, 1.0 / 3.0), (0.4, 2.0 / 7.0)] {
        for (speed, pieces) in [(0.1, 1), (-0.1, 1), (0.1, 40)] {
            let (share, slip) = on_a_belt(inertia_factor, [speed, 0.0], pieces);
            println!("{inertia_factor}       {pieces:2}      {share:.12}  {exact:.12}  {slip:.1e}");
            assert!((share - exact).abs() < 1e-9 && slip.abs() < 1e-9);
        }
    }
}

#[test]
fn a_wall_that_moves_across_itself_is_refused() {
    let setup = Setup {
        walls: vec![Facet {
            velocity: [0.1, 1e-3].into(),
            ..wall([0.0, 0.0], [1.0, 0.0])
        }],
        ..empty()
    };
    let grains = Grains::default();
    let state = State::new(&grains, Vec::new(), Vec::new()).unwrap();
    let error = ContactEngine::new(setup, grains, state)
        .unwrap_err()
        .to_string();
    println!("{error}");
    assert!(error.contains("wall 0 moves at") && error.contains("along"));
}

/// y of a wall with hills of height 0.2 and length 6, and its slope.
fn hills(x: f64) -> (f64, f64) {
    (0.2 * x.cos(), -0.2 * x.sin())
}

#[test]
fn a_smooth_grain_glides_over_a_wall_of_many_facets_and_is_caught_by_none() {
    println!("facets a radius  dt   deepest   largest gain of energy   largest loss");
    for (pieces, dt) in [(1usize, 1e-3), (4, 1e-3), (20, 1e-3), (20, 2.5e-4)] {
        let (radius, length) = (0.5, 0.5 / pieces as f64);
        let place = |k: usize| {
            let x = -1.0 + length * k as f64;
            [x, hills(x).0]
        };
        let facets = (13.0 / length) as usize;
        let walls: Vec<_> = (0..facets).map(|k| wall(place(k), place(k + 1))).collect();
        let setup = Setup {
            gravity: [0.0, -G].into(),
            walls: walls.clone(),
            ..empty()
        };
        let start = disk(0.0, 0.2 + radius, radius).moving(1.2, 0.0);
        let mass = start.mass;
        let mut engine = engine(setup, &[start]);
        let energy =
            |engine: &Engine| kinetic_energy(engine) / mass + G * engine.accepted().position[0][1];
        let begin = energy(&engine);
        let (mut deepest, mut range) = (0.0f64, [0.0f64; 2]);
        for number in 1..=24_000 {
            let chosen = Request {
                sub_steps: 0,
                ..request(number, dt)
            };
            step(&mut engine, &chosen);
            let at = engine.accepted().position[0];
            if at[0] > 11.0 {
                break;
            }
            let gaps = walls.iter().map(|wall| {
                let [a, b] = wall.corners;
                let along = ((at - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                (at - a - (b - a) * along).norm() - radius
            });
            deepest = deepest.max(-gaps.fold(f64::INFINITY, f64::min));
            let gained = energy(&engine) - begin;
            range = [range[0].max(gained), range[1].max(-gained)];
        }
        let at = engine.accepted().position[0];
        println!(
            "{pieces:2}  {dt:.1e}  {deepest:.1e}  {:.1e}  {:.1e}  {at:?}",
            range[0], range[1]
        );
        assert!(at[0] > 11.0, "caught at {at:?}");
        assert!(deepest < 1e-12 && range[0] < 1e-3);
        assert!(range[1] < 0.3 / pieces as f64 + 20.0 * dt);
    }
}
