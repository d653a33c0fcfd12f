//! Suspensions of spheres that settle: hindered speeds of a lattice, Kynch's fronts.

use protocol::scene::{Boundary, DragLaw, MeanFlow, Scheme};
use space::flat::numbers;
use tests::couple_in_space;
use tests::grains::Noise;
use tests::in_space::{
    SIDES, cubic, floor, fluid, mean, particles, periodic_across, scene, spheres,
};
use tests::laws::{GLASS_IN_WATER, Pair};
use tests::profile::{front, solid_levels};
use tests::reference::{number, rows};

const GRAVITY: [f64; 3] = [0.0, -9.81, 0.0];

/// Between neighbours of a cubic lattice \[m\].
fn spacing(pair: &Pair, solid: f64) -> f64 {
    (pair.volume() / solid).cbrt()
}

/// Fall speed of a lattice of spheres in a box of which all sides are periodic, without a flux of the mixture \[m/s\].
fn fall(law: DragLaw, pair: &Pair, solid: f64) -> f64 {
    let spacing = spacing(pair, solid);
    let cells = 2;
    let side = (4 * cells) as f64 * spacing;
    let (density, viscosity) = (pair.density, pair.viscosity);
    let mut part = fluid(density, viscosity, GRAVITY, [0.0; 3], [side; 3], [cells; 3]);
    for side in SIDES {
        part.boundaries.insert(side.to_owned(), Boundary::Periodic);
    }
    part.mean_flow = MeanFlow::Zero;
    let mut engine = particles(GRAVITY);
    engine.period = vec![Some(side); 3];
    let centres = cubic([0.0; 3], spacing, [4 * cells; 3]);
    let radii = vec![pair.radius; centres.len()];
    let grains = spheres(&centres, &radii, pair.grain_density);
    let dt = 0.05;
    let mut setup = scene(Some(part), Some(engine), dt, 1);
    (setup.drag, setup.scheme) = (law, Scheme::Staggered);
    let mut coupling = couple_in_space(setup, &grains);
    for step in 1..=40 {
        coupling
            .advance(dt)
            .unwrap_or_else(|error| panic!("{law:?} c {solid} step {step}: {error}"));
    }
    -mean(numbers(&coupling.state.grains.velocity), 1)
}

#[test]
fn a_periodic_lattice_of_spheres_falls_at_the_hindered_speed_of_each_law() {
    println!("| law | r [m] | μ [Pa s] | c | fall [m/s] | over that of one sphere | error |");
    let mut cases: Vec<(DragLaw, Pair, f64, f64)> = Vec::new();
    let table = rows("hindered_settling.csv");
    let of_water = |row: &&Vec<String>| row[0] == "glass/water 100um" && row[1] == "3";
    for row in table.iter().filter(of_water) {
        let solid = number(row, 2);
        if [0.01, 0.1, 0.2, 0.3, 0.4, 0.5].contains(&solid) {
            let expected = number(row, 5);
            cases.push((DragLaw::Dallavalle, GLASS_IN_WATER, solid, expected));
        }
    }
    for (radius, viscosity) in [(5e-5, 0.1), (5e-5, 1e-3), (5e-4, 1e-3)] {
        let pair = Pair {
            radius,
            viscosity,
            ..GLASS_IN_WATER
        };
        for solid in [0.01, 0.1, 0.3, 0.5] {
            cases.push((DragLaw::WenYu, pair, solid, pair.wen_yu(solid)));
        }
        for solid in [0.3, 0.5] {
            cases.push((DragLaw::Gidaspow, pair, solid, pair.ergun(solid)));
        }
    }
    let mut worst: f64 = 0.0;
    for (law, pair, solid, expected) in cases {
        let found = fall(law, &pair, solid);
        let error = (found / expected - 1.0).abs();
        let (radius, viscosity, alone) = (pair.radius, pair.viscosity, pair.wen_yu(0.0));
        println!(
            "| {law:?} | {radius:e} | {viscosity:e} | {solid} | {found:.6e} | {:.5} | {error:.1e} |",
            found / alone
        );
        worst = worst.max(error);
        // creeping spheres of Wen and Yu: Richardson and Zaki (1954), n = 4.65
        if law == DragLaw::WenYu && viscosity == 0.1 {
            let exponent = (found / alone).ln() / (1.0 - solid).ln();
            assert!((exponent - 4.65).abs() < 0.01, "{exponent}");
        }
    }
    assert!(worst < 1e-6, "{worst:e}");
}

/// A column of spheres at rest, one cell across and one layer a cell.
struct Column {
    solid: f64,
    /// Spheres along each edge of a layer.
    across: usize,
    layers: usize,
    /// Places across are moved at random by so many diameters.
    jitter: f64,
    dt: f64,
}

