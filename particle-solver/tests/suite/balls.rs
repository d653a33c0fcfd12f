//! The same engine in space: balls between triangles.

use std::f64::consts::FRAC_PI_6;

use crate::bench_balls::*;
use crate::bench_box::{Random, choose, empty, request};
use particle_solver::{ContactEngine, Facet, Forces, Request, Setup, checkpoint};
use space::Vector;
use space::vector::from_fn;

/// Momentum, angular momentum about the origin, kinetic energy.
fn balances(engine: &ContactEngine<3>) -> (Vector<3>, Vector<3>, f64) {
    let (grains, state) = (engine.grains(), engine.accepted());
    let factor = engine.setup().inertia_factor;
    let (mut momentum, mut angular) = (Vector::zeros(), Vector::zeros());
    for grain in 0..grains.count() {
        let (mass, radius) = (grains.mass[grain], grains.radius[grain]);
        let carried = state.velocity[grain] * mass;
        momentum += carried;
        angular += state.position[grain].cross(&carried);
        angular += state.spin[grain] * (factor * mass * radius * radius);
    }
    (momentum, angular, state.kinetic_energy(grains, factor))
}

#[test]
fn a_head_on_inelastic_pair_of_balls_moves_on_together() {
    let along = Vector::from([2.0, -1.0, 2.0]) / 3.0;
    let at = |distance: f64| (along * distance).into();
    for (m1, m2) in [(1.0, 1.0), (1.0, 3.0), (2.0, 1e-3)] {
        let one = Ball {
            mass: m1,
            ..ball(at(0.0), 1.0).moving(at(2.0))
        };
        let two = Ball {
            mass: m2,
            ..ball(at(2.5), 1.0).moving(at(-1.0))
        };
        let setup = Setup {
            friction: 0.5,
            ..nothing()
        };
        let mut engine = engine(setup, &[one, two]);
        for number in 1..=5 {
            step(&mut engine, &request(number, 0.1));
        }
        let exact = along * ((2.0 * m1 - m2) / (m1 + m2));
        let state = engine.accepted();
        println!("{m1:.0e} {m2:.0e}: {:?}", V3::from(state.velocity[0]));
        for grain in 0..2 {
            assert!((state.velocity[grain] - exact).norm() < 1e-9);
            assert!(state.spin[grain].norm() < 1e-9);
        }
    }
}

#[test]
fn balls_that_meet_obliquely_keep_momentum_and_angular_momentum_and_gain_no_energy() {
    println!("friction  momentum  angular momentum  energy after / before");
    let mut random = Random(17);
    let mut number = |scale: f64| scale * (2.0 * random.next() - 1.0);
    for friction in [0.0, 0.1, 0.5, 1e4] {
        for _ in 0..50 {
            let mut vector = |scale: f64| [number(scale), number(scale), number(scale)];
            let normal = Vector::from(vector(1.0)).normalize();
            let (one, two) = (0.7, 1.3);
            let ball = |place: Vector<3>, radius: f64, velocity, spin| Ball {
                spin,
                ..ball(place.into(), radius).moving(velocity)
            };
            // Touching, so that impulses act where the surfaces are.
            let balls = [
                ball(normal * one, one, vector(1.0), vector(3.0)),
                ball(normal * -two, two, vector(1.0), vector(3.0)),
            ];
            // A glancing pair spins fast beside how slowly it closes: round-off of the one is seen by
            // the other.
            let setup = Setup {
                friction,
                tolerance: 1e-10,
                ..nothing()
            };
            let mut engine = engine(setup, &balls);
            let before = balances(&engine);
            let approach = Vector::from(balls[1].velocity) - Vector::from(balls[0].velocity);
            let report = step(&mut engine, &request(1, 1e-3)).report;
            let after = balances(&engine);
            assert_eq!(report.contacts, usize::from(approach.dot(&normal) > 0.0));
            let (momentum, angular) = ((after.0 - before.0).norm(), (after.1 - before.1).norm());
            let mass = balls[1].mass;
            assert!(momentum < 1e-14 * mass && angular < 1e-12 * mass);
            assert!(after.2 <= before.2 * (1.0 + 1e-14));
            let state = engine.accepted();
            let closing = (state.velocity[1] - state.velocity[0]).dot(&normal);
            assert!(closing < 1e-10);
            // The spin about the normal meets no resistance.
            for grain in 0..2 {
                let twist = (state.spin[grain] - Vector::from(balls[grain].spin)).dot(&normal);
                assert!(twist.abs() < 1e-13);
            }
            if friction == 1e4 && report.contacts == 1 {
                let surface = state.spin[0] * one + state.spin[1] * two;
                let slip = state.velocity[0] - state.velocity[1] - surface.cross(&normal);
                let rest = slip - normal * slip.dot(&normal);
                assert!(
                    rest.norm() < 1e-11,
                    "stuck surfaces slip by {}",
                    rest.norm()
                );
            }
        }
        println!("{friction:8}  kept");
    }
}

