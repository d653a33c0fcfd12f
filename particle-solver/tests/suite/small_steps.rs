//! Small steps: heaps, columns and walls, beside converged sweeps.

use crate::bench_box::*;
use particle_solver::small::choice::Solver;
use particle_solver::{Candidate, Error, Facet, Forces, Request, Setup};

const G: f64 = 9.81;
const DT: f64 = 2e-3;
/// Radius of the disks, 3 mm ± 20 % \[m\].
const RADIUS: f64 = 3e-3;

fn setup(solver: Solver, friction: f64, walls: Vec<Facet<2>>) -> Setup<2> {
    Setup {
        gravity: [0.0, -G].into(),
        walls,
        friction,
        wall_friction: friction,
        tolerance: 1e-3,
        sweeps_max: 100_000,
        solver: Some(solver),
        ..empty()
    }
}

/// √(Σ m v²/Σ m)/(g Δt).
fn restlessness(engine: &Engine) -> f64 {
    let mass: f64 = engine.grains().mass.iter().sum();
    (2.0 * kinetic_energy(engine) / mass).sqrt() / (G * DT)
}

/// Disks of the size of gravel on a loose lattice.
fn gravel(count: usize, columns: usize) -> Vec<Disk> {
    let mut disks = loose_disks(count, columns, 0.2, 7);
    for disk in &mut disks {
        disk.position = disk.position.map(|x| RADIUS * x);
        disk.radius *= RADIUS;
        disk.mass = 2500.0 * std::f64::consts::PI * disk.radius * disk.radius;
    }
    disks
}

/// A box of settled disks: as many columns, as many layers.
fn settled(columns: usize, layers: usize, seconds: f64) -> Engine {
    let width = 2.6 * RADIUS * columns as f64;
    let walls = box_walls(width, 100.0);
    let setup = setup(Solver::SmallSteps, 0.3, walls);
    let mut engine = engine(setup, &gravel(columns * layers, columns));
    for number in 1..=(seconds / DT) as u64 {
        step(&mut engine, &choose(number, DT));
    }
    engine
}

/// Mean overlap of the contacts that act, of the smaller radius, and the largest.
fn overlaps(engine: &Engine, candidate: &Candidate<2>) -> (f64, f64) {
    let radius = &engine.grains().radius;
    let overlap = candidate.active.iter().map(|active| {
        let (first, second) = (active.pair.key.first, active.pair.key.second);
        let one = radius[first as usize];
        let smaller = radius.get(second as usize).map_or(one, |two| one.min(*two));
        (-active.pair.gap / smaller).max(0.0)
    });
    let overlaps: Vec<f64> = overlap.collect();
    let sum: f64 = overlaps.iter().sum();
    (
        sum / overlaps.len() as f64,
        overlaps.iter().copied().fold(0.0, f64::max),
    )
}

/// Settle a box and watch it for as long again.
fn stays(columns: usize, layers: usize, seconds: f64, rest_max: f64) {
    let mut engine = settled(columns, layers, seconds);
    let (mut worst, mut last) = (0f64, None);
    let mut sub_steps = 0;
    for number in 1..=500 {
        let candidate = step(&mut engine, &choose(100_000 + number, DT));
        sub_steps += candidate.report.sub_steps;
        worst = worst.max(restlessness(&engine));
        last = Some(candidate);
    }
    let (mean, max) = overlaps(&engine, &last.expect("steps"));
    println!(
        "| {layers} | {} | {:.1} | {worst:.1e} | {:.1e} | {mean:.1e} | {max:.1e} |",
        columns * layers,
        f64::from(sub_steps) / 500.0,
        restlessness(&engine),
    );
    assert!(worst < rest_max && mean < 3e-4);
}

const BOX_HEADER: &str = "| layers | grains | sub-steps a step | v/(gΔt) at worst | at the end | overlap, mean | largest |";

#[test]
fn a_settled_box_stays_at_rest() {
    println!("{BOX_HEADER}");
    stays(28, 35, 3.0, 2e-3);
}

