//! Nothing of a candidate that was thrown away is left: the next one has the bits of a fresh engine.

use crate::bench_box::*;
use particle_solver::{Candidate, Error, Forces, Request, Setup};
use space::flat;

const GRAINS: usize = 60;
const WIDTH: f64 = 16.0;
const SMALL: f64 = 4e-3;

/// Grains with friction that rain on a floor, between walls or in a period.
fn rain(period: Option<f64>, friction: f64) -> Engine {
    let walls = match period {
        Some(_) => vec![wall([-20.0, 0.0], [40.0, 0.0])],
        None => box_walls(WIDTH, 80.0),
    };
    let setup = Setup {
        gravity: [1.0, -9.81].into(),
        walls,
        period: [period, None],
        friction,
        wall_friction: friction,
        tolerance: 1e-4,
        ..empty()
    };
    let mut disks = loose_disks(GRAINS, 6, 0.2, 3);
    disks[GRAINS - 1] = disk(7.0, 60.0, 1.0).moving(-2.0, -30.0);
    engine(setup, &disks)
}

fn request(step: u64, pass: u32, dt: f64) -> Request {
    Request {
        step,
        pass,
        dt,
        sub_steps: 0,
        tolerance: 0.0,
    }
}

fn forces(of: f64) -> Vec<f64> {
    let one = |n: usize| of * (of * n as f64).cos();
    (0..2 * GRAINS).map(one).collect()
}

fn advance(engine: &mut Engine, request: &Request, of: f64) -> Result<Candidate<2>, Error> {
    let (force, drag) = (forces(of), vec![of.abs(); GRAINS]);
    let forces = Forces {
        drag: Some(&drag),
        force: flat::vectors(&force),
    };
    engine.advance(request, &forces).cloned()
}

/// Another engine of the same accepted state, as another process would have it.
fn fresh(engine: &Engine, build: impl Fn() -> Engine) -> Engine {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grains.state");
    engine.save(&file).unwrap();
    let mut other = build();
    other.restore(&file).unwrap();
    other
}

/// What is asked and thrown away before the small step: passes of a length.
const THROWN_AWAY: [(&str, u32, f64); 6] = [
    ("one pass, twice as long", 1, 2.0 * SMALL),
    ("two passes, twice as long", 2, 2.0 * SMALL),
    ("three passes, ten times as long", 3, 10.0 * SMALL),
    ("one pass, a hundred times as long", 1, 100.0 * SMALL),
    ("one pass that fails", 1, 1e4 * SMALL),
    ("two passes of a quarter", 2, 0.25 * SMALL),
];

#[test]
fn a_small_step_after_large_ones_has_the_bits_of_a_fresh_engine() {
    println!("period      friction  thrown away                          contacts  sub-steps");
    for (period, friction) in [
        (None, 0.0),
        (None, 0.3),
        (Some(WIDTH), 0.3),
        (Some(WIDTH), 0.0),
    ] {
        let build = || rain(period, friction);
        let mut engine = build();
        for number in 1..=600 {
            step(&mut engine, &request(number, 0, SMALL));
            if number % 100 != 0 {
                continue;
            }
            for (name, passes, dt) in THROWN_AWAY {
                for pass in 0..passes {
                    let answer = advance(&mut engine, &request(number + 1, pass, dt), 3.0);
                    assert_eq!(answer.is_err(), name.contains("fails"), "{name}");
                }
                let mut other = fresh(&engine, build);
                for pass in 0..3 {
                    let request = request(number + 1, pass, SMALL);
                    let after = advance(&mut engine, &request, f64::from(pass)).unwrap();
                    let expected = advance(&mut other, &request, f64::from(pass)).unwrap();
                    assert_eq!(after, expected, "{name}, step {number}, pass {pass}");
                    if pass == 2 && number == 600 {
                        let report = after.report;
                        println!(
                            "{period:?}  {friction}  {name:<35}  {}  {}",
                            report.contacts, report.sub_steps
                        );
                        assert!(report.contacts > GRAINS / 2);
                    }
                }
            }
        }
    }
}

#[test]
fn a_later_pass_does_not_follow_a_candidate_of_another_length() {
    let build = || rain(None, 0.3);
    let mut engine = build();
    for number in 1..=600 {
        step(&mut engine, &request(number, 0, SMALL));
    }
    let alone = advance(&mut fresh(&engine, build), &request(601, 1, SMALL), 1.0).unwrap();
    for pass in 0..2 {
        advance(&mut engine, &request(601, pass, 2.0 * SMALL), 3.0).unwrap();
    }
    // A thrown-away pass 0 of the whole step is nothing that pass 1 of the half could start from.
    advance(&mut engine, &request(601, 0, 2.0 * SMALL), 3.0).unwrap();
    let after = advance(&mut engine, &request(601, 1, SMALL), 1.0).unwrap();
    println!("sweeps {} and {}", after.report.sweeps, alone.report.sweeps);
    assert_eq!(after, alone);
}
