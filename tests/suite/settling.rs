//! Suspensions: fronts, rest, growth of a heavy layer, the deferred correction.

use coupler::coupled::setting::Deferred;
use coupler::system::System;
use protocol::engine::InitialGrains;
use protocol::scene::{Boundary, DragLaw, Scheme, Wall};
use space::flat::numbers;
use tests::grains::{Noise, disks, lattice};
use tests::profile::{front, solid_levels};
use tests::reference::{number, rows};
use tests::{
    box_walls, couple, fluid, mean, node_count, particles, place_of, refined, scene,
    with_boundaries, with_uniform_diagonals,
};

const GRAVITY: [f64; 2] = [0.0, -9.81];

#[test]
fn the_settling_front_of_a_column_moves_at_the_kynch_speed() {
    println!("| c0 | cells of a layer | nodes at last | front [m/s] | Kynch | error |");
    for row in rows("kynch.csv").iter().filter(|row| row[1] == "2") {
        let (solid_fraction, expected) = (number(row, 2), number(row, 5));
        // at c0 = 0.1 grains that are spread over cells of 2.8 diameters and lie on each other at the bottom do not settle
        // within the passes of a step
        let kinds: &[bool] = match solid_fraction < 0.1 {
            true => &[false, true],
            false => &[false],
        };
        for &near_grains in kinds {
            let (front, nodes) = front_speed(solid_fraction, near_grains);
            let (error, cells) = (front / expected - 1.0, place_of(near_grains));
            println!(
                "| {solid_fraction} | {cells} | {nodes} | {front:.4e} | {expected:.4e} | {:.2} % |",
                100.0 * error
            );
            assert!(error.abs() < 0.01, "c0 {solid_fraction}: {error}");
        }
    }
}

/// Speed of the upper front of a column \[m/s\], and how many nodes the mesh has at last.
///
/// One cell across and one layer a cell: the hats over equally spaced grains sum to one, wherever they are. On cells that
/// are halved nodes have four or eight triangles, and the hats do not: the cells are so small there (four across, d/h
/// above a quarter) that grains are spread. With two layers a cell grains are points, the porosity goes from node to
/// node by a tenth of c, and the front is 4 % too fast.
fn front_speed(solid_fraction: f64, near_grains: bool) -> (f64, usize) {
    let radius = 5e-5;
    let spacing = radius * (std::f64::consts::PI / solid_fraction).sqrt();
    let [columns, layers] = match near_grains {
        true => [4, 4],
        false => [5, 1],
    };
    let rows = (0.02 / spacing) as usize / layers;
    let counts = [columns, rows * layers];
    let (width, height) = (columns as f64 * spacing, counts[1] as f64 * spacing);
    let (lower, upper) = ([0.0, 0.0], [width, height]);
    let fluid = with_uniform_diagonals(with_boundaries(
        fluid(1000.0, 1e-3, GRAVITY, lower, upper, [1, rows]),
        &[
            ("left", Boundary::Periodic),
            ("right", Boundary::Periodic),
            ("bottom", Boundary::Slip),
            ("top", Boundary::Slip),
        ],
    ));
    let mut engine = particles(GRAVITY);
    engine.period = vec![Some(width), None];
    engine.walls = vec![Wall::segment([-width, 0.0], [2.0 * width, 0.0])];
    engine.tolerance = 1e-3;
    let dt = 0.01;
    let mut scene = scene(Some(fluid), Some(engine), dt, 1);
    if near_grains {
        scene = refined(scene, spacing);
    }
    let centres = lattice(lower, spacing, counts);
    let grains = disks(&centres, &vec![radius; centres.len()], 2500.0);
    let mut coupling = couple(scene, &grains);
    let (mut early, mut late) = (0.0, 0.0);
    for step in 1..=160 {
        let followed = coupling.follow();
        followed
            .and_then(|_| coupling.advance(dt))
            .unwrap_or_else(|error| panic!("c0 {solid_fraction} step {step}: {error}"));
        match step {
            60 => early = front(&solid_levels(&coupling), 0.5 * solid_fraction),
            160 => late = front(&solid_levels(&coupling), 0.5 * solid_fraction),
            _ => {}
        }
    }
    ((early - late) / (100.0 * dt), node_count(&coupling))
}