/// `cargo test --release -p particle-solver --test suite deep_boxes -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn deep_boxes_stay_at_rest() {
    println!("{BOX_HEADER}");
    stays(40, 90, 5.0, 4e-3);
    stays(50, 195, 7.0, 2e-2);
}

/// A column of equal disks that touch.
fn column(count: usize) -> Engine {
    let mass = 2500.0 * std::f64::consts::PI * RADIUS * RADIUS;
    let place = |k: usize| disk(0.5, RADIUS * (2 * k + 1) as f64, RADIUS).of_mass(mass);
    let disks: Vec<Disk> = (0..count).map(place).collect();
    let setup = Setup {
        tolerance: 1e-5,
        ..setup(Solver::SmallSteps, 0.0, box_walls(1.0, 100.0))
    };
    engine(setup, &disks)
}

#[test]
fn a_column_that_is_in_equilibrium_stays_so() {
    println!(
        "| grains | sweeps of the first step | sub-steps a step | v/(gΔt) at worst | largest overlap |"
    );
    for count in [16, 256, 1000] {
        let mut engine = column(count);
        // nothing is known of the load yet: solved to the end
        let first = step(&mut engine, &choose(1, DT)).report;
        assert!(first.sinking.is_none());
        let (mut worst, mut overlap, mut sub_steps) = (0f64, 0f64, 0);
        for number in 2..=201 {
            let report = step(&mut engine, &choose(number, DT)).report;
            assert!(report.sinking.is_some());
            worst = worst.max(restlessness(&engine));
            overlap = overlap.max(report.penetration_max);
            sub_steps += report.sub_steps;
        }
        println!(
            "| {count} | {} | {:.1} | {worst:.1e} | {overlap:.1e} |",
            first.sweeps,
            f64::from(sub_steps) / 200.0
        );
        assert!(worst < 0.05);
    }
}

/// A column of disks of 4 to 6 mm on a hexagonal lattice in a trough, every place moved by 1e-6 radii.
fn trough(scale: f64, seed: u64) -> Vec<Disk> {
    let (pitch, mut radii, mut places) = (0.0125, Random(1), Random(77 + 1_000_003 * seed));
    let row_height = pitch * 3f64.sqrt() / 2.0;
    let mut disks = Vec::new();
    let mut y = 0.5 * pitch;
    for row in 0.. {
        if y + 0.5 * pitch > 0.5 * scale {
            return disks;
        }
        let mut x = 0.5 * pitch * (1.0 + f64::from(row % 2));
        while x + 0.5 * pitch <= 0.3 * scale {
            let radius = 4e-3 + 2e-3 * radii.next();
            let mut moved = || 1e-6 * radius * (2.0 * places.next() - 1.0);
            let at = [x + moved(), y + moved()];
            disks.push(
                disk(at[0], at[1], radius).of_mass(2500.0 * std::f64::consts::PI * radius * radius),
            );
            x += pitch;
        }
        y += row_height;
    }
    disks
}

/// A way to make a collapse.
struct Way {
    name: &'static str,
    solver: Solver,
    tolerance: f64,
    sub_steps: u32,
}

/// Centre and 98th percentile of x, centre of y, in radii of 5 mm.
fn measures(engine: &Engine) -> [f64; 3] {
    let (grains, state) = (engine.grains(), engine.accepted());
    let mass: f64 = grains.mass.iter().sum();
    let places = state.position.iter().zip(&grains.mass);
    let sums = places.clone().fold([0.0; 2], |sum, (x, m)| {
        [sum[0] + m * x[0], sum[1] + m * x[1]]
    });
    let mut along: Vec<(f64, f64)> = places.map(|(x, m)| (x[0], *m)).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut below = 0.0;
    let front = along.iter().find(|(_, m)| {
        below += m;
        below >= 0.98 * mass
    });
    let front = front.expect("grains").0;
    [sums[0] / mass, sums[1] / mass, front].map(|x| x / 5e-3)
}

