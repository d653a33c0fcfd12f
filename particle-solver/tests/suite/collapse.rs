//! Columns of balls collapse on a rough floor as far as columns of grains do.

use std::f64::consts::PI;

use crate::bench_balls::*;
use crate::bench_box::{Random, choose};
use particle_solver::small::choice::Solver;
use particle_solver::{Candidate, ContactEngine, Facet, Setup};
use space::Vector;

const FRICTION: f64 = 0.5;
const DT: f64 = 2e-2;
/// Share of the floor that grains cover where a deposit ends: half of a dense layer.
const COVERED: f64 = 0.4;

fn rough(walls: Vec<Facet<3>>) -> Setup<3> {
    Setup {
        gravity: [0.0, 0.0, -G].into(),
        walls,
        friction: FRICTION,
        wall_friction: FRICTION,
        tolerance: 1e-2,
        solver: Some(Solver::SmallSteps),
        ..nothing()
    }
}

/// A tube of 24 flat sides around the z axis, on a floor.
fn tube(radius: f64, height: f64) -> Vec<Facet<3>> {
    let (sides, outer) = (24, radius / (PI / 24.0).cos());
    let corner = |side: usize, z: f64| {
        let angle = 2.0 * PI * (side % sides) as f64 / sides as f64;
        [outer * angle.cos(), outer * angle.sin(), z]
    };
    let side = |k: usize| {
        let (left, right) = (k + 1, k);
        quad([
            corner(left, 0.0),
            corner(left, height),
            corner(right, height),
            corner(right, 0.0),
        ])
    };
    let sides = (0..sides).flat_map(side);
    floor(1.5 * outer, 1).into_iter().chain(sides).collect()
}

/// Balls of radius 1 ± 0.2 on a loose lattice in a tube, layer on layer.
fn loose(count: usize, radius: f64) -> Vec<Ball> {
    let (pitch, mut random) = (2.5, Random(5));
    let reach = radius - 1.25;
    let lines = (reach / pitch) as i64;
    let layer: Vec<[f64; 2]> = (-lines..=lines)
        .flat_map(|i| (-lines..=lines).map(move |j| [i as f64 * pitch, j as f64 * pitch]))
        .filter(|[x, y]| x.hypot(*y) < reach)
        .collect();
    let place = |k: usize| {
        let [x, y] = layer[k % layer.len()];
        let z = 1.25 + pitch * (k / layer.len()) as f64;
        let mut jitter = || 0.04 * (2.0 * random.next() - 1.0);
        let at = [x + jitter(), y + jitter(), z];
        ball(at, 0.8 + 0.4 * random.next())
    };
    (0..count).map(place).collect()
}

/// Balls at rest where those of an engine are.
fn placed(engine: &ContactEngine<3>, up: f64) -> Vec<Ball> {
    let radii = engine.grains().radius.iter();
    let places = engine.accepted().position.iter();
    let place = |(x, radius): (&Vector<3>, &f64)| ball([x[0], x[1], x[2] + up], *radius);
    places.zip(radii).map(place).collect()
}

/// A column that has come to rest in its tube: the balls, its radius and its height.
fn column(count: usize, aspect: f64) -> (Vec<Ball>, f64, f64) {
    // Solid fraction 0.58; a ball has the mean volume 4/3 π (1 + 0.2²).
    let radius = (count as f64 * 4.0 / 3.0 * 1.04 / (0.58 * aspect)).cbrt();
    let setup = rough(tube(radius, 4.0 * aspect * radius + 10.0));
    let mut engine = engine(setup, &loose(count, radius));
    let fall = (2.0 * 4.0 * aspect * radius / G).sqrt();
    for number in 1..=(1.3 * fall / DT) as u64 {
        step(&mut engine, &choose(number, DT));
    }
    let mean = mean_height(&engine, count);
    (placed(&engine, 2.0), radius, 2.0 * mean)
}

/// Height of the centre of the first balls.
fn mean_height(engine: &ContactEngine<3>, count: usize) -> f64 {
    let places = engine.accepted().position.iter().zip(&engine.grains().mass);
    let (moment, mass) = places
        .take(count)
        .fold((0.0, 0.0), |(moment, mass), (x, m)| {
            (moment + m * x[2], mass + m)
        });
    moment / mass
}