#[test]
fn a_ball_lies_on_a_facet_and_a_second_one_on_it() {
    let setup = Setup {
        gravity: Vector::from([0.0, 0.0, -G]),
        walls: floor(5.0, 2),
        friction: 0.3,
        wall_friction: 0.3,
        tolerance: 1e-10,
        ..nothing()
    };
    let balls = [ball([1.3, 0.4, 1.0], 1.0), ball([1.3, 0.4, 2.5], 0.5)];
    let mut engine = engine(setup, &balls);
    let weight = [G * balls[0].mass, G * balls[1].mass];
    for number in 1..=50 {
        let candidate = step(&mut engine, &request(number, 1e-2));
        assert_eq!(candidate.contact, [2, 2]);
        let forces: Vec<f64> = candidate.active.iter().map(|a| a.force.normal).collect();
        let sum = weight[0] + weight[1];
        assert_eq!(forces.len(), 2);
        assert!((forces[0] - weight[1]).abs() < 1e-8 * sum && (forces[1] - sum).abs() < 1e-8 * sum);
    }
    for (grain, ball) in balls.iter().enumerate() {
        let moved = engine.accepted().position[grain] - Vector::from(ball.position);
        println!("ball {grain} moved {:.1e}", moved.norm());
        assert!(moved.norm() < 1e-9);
    }
}

#[test]
fn a_sliding_ball_ends_up_rolling_at_five_sevenths_of_its_speed() {
    println!("squares  v                 rolls since  exact");
    for n in [1, 7] {
        let setup = Setup {
            gravity: Vector::from([0.0, 0.0, -G]),
            walls: floor(10.0, n),
            wall_friction: 0.3,
            ..nothing()
        };
        let start = ball([-3.0, -2.0, 0.5], 0.5).moving([2.8, 2.1, 0.0]);
        let mut engine = engine(setup, &[start]);
        let mut rolling_since = None;
        for number in 1..=1000 {
            step(&mut engine, &request(number, 1e-3));
            let state = engine.accepted();
            // s × n with s = r ω and n upward.
            let surface = (state.spin[0] * 0.5).cross(&Vector::z());
            let slip = state.velocity[0] - surface;
            if slip.norm() < 1e-10 && rolling_since.is_none() {
                rolling_since = Some(number as f64 * 1e-3);
            }
        }
        let state = engine.accepted();
        let exact = Vector::from([2.0, 1.5, 0.0]);
        let expected = 2.0 * 3.5 / (7.0 * 0.3 * G);
        println!(
            "{n:7}  {:.12}  {rolling_since:?}  {expected:.4}",
            state.velocity[0].norm()
        );
        assert!((state.velocity[0] - exact).norm() < 1e-9);
        assert!((state.position[0][2] - 0.5).abs() < 1e-12);
        assert!((rolling_since.unwrap() - expected).abs() < 2e-3);
    }
}

#[test]
fn a_ball_on_a_slope_rolls_above_two_sevenths_of_the_tangent_and_slides_below() {
    // A slope that falls along (3, 4)/5.
    let (sin, cos) = FRAC_PI_6.sin_cos();
    let down = Vector::from([0.6 * cos, 0.8 * cos, -sin]);
    let across = Vector::from([-0.8, 0.6, 0.0]);
    let normal = Vector::from([0.6 * sin, 0.8 * sin, cos]);
    let limit = 2.0 / 7.0 * FRAC_PI_6.tan();
    for friction in [0.0, 0.99 * limit, 1.01 * limit, 0.5] {
        let corner = |a: f64, b: f64| V3::from(down * a + across * b);
        let wall = [
            corner(-50.0, -50.0),
            corner(-50.0, 50.0),
            corner(50.0, 50.0),
            corner(50.0, -50.0),
        ];
        let setup = Setup {
            gravity: Vector::from([0.0, 0.0, -G]),
            walls: quad(wall).to_vec(),
            wall_friction: friction,
            tolerance: 1e-12,
            ..nothing()
        };
        let mut engine = engine(setup, &[ball((normal * 0.1 + across * 0.3).into(), 0.1)]);
        for number in 1..=100 {
            step(&mut engine, &request(number, 1e-2));
        }
        let exact = match friction > limit {
            true => 5.0 / 7.0 * G * sin,
            false => G * (sin - friction * cos),
        };
        let state = engine.accepted();
        println!(
            "{friction:.4}: {:.9}, exact {exact:.9}",
            state.velocity[0].dot(&down)
        );
        assert!((state.velocity[0] - down * exact).norm() < 1e-9);
        assert!((state.position[0].dot(&normal) - 0.1).abs() < 1e-12);
    }
}

