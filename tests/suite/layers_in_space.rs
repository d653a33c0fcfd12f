//! A heavy suspension of spheres above clear fluid: how fast its lower face grows.

use std::f64::consts::{PI, SQRT_2};

use space::Vector;
use tests::in_space::{fluid, particles, periodic_across, scene, spheres};
use tests::reference::{number, rows};
use tests::{couple_in_space, orders};

const GRAVITY: [f64; 3] = [0.0, -9.81, 0.0];
/// Wavelength and depths of the layers \[m\].
const LENGTH: f64 = 0.01;
const GRAINS_PER_CELL: usize = 3;
/// Of the first displacement \[m\].
const AMPLITUDE: f64 = 2e-5;

/// Growth rate of cos(kx) cos(kz) on the lower face of a layer of c = 0.1, √2 waves of `LENGTH` along x and z so that
/// √(k² + k²) = 2π/`LENGTH`, while it grows by e^1.5; nodes.
fn growth(cells: usize, dt: f64) -> (f64, usize) {
    let (wavenumber, solid_fraction) = (2.0 * PI / LENGTH, 0.1);
    let across = wavenumber / SQRT_2;
    let width = 2.0 * PI / across;
    let up = (2.0 * LENGTH / width * cells as f64 / 2.0).round() as usize * 2;
    let upper = [width, 2.0 * LENGTH, width];
    let part = fluid(1200.0, 0.12, GRAVITY, [0.0; 3], upper, [cells, up, cells]);
    let part = periodic_across(part);
    let mut engine = particles(GRAVITY);
    engine.period = vec![Some(width), None, Some(width)];
    engine.tolerance = 1e-3;
    let counts = [cells, up / 2, cells].map(|cells| GRAINS_PER_CELL * cells);
    let spacing = [
        width / counts[0] as f64,
        LENGTH / counts[1] as f64,
        width / counts[2] as f64,
    ];
    let volume = solid_fraction * spacing.iter().product::<f64>();
    let radius = (volume * 3.0 / (4.0 * PI)).cbrt();
    let mut centres = Vec::new();
    for layer in 0..counts[1] {
        for row in 0..counts[2] {
            for column in 0..counts[0] {
                let x = (column as f64 + 0.5) * spacing[0];
                let y = (layer as f64 + 0.5) * spacing[1];
                let z = (row as f64 + 0.5) * spacing[2];
                // displaced without compression: a compressed layer would push with a force that does not grow
                let depth = AMPLITUDE * (-wavenumber * y).exp();
                let (sx, cx) = (across * x).sin_cos();
                let (sz, cz) = (across * z).sin_cos();
                centres.push([
                    x + depth / SQRT_2 * sx * cz,
                    LENGTH + y + depth * cx * cz,
                    z + depth / SQRT_2 * cx * sz,
                ]);
            }
        }
    }
    let lowest = counts[0] * counts[2];
    let grains = spheres(&centres, &vec![radius; centres.len()], 2400.0);
    let mut coupling = couple_in_space(scene(Some(part), Some(engine), dt, 1), &grains);
    let [mut early, mut late] = [0.0; 2];
    let steps = [0.1, 0.5].map(|time: f64| (time / dt).round() as usize);
    for step in 1..=steps[1] {
        coupling
            .advance(dt)
            .unwrap_or_else(|error| panic!("step {step}: {error}"));
        let state = &coupling.state.grains;
        let mode = |x: &Vector<3>| (across * x[0]).cos() * (across * x[2]).cos();
        let along = (0..lowest).map(|i| state.velocity[i][1] * mode(&state.position[i]));
        let logarithm = along.sum::<f64>().abs().ln();
        match step {
            step if step == steps[0] => early = logarithm,
            step if step == steps[1] => late = logarithm,
            _ => {}
        }
    }
    let rate = (late - early) / (dt * (steps[1] - steps[0]) as f64);
    let seat = coupling.system.fluid().expect("a fluid");
    (rate, seat.mesh.node_position.len())
}

/// `cargo test --release -p tests --test suite heavy_layer_of_spheres -- --ignored --nocapture`
#[test]
#[ignore = "a minute"]
fn a_heavy_layer_of_spheres_grows_at_the_rate_of_two_viscous_layers() {
    let row = rows("rayleigh_taylor.csv")
        .into_iter()
        .find(|row| number(row, 2) == 0.9)
        .expect("a row");
    let expected = number(&row, 6);
    let mut table = Vec::new();
    println!("| h [mm] | nodes | growth [1/s] | theory | error |");
    for cells in [10, 14, 20] {
        let (rate, nodes) = growth(cells, 1e-2);
        let (size, error) = (1e3 * SQRT_2 * LENGTH / cells as f64, rate / expected - 1.0);
        println!(
            "| {size:.2} | {nodes} | {rate:.3} | {expected:.3} | {:+.1} % |",
            100.0 * error
        );
        table.push((size, error.abs()));
    }
    let orders = orders(&table);
    println!("orders {orders:.2?}");
    assert!(table[2].1 < 0.1, "h = 0.71 mm: {}", table[2].1);
    assert!(orders.iter().all(|&order| order > 1.0), "{orders:?}");
}