#[test]
fn neutral_grains_stay_at_rest_and_a_resting_bed_does_not_drift() {
    let mut noise = Noise::new(3);
    let centres: Vec<[f64; 2]> = lattice([0.0, 0.0], 0.1, [10, 10])
        .iter()
        .map(|x| [x[0] + noise.around(0.01), x[1] + noise.around(0.01)])
        .collect();
    let (lower, upper) = ([0.0, 0.0], [1.0, 1.0]);
    let mut engine = particles(GRAVITY);
    engine.walls = box_walls(lower, upper);
    let neutral = scene(
        Some(fluid(1000.0, 1.0, GRAVITY, lower, upper, [8, 8])),
        Some(engine.clone()),
        1e-2,
        50,
    );
    let mut coupling = couple(neutral, &disks(&centres, &[0.03; 100], 1000.0));
    for _ in 0..50 {
        coupling
            .advance(1e-2)
            .unwrap_or_else(|error| panic!("{error}"));
    }
    let speed = numbers(&coupling.state.grains.velocity)
        .iter()
        .fold(0.0_f64, |max, v| max.max(v.abs()));
    println!("neutral grains: largest speed after 50 steps {speed:.1e} m/s");
    assert!(speed < 1e-10);

    // hexagonal layers of 10 and 9 disks from wall to wall on the floor of a closed box
    let radius = 0.05 * (1.0 - 1e-9);
    let layer = |k: usize| {
        if k < 10 {
            (0, k)
        } else if k < 19 {
            (1, k - 10)
        } else {
            (2, k - 19)
        }
    };
    let centres: Vec<[f64; 2]> = (0..29)
        .map(layer)
        .map(|(row, k)| {
            [
                0.05 + 0.1 * k as f64 + 0.05 * (row % 2) as f64,
                0.05 * (1.0 + 3.0_f64.sqrt() * row as f64),
            ]
        })
        .collect();
    let bed = scene(
        Some(fluid(1000.0, 1.0, GRAVITY, lower, upper, [8, 8])),
        Some(engine),
        1e-2,
        1000,
    );
    let grains = disks(&centres, &[radius; 29], 2500.0);
    let mut coupling = couple(bed, &grains);
    let mut passes = 0;
    for step in 1..=1000 {
        passes += coupling
            .advance(1e-2)
            .unwrap_or_else(|error| panic!("step {step}: {error}"))
            .passes;
    }
    let drift = numbers(&coupling.state.grains.position)
        .iter()
        .zip(&grains.position)
        .map(|(x, start)| (x - start).abs())
        .fold(0.0, f64::max);
    println!(
        "resting bed: drift after 1000 steps {:.1e} radii, {} passes a step",
        drift / radius,
        f64::from(passes) / 1000.0
    );
    assert!(drift / radius < 1e-3, "drift {drift}");
}

#[test]
fn a_heavy_layer_above_grows_at_the_rate_of_two_viscous_layers() {
    let row = rows("rayleigh_taylor.csv")
        .into_iter()
        .find(|row| number(row, 2) == 0.9)
        .expect("a row");
    let expected = number(&row, 6);
    for refined in [false, true] {
        println!("cells of this size {}", place_of(refined));
        growth_rates(refined, expected);
    }
}

fn growth_rates(refined: bool, expected: f64) {
    let mut errors = Vec::new();
    println!("| h [mm] | nodes | growth [1/s] | theory | error |");
    for cells in [20, 40, 80] {
        let (growth, nodes) = rayleigh_taylor(cells, 1e-2, refined);
        let error = growth / expected - 1.0;
        println!(
            "| {} | {nodes} | {growth:.3} | {expected:.3} | {:.1} % |",
            10.0 / cells as f64,
            100.0 * error
        );
        errors.push(error.abs());
    }
    let orders: Vec<f64> = errors
        .windows(2)
        .map(|pair: &[f64]| (pair[0] / pair[1]).log2())
        .collect();
    println!("orders {orders:.2?}");
    assert!(errors[1] < 0.06, "h = 0.25 mm: {}", errors[1]);
    assert!(orders.iter().all(|&order| order > 0.9), "{orders:?}");
}

const GRAINS_PER_CELL: usize = 3;

/// Growth rate of cos(kx) on the lower face of a layer of c = 0.1, wavelength and both depths 10 mm, and how many
/// nodes the mesh has. `near_grains`: cells are halved twice near the grains.
fn rayleigh_taylor(cells: usize, dt: f64, near_grains: bool) -> (f64, usize) {
    let (length, solid_fraction) = (0.01, 0.1);
    let wavenumber = 2.0 * std::f64::consts::PI / length;
    let fluid = with_boundaries(
        fluid(
            1200.0,
            0.12,
            GRAVITY,
            [0.0, 0.0],
            [length, 2.0 * length],
            match near_grains {
                true => [cells / 4, cells / 2],
                false => [cells, 2 * cells],
            },
        ),
        &[("left", Boundary::Slip), ("right", Boundary::Slip)],
    );
    let mut engine = particles(GRAVITY);
    engine.walls = box_walls([0.0, 0.0], [length, 2.0 * length]);
    engine.tolerance = 1e-3;
    // whole numbers of grains a cell: their hats sum to a porosity without a pattern
    let count = GRAINS_PER_CELL * cells;
    let spacing = length / count as f64;
    let radius = spacing * (solid_fraction / std::f64::consts::PI).sqrt();
    let centres: Vec<[f64; 2]> = lattice([0.0, length], spacing, [count, count])
        .iter()
        .map(|x| {
            // displaced without compression: a compressed layer would push with a force that does
            // not grow
            let depth = 2e-5 * (-wavenumber * (x[1] - length)).exp();
            let (sine, cosine) = (wavenumber * x[0]).sin_cos();
            [x[0] + depth * sine, x[1] + depth * cosine]
        })
        .collect();
    let grains = disks(&centres, &vec![radius; centres.len()], 2400.0);
    let mut scene = scene(Some(fluid), Some(engine), dt, 1);
    if near_grains {
        scene = refined(scene, length / cells as f64);
    }
    let mut coupling = couple(scene, &grains);
    let mut samples = Vec::new();
    let steps = (0.5 / dt).round() as usize;
    for step in 1..=steps {
        let followed = coupling.follow();
        followed
            .and_then(|_| coupling.advance(dt))
            .unwrap_or_else(|error| panic!("step {step}: {error}"));
        let time = dt * step as f64;
        if time >= 0.1 {
            let amplitude: f64 = (0..grains.mass.len())
                .filter(|&i| i < count)
                .map(|i| {
                    numbers(&coupling.state.grains.velocity)[2 * i + 1]
                        * (wavenumber * numbers(&coupling.state.grains.position)[2 * i]).cos()
                })
                .sum();
            samples.push((time, amplitude.abs().ln()));
        }
    }
    (slope(&samples), node_count(&coupling))
}

