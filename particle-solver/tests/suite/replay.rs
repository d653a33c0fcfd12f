//! Same input, same bits.

use crate::bench_box::*;
use particle_solver::{Forces, Request, Setup};
use space::flat;

fn heap() -> Engine {
    let setup = Setup {
        gravity: [0.0, -9.81].into(),
        walls: box_walls(16.0, 80.0),
        friction: 0.3,
        wall_friction: 0.2,
        tolerance: 1e-3,
        ..empty()
    };
    engine(setup, &loose_disks(80, 6, 0.2, 5))
}

fn free_request(step: u64, pass: u32) -> Request {
    Request {
        step,
        pass,
        dt: 1e-2,
        sub_steps: 0,
        tolerance: 0.0,
    }
}

#[test]
fn a_second_identical_advance_gives_the_same_bits_in_every_pass() {
    let mut engine = heap();
    for number in 1..=150 {
        step(&mut engine, &free_request(number, 0));
    }
    let accepted = engine.accepted().clone();
    let forces: Vec<Vec<f64>> = (0..3)
        .map(|pass| {
            (0..160)
                .map(|n| f64::from(pass) * (n as f64).cos())
                .collect()
        })
        .collect();
    for pass in 0..3u32 {
        let forces = Forces {
            drag: None,
            force: flat::vectors(&forces[pass as usize]),
        };
        let first = engine
            .advance(&free_request(151, pass), &forces)
            .unwrap()
            .clone();
        let second = engine
            .advance(&free_request(151, pass), &forces)
            .unwrap()
            .clone();
        println!(
            "pass {pass}: contacts {}, sweeps {} and {}",
            first.report.contacts, first.report.sweeps, second.report.sweeps
        );
        assert_eq!(first, second);
        assert_eq!(*engine.accepted(), accepted);
    }
    let again = Forces {
        drag: None,
        force: flat::vectors(&forces[0]),
    };
    let pass_0 = engine
        .advance(&free_request(151, 0), &again)
        .unwrap()
        .clone();
    let fresh = heap_at_150()
        .advance(&free_request(151, 0), &again)
        .unwrap()
        .clone();
    assert_eq!(pass_0, fresh);
}

fn heap_at_150() -> Engine {
    let mut engine = heap();
    for number in 1..=150 {
        step(&mut engine, &free_request(number, 0));
    }
    engine
}

#[test]
fn a_smaller_step_after_a_rejected_one_starts_from_the_accepted_state() {
    let mut engine = heap_at_150();
    let smaller = Request {
        dt: 5e-3,
        ..free_request(151, 0)
    };
    let expected = engine
        .clone()
        .advance(&smaller, &Forces::default())
        .unwrap()
        .clone();
    engine
        .advance(&free_request(151, 0), &Forces::default())
        .unwrap();
    let after = engine
        .advance(&smaller, &Forces::default())
        .unwrap()
        .clone();
    assert_eq!(after, expected);
}

#[test]
fn a_restored_engine_goes_on_with_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grains.state");
    let mut engine = heap_at_150();
    engine.save(&file).unwrap();
    let mut other = heap();
    other.restore(&file).unwrap();
    assert_eq!(engine.accepted(), other.accepted());
    for number in 151..=170 {
        let one = step(&mut engine, &free_request(number, 0));
        let two = step(&mut other, &free_request(number, 0));
        assert_eq!(one, two, "step {number}");
    }
    println!(
        "{} bytes, 20 steps equal",
        std::fs::metadata(&file).unwrap().len()
    );
}

#[test]
fn a_damaged_checkpoint_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grains.state");
    let mut engine = heap_at_150();
    engine.save(&file).unwrap();
    let good = std::fs::read(&file).unwrap();
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 4;
    let mut newer = good.clone();
    newer[8] = 9;
    let mut foreign = good.clone();
    foreign[0] = b'X';
    let mut grown = good.clone();
    grown.extend([0; 25]);
    let mut counted = good.clone();
    counted[24..32].copy_from_slice(&u64::MAX.to_le_bytes());
    let cases: [(&str, &[u8]); 7] = [
        ("header promises", &good[..good.len() - 3]),
        ("too short", &good[..10]),
        ("damaged", &flipped),
        ("version 9", &newer),
        ("not a state", &foreign),
        ("header promises", &grown),
        ("header promises", &counted),
    ];
    for (reason, bytes) in cases {
        std::fs::write(&file, bytes).unwrap();
        let error = engine.restore(&file).unwrap_err().to_string();
        println!("{error}");
        assert!(error.contains(reason), "{error} should say {reason}");
    }
    std::fs::remove_file(&file).unwrap();
    assert!(
        engine
            .restore(&file)
            .unwrap_err()
            .to_string()
            .contains("read")
    );
}