/// What a collapse gave at 0.4 s, and what it cost.
struct Made {
    measures: [f64; 3],
    /// Milliseconds of CPU a step.
    cpu: f64,
    sweeps: f64,
    overlap: f64,
}

fn collapse(way: &Way, scale: f64, seed: u64, seconds: f64) -> Made {
    let walls = box_walls(1.2 * scale, 100.0);
    let setup = Setup {
        tolerance: way.tolerance,
        ..setup(way.solver, 0.3, walls)
    };
    let mut engine = engine(setup, &trough(scale, seed));
    let steps = (seconds / DT).round() as u64;
    let (mut sweeps, mut overlap) = (0, 0f64);
    let cpu = cost(|| {
        for number in 1..=steps {
            let request = Request {
                sub_steps: way.sub_steps,
                ..choose(number, DT)
            };
            let report = step(&mut engine, &request).report;
            sweeps += report.sweeps;
            overlap = overlap.max(report.penetration_max);
        }
    });
    Made {
        measures: measures(&engine),
        cpu: 1e-6 * cpu / steps as f64,
        sweeps: sweeps as f64 / steps as f64,
        overlap,
    }
}

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, (square / (count - 1.0) / count).sqrt())
}

fn ensemble(way: &Way, scale: f64, runs: u64, seconds: f64) -> [(f64, f64); 3] {
    let made: Vec<Made> = (0..runs)
        .map(|seed| collapse(way, scale, seed, seconds))
        .collect();
    let of =
        |k: usize| mean_and_error(&made.iter().map(|made| made.measures[k]).collect::<Vec<_>>());
    let mean = |pick: fn(&Made) -> f64| made.iter().map(pick).sum::<f64>() / runs as f64;
    let found = [0, 1, 2].map(of);
    let overlap = made.iter().map(|made| made.overlap).fold(0.0, f64::max);
    print!(
        "| {} | {:.1} | {:.2} | {overlap:.1e} |",
        way.name,
        mean(|m| m.sweeps),
        mean(|m| m.cpu)
    );
    found
        .iter()
        .for_each(|(mean, error)| print!(" {mean:.2} ± {error:.2} |"));
    println!();
    found
}

/// `cargo test --release -p particle-solver --test suite collapses_in_small -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn collapses_in_small_steps_end_where_those_of_small_converged_steps_do() {
    let way = |name, solver, tolerance, sub_steps| Way {
        name,
        solver,
        tolerance,
        sub_steps,
    };
    let runs = std::env::var("RUNS").map_or(12, |runs| runs.parse().expect("a number"));
    println!(
        "| way | sweeps a step | CPU ms a step | largest overlap | centre x | centre y | front |"
    );
    let small = ensemble(
        &way("small steps", Solver::SmallSteps, 1e-3, 0),
        1.0,
        runs,
        0.4,
    );
    ensemble(
        &way("converged", Solver::Converged, 1e-3, 0),
        1.0,
        runs,
        0.4,
    );
    let reference = way("32 converged sub-steps", Solver::Converged, 1e-2, 32);
    let reference = ensemble(&reference, 1.0, runs, 0.4);
    for ((own, error), (known, other)) in small.iter().zip(reference) {
        let apart = (own - known) / (error.powi(2) + other.powi(2)).sqrt();
        println!("{apart:+.1} standard errors");
        assert!(apart.abs() < 2.0);
    }
}

/// An engine with another way to solve contacts, from the same state.
fn as_well(engine: &Engine, solver: Solver) -> Engine {
    let setup = Setup {
        solver: Some(solver),
        ..engine.setup().clone()
    };
    let (grains, state) = (engine.grains().clone(), engine.accepted().clone());
    Engine::new(setup, grains, state).expect("as valid as before")
}