/// Balls glued to the floor z = 0 side by side; their tops are at z = 2.
fn glued(reach: f64) -> impl Iterator<Item = Ball> {
    let lines = (reach / 2.0) as i64;
    let places = (-lines..=lines).flat_map(move |i| (-lines..=lines).map(move |j| [2 * i, 2 * j]));
    let places = places.map(|place| place.map(|x| x as f64));
    places
        .filter(move |[x, y]| x.hypot(*y) <= reach)
        .map(|[x, y]| Ball {
            fixed: true,
            ..ball([x, y, 1.0], 1.0)
        })
}

/// Balances of the balls that move.
struct Balance {
    momentum: Vector<3>,
    energy: f64,
    weight: f64,
}

fn balance(engine: &ContactEngine<3>, count: usize) -> Balance {
    let (grains, state) = (engine.grains(), engine.accepted());
    let momentum = (0..count).fold(Vector::zeros(), |sum, grain| {
        sum + state.velocity[grain] * grains.mass[grain]
    });
    let weight = grains.mass[..count].iter().sum::<f64>() * G;
    let potential = weight * mean_height(engine, count);
    Balance {
        momentum,
        energy: potential + state.kinetic_energy(grains, engine.setup().inertia_factor),
        weight,
    }
}

/// Force of the ground on the balls in a step: floor and glued balls have the numbers from `count` on.
fn support(candidate: &Candidate<3>, count: usize) -> Vector<3> {
    let outside = candidate.active.iter();
    let outside = outside.filter(|active| active.pair.key.second as usize >= count);
    outside.fold(Vector::zeros(), |sum, active| sum + active.push)
}

/// What a collapse did.
struct Collapse {
    /// Where balls cover less than half of a layer.
    end: f64,
    /// Distance from the axis within which 98 of 100 balls are.
    within: f64,
    /// Top of the highest ball near the axis, over the glued ones.
    height: f64,
    /// Share of the energy that was lost.
    lost: f64,
    /// Largest gain of a step, of the energy at first.
    gain: f64,
    /// Largest defect of the momentum of a step, of the impulse of the weight.
    defect: f64,
    /// Share of the kinetic energy at its largest that is left.
    moving: f64,
}

fn collapse(balls: &[Ball], radius: f64, height: f64) -> Collapse {
    let count = balls.len();
    let reach = radius * (2.0 + 1.6 * (height / radius));
    let all: Vec<Ball> = balls
        .iter()
        .copied()
        .chain(glued(reach.min(90.0)))
        .collect();
    let mut engine = engine(rough(floor(1000.0, 1)), &all);
    let first = balance(&engine, count);
    let base = first.weight * 2.0;
    let (mut gain, mut defect, mut before): (f64, f64, _) = (0.0, 0.0, first.energy);
    let (mut momentum, mut kinetic, mut last) = (Vector::zeros(), 0.0f64, 0.0);
    for number in 1..=(6.0 * (height / G).sqrt() / DT) as u64 {
        let candidate = step(&mut engine, &choose(number, DT));
        let now = balance(&engine, count);
        let weight = Vector::from([0.0, 0.0, -now.weight]);
        let missing = now.momentum - momentum - (support(&candidate, count) + weight) * DT;
        defect = defect.max(missing.norm() / (now.weight * DT));
        gain = gain.max((now.energy - before) / (first.energy - base));
        (momentum, before, last) = (now.momentum, now.energy, candidate.report.kinetic_energy);
        kinetic = kinetic.max(last);
    }
    let (end, within) = extent(&engine, count);
    let near = placed(&engine, -2.0).into_iter().take(count);
    let near = near.filter(|ball| ball.position[0].hypot(ball.position[1]) < 0.5 * radius + 2.0);
    Collapse {
        end,
        within,
        height: near.fold(0.0, |top, ball| top.max(ball.position[2] + ball.radius)),
        lost: (first.energy - before) / (first.energy - base),
        gain,
        defect,
        moving: last / kinetic,
    }
}