fn slope(samples: &[(f64, f64)]) -> f64 {
    let count = samples.len() as f64;
    let (mean_x, mean_y) = (
        samples.iter().map(|s| s.0).sum::<f64>() / count,
        samples.iter().map(|s| s.1).sum::<f64>() / count,
    );
    let covariance: f64 = samples
        .iter()
        .map(|s| (s.0 - mean_x) * (s.1 - mean_y))
        .sum();
    covariance / samples.iter().map(|s| (s.0 - mean_x).powi(2)).sum::<f64>()
}

#[test]
fn the_steady_flow_through_a_jittered_bed_does_not_depend_on_the_step() {
    let with = [jittered(30.0, 600, true), jittered(1e5, 80, true)];
    let without = [jittered(30.0, 600, false), jittered(1e5, 80, false)];
    println!("| deferred correction | rms v/slip at a = 30 | at a = 1e5 |");
    println!("| yes | {:.3} | {:.3} |", with[0], with[1]);
    println!("| no | {:.3} | {:.3} |", without[0], without[1]);
    assert!((with[0] / with[1] - 1.0).abs() < 0.1, "{with:?}");
    assert!(
        (without[0] / without[1] - 1.0).abs() > 0.2,
        "this test no longer sees the correction: {without:?}"
    );
}

/// Root mean square of the grains' velocity over the slip, in a closed column of jittered grains.
fn jittered(stiffness: f64, steps: usize, correction: bool) -> f64 {
    let (radius, solid_fraction, density, ratio) = (1e-4_f64, 0.2, 1000.0, 2.5);
    let spacing = radius * (std::f64::consts::PI / solid_fraction).sqrt();
    let counts = [32, 64];
    let (width, height) = (32.0 * spacing, 64.0 * spacing);
    let mut noise = Noise::new(11);
    let centres: Vec<[f64; 2]> = lattice([0.0, 0.0], spacing, counts)
        .iter()
        .map(|x| {
            [
                x[0] + noise.around(0.35 * spacing),
                x[1] + noise.around(0.35 * spacing),
            ]
        })
        .collect();
    let mut grains: InitialGrains = disks(&centres, &vec![radius; centres.len()], ratio * density);
    grains.radius.iter_mut().for_each(|r| *r *= 0.1); // no contacts
    let viscosity = 0.1;
    let drag = 12.0 * viscosity;
    let dt = stiffness * grains.mass[0] / drag;
    // weak gravity: the grains stay where they are
    let slip = 1e-7 * spacing / (dt * steps as f64);
    let gravity =
        slip * drag / ((1.0 - solid_fraction) * grains.volume[0] * density * (ratio - 1.0));
    let fluid = with_uniform_diagonals(with_boundaries(
        fluid(
            density,
            viscosity,
            [0.0, -gravity],
            [0.0, 0.0],
            [width, height],
            [8, 16],
        ),
        &[
            ("left", Boundary::Periodic),
            ("right", Boundary::Periodic),
            ("bottom", Boundary::Slip),
            ("top", Boundary::Slip),
        ],
    ));
    let mut engine = particles([0.0, -gravity]);
    engine.period = vec![Some(width), None];
    let mut scene = scene(Some(fluid), Some(engine), dt, steps);
    scene.drag = DragLaw::Stokes;
    scene.scheme = Scheme::Staggered;
    let mut coupling = couple(scene, &grains);
    if let (System::Coupled(coupled), false) = (&mut coupling.system, correction) {
        coupled.deferred = Deferred::LeftOut;
    }
    for step in 1..=steps {
        coupling
            .advance(dt)
            .unwrap_or_else(|error| panic!("step {step}: {error}"));
    }
    let velocity = numbers(&coupling.state.grains.velocity);
    let (mean_x, mean_y) = (mean(velocity, 0), mean(velocity, 1));
    let squares: f64 = velocity
        .chunks_exact(2)
        .map(|v| (v[0] - mean_x).powi(2) + (v[1] - mean_y).powi(2))
        .sum();
    (squares / centres.len() as f64).sqrt() / slip
}
