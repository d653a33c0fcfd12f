//! What is left on a shelf that drains has the angle of repose.

use crate::bench_balls::*;
use crate::bench_box::{Random, choose, request};
use particle_solver::{ContactEngine, Facet, Setup, State};
use space::Vector;

/// Length of the shelf along x, its period along y, height of the bed at first.
const SHELF: [f64; 3] = [50.0, 10.0, 26.0];
const DT: f64 = 2e-2;
/// Steps after which balls may still fall off, one by one, at small friction.
const STEPS_MAX: u64 = 3000;

/// A wall at x = 0 that the bed leans on, one at x = `SHELF` that is taken away, smooth and high.
fn end_walls() -> [[Facet<3>; 2]; 2] {
    let [length, width, height] = SHELF;
    let (low, high, side) = (-20.0, 4.0 * height, 2.0 * width);
    let left = quad([
        [0.0, -side, low],
        [0.0, -side, high],
        [0.0, side, high],
        [0.0, side, low],
    ]);
    let right = quad([
        [length, side, low],
        [length, side, high],
        [length, -side, high],
        [length, -side, low],
    ]);
    [left, right]
}

fn setup(friction: f64, walls: Vec<Facet<3>>) -> Setup<3> {
    Setup {
        gravity: [0.0, 0.0, -G].into(),
        walls,
        period: [None, Some(SHELF[1]), None],
        friction,
        tolerance: 1e-2,
        ..nothing()
    }
}

/// A bed of balls of radius 1 ± 0.2 between the walls on balls that are glued below z = 0, at rest.
fn bed(friction: f64) -> Vec<Ball> {
    let [length, width, height] = SHELF;
    let pitch = 2.5;
    let [along, across] = [length, width].map(|side| (side / pitch) as usize);
    // Solid fraction 0.58.
    let count = (0.58 * length * width * height / (4.0 / 3.0 * std::f64::consts::PI)) as usize;
    let mut random = Random(11);
    let mut loose = |k: usize| {
        let cell = [k % along, k / along % across, k / (along * across)];
        let jitter = |random: &mut Random| 0.04 * (2.0 * random.next() - 1.0);
        let at = cell.map(|cell| pitch * (cell as f64 + 0.5) + jitter(&mut random));
        ball(at, 0.8 + 0.4 * random.next())
    };
    let glued = |k: usize| {
        let at = [k % 25, k / 25].map(|place| 2.0 * place as f64 + 1.0);
        let fixed = ball([at[0], at[1], -1.0], 1.0);
        Ball {
            fixed: true,
            ..fixed
        }
    };
    let balls: Vec<Ball> = (0..125)
        .map(glued)
        .chain((0..count).map(&mut loose))
        .collect();
    let walls = end_walls().into_iter().flatten().collect();
    let mut engine = engine(setup(friction, walls), &balls);
    for number in 1..=500 {
        step(&mut engine, &choose(number, DT));
    }
    let places = engine.accepted().position.iter();
    let moved = |(x, ball): (&Vector<3>, &Ball)| Ball {
        position: (*x).into(),
        ..*ball
    };
    places.zip(&balls).map(moved).collect()
}

/// Take the wall at the end away until nothing falls off any more; steps made.
fn drained(friction: f64) -> (ContactEngine<3>, u64) {
    let [left, _] = end_walls();
    let mut engine = engine(setup(friction, left.into()), &bed(friction));
    let (mut number, mut quiet) = (0, 0);
    while quiet < 200 && number < STEPS_MAX {
        (number, quiet) = (number + 1, quiet + 1);
        step(&mut engine, &request(number, DT));
        let places = engine.accepted().position.iter().enumerate();
        let gone: Vec<usize> = places
            .filter(|(_, x)| x[2] < -8.0)
            .map(|(grain, _)| grain)
            .collect();
        if !gone.is_empty() {
            engine.remove(&gone).unwrap();
            quiet = 0;
        }
    }
    (engine, number)
}

/// Angle of the surface \[°\]: a line through the highest balls of each cell, a ball wide, of the middle of the shelf.
fn slope(state: &State<3>) -> f64 {
    let [length, width, _] = SHELF;
    let (along, across) = ((length / 2.0) as usize, (width / 2.0) as usize);
    let mut top = vec![0.0f64; along * across];
    for x in &state.position {
        let y = x[1].rem_euclid(width);
        let cell = [x[0] / 2.0, y / 2.0].map(|place| place.max(0.0) as usize);
        if cell[0] < along && cell[1] < across {
            let cell = &mut top[cell[0] + along * cell[1]];
            *cell = cell.max(x[2]);
        }
    }
    let (from, to) = (along / 10, along - along / 10);
    let middle = (0..top.len()).filter(|cell| (from..to).contains(&(cell % along)));
    let (mut n, mut sums) = (0.0, [0.0; 4]);
    for cell in middle {
        let (x, z) = (2.0 * (cell % along) as f64 + 1.0, top[cell]);
        n += 1.0;
        for (sum, term) in sums.iter_mut().zip([x, z, x * x, x * z]) {
            *sum += term;
        }
    }
    let [x, z, xx, xz] = sums.map(|sum| sum / n);
    (-(xz - x * z) / (xx - x * x)).atan().to_degrees()
}

/// Friction of balls, and shear over normal stress of dense balls sheared slowly (Chialvo, Sun and Sundaresan 2012).
const SHEARED: [(f64, f64); 3] = [(0.1, 0.268), (0.3, 0.357), (0.5, 0.382)];

/// `cargo test --release -p particle-solver --test suite angle_of_repose -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn the_angle_of_repose_of_balls_grows_with_their_friction() {
    println!("| friction | balls left | angle | arctan of the stress ratio | steps |");
    let mut before = 0.0;
    for (friction, ratio) in SHEARED {
        let (engine, steps) = drained(friction);
        let angle = slope(engine.accepted());
        let known = f64::atan(ratio).to_degrees();
        let left = engine.grains().fixed.iter().filter(|fixed| !**fixed);
        println!(
            "| {friction} | {} | {angle:.1}° | {known:.1}° | {steps} |",
            left.count()
        );
        assert!(angle > before && (angle - known).abs() < 5.0);
        before = angle;
    }
}