/// Where rings around the axis, a ball wide, begin to be covered by less than `COVERED`; 98th percentile.
fn extent(engine: &ContactEngine<3>, count: usize) -> (f64, f64) {
    let mut distance = Vec::with_capacity(count);
    let mut covered = vec![0.0; 1000];
    for ball in &placed(engine, 0.0)[..count] {
        let from_axis = ball.position[0].hypot(ball.position[1]);
        distance.push(from_axis);
        let ring = ((from_axis / 2.0) as usize).min(999);
        covered[ring] += PI * ball.radius * ball.radius;
    }
    for (ring, covered) in covered.iter_mut().enumerate() {
        let (inner, outer) = (2.0 * ring as f64, 2.0 * ring as f64 + 2.0);
        *covered /= PI * (outer * outer - inner * inner);
    }
    let last = covered
        .iter()
        .rposition(|share| *share >= COVERED)
        .unwrap_or(0);
    // Between the middles of two rings the share falls along a line.
    let part = (covered[last] - COVERED) / (covered[last] - covered[last + 1]);
    distance.sort_by(f64::total_cmp);
    (2.0 * (last as f64 + 0.5 + part), distance[count * 98 / 100])
}

/// Run-out over the radius of the column (Lube, Huppert, Sparks and Hallworth 2004).
fn known(aspect: f64) -> f64 {
    match aspect < 1.7 {
        true => 1.24 * aspect,
        false => 1.6 * aspect.sqrt(),
    }
}

/// A collapse as a row of a table: aspect ratio, run-out over the radius, and what is known of it.
fn row(count: usize, wished: f64) -> (f64, f64) {
    let (balls, radius, height) = column(count, wished);
    let found = collapse(&balls, radius, height);
    let (aspect, run_out) = (height / radius, found.end / radius - 1.0);
    println!(
        "| {count} | {aspect:.2} | {:.1} | {run_out:.2} | {:.2} | {:+.0} % | {:.2} | {:.2} | {:.2} | {:.1e} | {:.1e} | {:.0e} |",
        0.5 * radius,
        known(aspect),
        100.0 * (run_out / known(aspect) - 1.0),
        found.within / radius - 1.0,
        found.height / radius,
        found.lost,
        found.gain,
        found.defect,
        found.moving,
    );
    assert!(found.defect < 1e-10 && found.gain < 1e-3);
    (aspect, run_out)
}

const HEADER: &str = "| balls | a | radius / d | run-out | 1.24 a or 1.6 √a | difference | 98 of 100 | height left / radius | energy lost | largest gain | momentum defect | still moving |";

#[test]
fn a_column_of_balls_spreads_and_keeps_its_balances() {
    println!("{HEADER}");
    let (aspect, run_out) = row(300, 1.0);
    assert!((0.3..0.8).contains(&(run_out / known(aspect))));
}

/// `cargo test --release -p particle-solver --test suite larger_columns -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn larger_columns_of_balls_run_out_farther() {
    println!("{HEADER}");
    let mut before = 0.0;
    for count in [1000, 3000, 10_000] {
        let (aspect, run_out) = row(count, 1.0);
        let share = run_out / known(aspect);
        assert!(share > before && share < 1.0);
        before = share;
    }
}

/// `cargo test --release -p particle-solver --test suite columns_of_balls_run -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn columns_of_balls_run_out_by_the_powers_of_columns() {
    println!("{HEADER}");
    let table = [0.5, 1.0, 2.0, 4.0, 8.0].map(|aspect| row(10_000, aspect));
    let powers: Vec<f64> = table
        .windows(2)
        .map(|pair| (pair[1].1 / pair[0].1).ln() / (pair[1].0 / pair[0].0).ln())
        .collect();
    println!("powers of a {powers:.2?}");
    assert!((0.8..1.2).contains(&powers[0]) && (0.3..0.7).contains(&powers[3]));
    let share = |(aspect, run_out): &(f64, f64)| run_out / known(*aspect);
    assert!(
        table
            .iter()
            .map(share)
            .all(|share| (0.6..1.0).contains(&share))
    );
}