#[test]
fn a_ball_in_the_corner_of_a_box_presses_on_three_walls() {
    let setup = Setup {
        gravity: Vector::from([-3.0, -2.0, -G]),
        walls: open_box(3.0, 9.0),
        tolerance: 1e-10,
        ..nothing()
    };
    let start = Ball {
        mass: 2.0,
        ..ball([1.01, 1.02, 1.03], 1.0)
    };
    let mut engine = engine(setup, &[start]);
    let mut sum = Vector::zeros();
    for number in 1..=50 {
        let candidate = step(&mut engine, &request(number, 1e-2));
        let forces = candidate.active.iter();
        sum = forces.fold(Vector::zeros(), |sum, a| {
            sum + a.pair.normal * a.force.normal
        });
    }
    let place = engine.accepted().position[0];
    println!("{:?} at {:?}", V3::from(sum), V3::from(place));
    assert!((sum - Vector::from([6.0, 4.0, 2.0 * G])).norm() < 1e-7);
    assert!((place - Vector::from([1.0; 3])).norm() < 1e-9);
}

#[test]
fn a_ball_falls_around_an_edge_and_a_corner_of_a_plate() {
    println!("over      smallest gap");
    for (name, start) in [
        ("an edge", [0.05, -1.0, 0.5]),
        ("a corner", [0.05, 0.03, 0.5]),
    ] {
        let setup = Setup {
            gravity: Vector::from([0.0, 0.0, -G]),
            walls: quad([
                [-2.0, -2.0, 0.0],
                [-2.0, 0.0, 0.0],
                [0.0, 0.0, 0.0],
                [0.0, -2.0, 0.0],
            ])
            .to_vec(),
            tolerance: 1e-10,
            ..nothing()
        };
        let mut engine = engine(setup, &[ball(start, 0.5)]);
        let mut nearest = f64::INFINITY;
        for number in 1..=1500 {
            step(&mut engine, &request(number, 1e-3));
            let [x, y, z] = V3::from(engine.accepted().position[0]);
            nearest = nearest.min(x.max(0.0).hypot(y.max(0.0)).hypot(z) - 0.5);
        }
        println!("{name:<8}  {nearest:.1e}");
        assert!(nearest > -1e-9 && nearest < 1e-6);
        assert!(engine.accepted().position[0][2] < -1.0);
    }
}

#[test]
fn a_ball_that_touches_a_wall_and_a_second_ball_stops_between_them() {
    // Thrown at a ball that lies at the wall: inelastic, so both stop, whatever the friction.
    for friction in [0.0, 0.4] {
        let mut walls = floor(4.0, 1);
        for wall in &mut walls {
            wall.corners = wall
                .corners
                .map(|corner| corner - Vector::from([0.0, 0.0, 1.0]));
        }
        let setup = Setup {
            walls,
            friction,
            wall_friction: friction,
            ..nothing()
        };
        let balls = [
            ball([0.2, 0.1, 0.0], 1.0),
            ball([0.2, 0.1, 2.5], 1.0).moving([0.0, 0.0, -3.0]),
        ];
        let mut engine = engine(setup, &balls);
        for number in 1..=30 {
            step(&mut engine, &request(number, 1e-2));
        }
        let state = engine.accepted();
        println!("{friction}: {:?}", V3::from(state.position[1]));
        assert!(
            state
                .velocity
                .iter()
                .all(|velocity| velocity.norm() < 1e-12)
        );
        assert!((state.position[1][2] - 2.0).abs() < 1e-12);
    }
}