/// `cargo test --release -p particle-solver --test suite a_step_of_ten_thousand -- --ignored --nocapture`
#[test]
#[ignore = "a bench, minutes"]
fn a_step_of_ten_thousand_in_small_steps_and_converged() {
    println!("| grains | CPU ms a step: small steps | converged | ratio | sub-steps | sweeps |");
    for (scale, steps) in [(1.0, 20), (10f64.sqrt(), 3)] {
        let walls = box_walls(1.2 * scale, 100.0);
        let mut small = engine(setup(Solver::SmallSteps, 0.3, walls), &trough(scale, 0));
        for number in 1..=100 {
            step(&mut small, &choose(number, DT));
        }
        let (mut costs, mut work) = ([Vec::new(), Vec::new()], [0, 0]);
        let mut both = [small.clone(), as_well(&small, Solver::Converged)];
        for number in 101..=100 + steps {
            for (k, engine) in both.iter_mut().enumerate() {
                costs[k].push(
                    1e-6 * cost(|| work[k] += step(engine, &choose(number, DT)).report.sweeps),
                );
            }
        }
        let [mut a, mut b] = costs;
        let [a, b] = [&mut a, &mut b].map(|costs| median(costs));
        println!(
            "| {} | {a:.2} | {b:.1} | {:.0} | {:.1} | {:.0} |",
            small.grains().count(),
            b / a,
            work[0] as f64 / steps as f64,
            work[1] as f64 / steps as f64,
        );
    }
}

/// The same engine after so many steps.
fn after(mut engine: Engine, steps: std::ops::RangeInclusive<u64>) -> Engine {
    for number in steps {
        step(&mut engine, &choose(number, DT));
    }
    engine
}

#[test]
fn small_steps_have_the_same_bits_after_a_checkpoint_without_a_list_and_when_repeated() {
    let walls = box_walls(1.2, 100.0);
    let start = engine(setup(Solver::SmallSteps, 0.3, walls), &trough(0.6, 0));
    let early = after(start.clone(), 1..=60);
    let whole = after(early.clone(), 61..=90);
    let path = tempfile::tempdir().expect("a folder");
    let file = path.path().join("grains");
    early.save(&file).expect("a checkpoint");
    let mut restored = start.clone();
    restored.restore(&file).expect("its own");
    assert_eq!(after(restored, 61..=90).accepted(), whole.accepted());
    let mut always = start;
    always.search_always(true);
    assert_eq!(after(always, 1..=90).accepted(), whole.accepted());
    let mut again = early.clone();
    for _ in 0..2 {
        again
            .advance(&choose(61, DT), &Forces::default())
            .expect("one step");
    }
    again.commit().expect("a candidate");
    assert_eq!(after(again, 62..=90).accepted(), whole.accepted());
}

/// Largest overlap after a heavy disk has fallen into a box at this speed \[m/s\]; 0 sub-steps: the engine chooses.
fn fall(speed: f64, sub_steps: u32, sub_steps_max: u32) -> Result<f64, Error> {
    let mut disks = gravel(300, 20);
    disks.push(
        disk(0.07, 0.2, 3.0 * RADIUS)
            .moving(0.0, -speed)
            .of_mass(1000.0),
    );
    let setup = Setup {
        sub_steps_max,
        ..setup(Solver::SmallSteps, 0.3, box_walls(0.156, 100.0))
    };
    let mut engine = engine(setup, &disks);
    let mut overlap = 0f64;
    for number in 1..=60 {
        let request = Request {
            sub_steps,
            ..choose(number, DT)
        };
        overlap = overlap.max(try_step(&mut engine, &request)?.report.penetration_max);
    }
    Ok(overlap)
}

#[test]
fn a_step_with_too_much_overlap_is_made_again_and_then_an_error_with_its_numbers() {
    for (speed, given, most, why) in [(30.0, 0, 40, "motion"), (1.5, 2, 3, "overlap by")] {
        let overlap = fall(speed, given, 100_000).expect("enough sub-steps");
        let error = fall(speed, given, most).expect_err("too few").to_string();
        println!("a heavy disk at {speed} m/s: largest overlap {overlap:.1e}; {error}");
        assert!(overlap <= 0.05);
        assert!(error.contains(why) && error.contains("contact.sub_steps_max"));
    }
}