/// Fronts of a column while it settles, by step: upper, at half of its solid fraction, and lower, at the mean of that
/// and of the bed's \[m\]; none where the column is still as it was.
fn fronts(column: &Column, end: f64, bed: f64) -> Vec<[Option<f64>; 2]> {
    let pair = GLASS_IN_WATER;
    let spacing = spacing(&pair, column.solid);
    let counts = [column.across, column.layers, column.across];
    let upper = counts.map(|count| count as f64 * spacing);
    let cells = [1, column.layers, 1];
    let (density, viscosity) = (pair.density, pair.viscosity);
    let part = fluid(density, viscosity, GRAVITY, [0.0; 3], upper, cells);
    let mut part = periodic_across(part);
    for side in ["bottom", "top"] {
        part.boundaries.insert(side.to_owned(), Boundary::Slip);
    }
    let mut engine = particles(GRAVITY);
    engine.period = vec![Some(upper[0]), None, Some(upper[2])];
    engine.walls = floor(upper[0]);
    engine.tolerance = 1e-3;
    let mut setup = scene(Some(part), Some(engine), column.dt, 1);
    setup.drag = DragLaw::WenYu;
    let mut noise = Noise::new(5);
    let mut centres = cubic([0.0; 3], spacing, counts);
    for x in &mut centres {
        x[0] += noise.around(2.0 * pair.radius * column.jitter);
        x[2] += noise.around(2.0 * pair.radius * column.jitter);
    }
    let radii = vec![pair.radius; centres.len()];
    let grains = spheres(&centres, &radii, pair.grain_density);
    let mut coupling = couple_in_space(setup, &grains);
    let steps = (end / column.dt).round() as usize;
    let levels = [0.5 * column.solid, 0.5 * (column.solid + bed)];
    let mut found = Vec::new();
    for step in 1..=steps {
        coupling
            .advance(column.dt)
            .unwrap_or_else(|error| panic!("c {} step {step}: {error}", column.solid));
        let profile = solid_levels(&coupling);
        let falls = |level: f64| {
            let passed = |pair: &[(f64, f64)]| pair[0].1 >= level && pair[1].1 < level;
            profile.windows(2).any(passed)
        };
        found.push(levels.map(|level| falls(level).then(|| front(&profile, level))));
    }
    found
}

/// Shock from a suspension to what lies below it by Kynch (1952), c u the flux: its speed \[m/s\] and the solid
/// fraction below, no more than that of the bed.
///
/// ```text
///   s = max over c of (c₀ u₀ − c u)/(c − c₀),   nothing falls in the bed      (H4)
/// ```
fn shock(first: f64, bed: f64) -> (f64, f64) {
    let flux = |solid: f64| match solid < bed {
        true => solid * GLASS_IN_WATER.wen_yu(solid),
        false => 0.0,
    };
    let from_first = |solid: f64| (flux(first) - flux(solid)) / (solid - first); // (H4)
    let solids = (1..1000).map(|k| first + (bed - first) * f64::from(k) / 1000.0);
    // the tangent, where it is before the bed
    let tangent = solids.max_by(|a, b| from_first(*a).total_cmp(&from_first(*b)));
    let tangent = tangent.expect("solid fractions");
    (from_first(tangent), tangent)
}

/// `cargo test --release -p tests --test suite fronts_of_kynch -- --ignored --nocapture`
#[test]
#[ignore = "two minutes"]
fn a_column_of_spheres_has_the_fronts_of_kynch() {
    // the lower front goes few cells
    let bounds = [0.02, 0.15];
    println!("| c | spheres | front | cells | speed [m/s] | Kynch | error |");
    let (solid, across, layers, dt) = (0.1, 6, 60, 0.03);
    let times = [[0.3, 1.2], [0.6, 1.5]];
    let column = Column {
        solid,
        across,
        layers,
        jitter: 0.3,
        dt,
    };
    let bed = 0.6;
    let (rises, below) = shock(solid, bed);
    let end = f64::max(times[0][1], times[1][1]);
    let found = fronts(&column, end, below);
    let cell = spacing(&GLASS_IN_WATER, solid);
    let expected = [-GLASS_IN_WATER.wen_yu(solid), rises];
    for (k, name) in ["upper", "lower"].into_iter().enumerate() {
        let at = |time: f64| found[(time / dt).round() as usize - 1][k];
        let [from, to] = times[k].map(at);
        let [from, to] = [from, to].map(|front| front.expect("a front"));
        let speed = (to - from) / (times[k][1] - times[k][0]);
        let error = speed / expected[k] - 1.0;
        println!(
            "| {solid} | {} | {name} | {:.1} | {speed:+.4e} | {:+.4e} | {:+.2} % |",
            across * across * layers,
            (to - from).abs() / cell,
            expected[k],
            100.0 * error
        );
        assert!(error.abs() < bounds[k], "c {solid} {name}: {error}");
    }
}