fn rain(period: [Option<f64>; 3]) -> ContactEngine<3> {
    let mut random = Random(5);
    let mut number = |least: f64, most: f64| least + (most - least) * random.next();
    let balls: Vec<Ball> = (0..120)
        .map(|k| {
            let place: Vector<3> = from_fn(|axis| {
                let cell = [k % 4, k / 4 % 4, k / 16][axis];
                2.6 * cell as f64 + 1.3 + number(-0.1, 0.1)
            });
            ball(place.into(), number(0.8, 1.2))
        })
        .collect();
    let walls = match period[0] {
        Some(_) => floor(30.0, 1),
        None => open_box(10.4, 60.0),
    };
    let setup = Setup {
        gravity: Vector::from([0.5, -0.3, -G]),
        walls,
        period,
        friction: 0.3,
        wall_friction: 0.3,
        tolerance: 1e-3,
        ..nothing()
    };
    engine(setup, &balls)
}

#[test]
fn a_heap_of_balls_settles_without_overlap_and_with_the_same_bits_each_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("balls.state");
    println!("period        contacts  overlap   held  kinetic energy");
    for period in [[None; 3], [Some(10.4), Some(10.4), None]] {
        let again = |number: u64, pass: u32, dt: f64| Request {
            pass,
            ..choose(number, dt)
        };
        let (mut kept, mut always) = (rain(period), rain(period));
        always.search_always(true);
        let mut overlap = 0.0f64;
        let mut last = None;
        for number in 1..=400 {
            if number % 80 == 0 {
                // A candidate that is thrown away leaves nothing behind.
                kept.advance(&again(number, 0, 4e-2), &Forces::default())
                    .unwrap();
                kept.save(&file).unwrap();
                always.restore(&file).unwrap();
                assert_eq!(kept.accepted(), always.accepted());
            }
            let one = step(&mut kept, &again(number, 0, 1e-2));
            let two = step(&mut always, &again(number, 0, 1e-2));
            assert_eq!(one, two, "step {number}, period {period:?}");
            overlap = overlap.max(one.report.penetration_max);
            last = Some(one);
        }
        let last = last.unwrap();
        let held = last.contact.iter().filter(|&&contact| contact == 2).count();
        let (few, all) = (kept.searches(), always.searches());
        println!(
            "{period:?}  {}  {overlap:.1e}  {held}  {:.1e}, searches {few:?} instead of {all:?}",
            last.report.contacts, last.report.kinetic_energy
        );
        assert!(few[0] < all[0]);
        assert!(held > 90 && overlap < 5e-3);
        let bottom = kept.accepted().position.iter().zip(&kept.grains().radius);
        assert!(bottom.fold(0.0f64, |least, (x, r)| least.min(x[2] - r)) > -5e-3);
    }
}

#[test]
fn a_checkpoint_of_the_plane_is_refused_in_space() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("disks.state");
    let plane = crate::bench_box::engine(empty(), &[crate::bench_box::disk(0.0, 0.0, 1.0)]);
    plane.save(&file).unwrap();
    let error = checkpoint::restore::<3>(&file, plane.grains()).unwrap_err();
    println!("{error}");
    assert!(error.to_string().contains("2 dimensions, the scene has 3"));
}

#[test]
fn a_ball_from_rest_on_a_belt_rolls_at_two_sevenths_of_its_speed() {
    let belt = Vector::from([0.3, -0.4, 0.0]);
    for pieces in [1, 30] {
        let walls = floor(3.0, pieces).into_iter();
        let setup = Setup {
            gravity: [0.0, 0.0, -9.81].into(),
            walls: walls
                .map(|facet| Facet {
                    velocity: belt,
                    ..facet
                })
                .collect(),
            wall_friction: 0.3,
            ..nothing()
        };
        let mut engine = engine(setup, &[ball([0.1, 0.2, 0.25], 0.25)]);
        for number in 1..=500 {
            step(&mut engine, &request(number, 1e-3));
        }
        let (velocity, spin) = (engine.accepted().velocity[0], engine.accepted().spin[0]);
        // n × (r ω) at the lowest point.
        let slip = velocity + spin.cross(&Vector::from([0.0, 0.0, -0.25])) - belt;
        println!(
            "{pieces:2}² squares: v {velocity:?}, slip {:.1e}",
            slip.norm()
        );
        assert!((velocity - belt * (2.0 / 7.0)).norm() < 1e-9 && slip.norm() < 1e-9);
    }
}
