//! Populations: solid fraction, no overlap, inside, the same for the same seed.

use std::path::Path;

use scene::document::Document;
use scene::grains::GrainTable;

/// A 10 mm × 20 mm box, periodic across, with this population.
fn grains(population: &str) -> GrainTable {
    let text = format!(
        "[run]\nend_time = 1.0\ncoupling_step = 0.1\n[gravity]\nacceleration = [0.0, -9.81]\n\
         [[grains]]\ndensity = 2400.0\n{population}\n\
         [particles.domain]\nlower = [0.0, 0.0]\nupper = [0.01, 0.02]\nperiodic = [true, false]\n\
         [contact]\ntolerance = 1e-3\n"
    );
    let document = Document::parse(Path::new("case.toml"), text, &[]).expect("TOML");
    crate::schema::takes(&document);
    scene::from_document(&document, 1)
        .unwrap_or_else(|error| panic!("{error}"))
        .grains
}

/// Smallest distance between surfaces over the radius, images across x included.
fn smallest_gap(table: &GrainTable) -> f64 {
    let mut smallest = f64::MAX;
    for i in 0..table.len() {
        for j in i + 1..table.len() {
            let dx = (table.place(i)[0] - table.place(j)[0]).abs();
            let dx = dx.min(0.01 - dx);
            let dy = table.place(i)[1] - table.place(j)[1];
            let gap = dx.hypot(dy) - table.radius[i] - table.radius[j];
            smallest = smallest.min(gap / table.radius[i].min(table.radius[j]));
        }
    }
    smallest
}

const ALL: [(&str, f64, f64); 7] = [
    // population, area that it fills [m²], solid fraction
    (
        "radius = 1e-4\ncloud = { centre = [5e-3, 1e-2], radius = 4e-3, solid_fraction = 0.2, seed = 3 }",
        5.026548e-5,
        0.2,
    ),
    (
        "radius = 1e-4\ncloud = { centre = [5e-3, 1e-2], radius = 4e-3, solid_fraction = 0.2, arrangement = \"sunflower\" }",
        5.026548e-5,
        0.2,
    ),
    (
        "radius = 1e-4\nbox = { lower = [0.0, 0.0], upper = [0.01, 0.02], solid_fraction = 0.45, seed = 3 }",
        2e-4,
        0.45,
    ),
    (
        "radius = { min = 5e-5, max = 1.5e-4 }\nbox = { lower = [0.0, 0.0], upper = [0.01, 0.02], solid_fraction = 0.4, seed = 3 }",
        2e-4,
        0.4,
    ),
    (
        "radius = 1e-4\nlattice = { lower = [0.0, 0.0], upper = [0.01, 0.02], solid_fraction = 0.6 }",
        2e-4,
        0.6,
    ),
    (
        "radius = 1e-4\nlattice = { lower = [0.0, 0.0], upper = [0.01, 0.02], solid_fraction = 0.8, pattern = \"hexagonal\" }",
        2e-4,
        0.8,
    ),
    (
        "radius = 1e-4\nlattice = { lower = [1e-3, 1e-3], upper = [9e-3, 9e-3], solid_fraction = 0.7, pattern = \"hexagonal\" }",
        6.4e-5,
        0.7,
    ),
];

#[test]
fn populations_meet_their_solid_fraction_without_overlap() {
    println!(
        "{:>8} {:>10} {:>10} {:>10}",
        "grains", "asked", "got", "gap/r"
    );
    for (population, area, fraction) in ALL {
        let table = grains(population);
        let got = table.content() / area;
        let gap = smallest_gap(&table);
        println!(
            "{:>8} {fraction:>10.4} {got:>10.4} {gap:>10.2e}",
            table.len()
        );
        // Whole grains and whole rows: one row of a lattice at most.
        assert!((got / fraction - 1.0).abs() < 0.02, "{population}");
        assert!(gap > -1e-9, "{population}");
    }
}

#[test]
fn whole_grains_lie_within_closed_sides() {
    for (population, ..) in ALL {
        let table = grains(population);
        for (position, radius) in table.position.chunks_exact(2).zip(&table.radius) {
            let tolerated = 1e-12;
            assert!(position[1] >= radius - tolerated && position[1] <= 0.02 - radius + tolerated);
            assert!(
                (0.0..=0.01).contains(&position[0]),
                "{population}: {position:?}"
            );
        }
    }
}

#[test]
fn centres_of_a_cloud_lie_within_its_radius() {
    for arrangement in ["random", "sunflower"] {
        let table = grains(&format!(
            "radius = 1e-5\ncloud = {{ centre = [5e-3, 1e-2], radius = 1e-3, count = 1000, \
             arrangement = \"{arrangement}\" }}"
        ));
        let distance = |p: &[f64]| (p[0] - 5e-3).hypot(p[1] - 1e-2);
        let farthest = table
            .position
            .chunks_exact(2)
            .map(distance)
            .fold(0.0, f64::max);
        // Mean square distance of an even disk is R²/2; of 1000 random points ± 2 %.
        let mean_square = table
            .position
            .chunks_exact(2)
            .map(|p| distance(p).powi(2))
            .sum::<f64>()
            / 1000.0;
        println!(
            "{arrangement}: farthest {farthest:e} m, mean square {:.4} R²",
            mean_square / 1e-6
        );
        assert_eq!(table.len(), 1000);
        assert!(farthest <= 1e-3);
        assert!((mean_square / 0.5e-6 - 1.0).abs() < 0.06);
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_seed_other_grains() {
    let population = |seed| {
        format!(
            "radius = {{ min = 5e-5, max = 1e-4 }}\nbox = {{ lower = [0.0, 0.0], upper = [0.01, 0.02], solid_fraction = 0.3, seed = {seed} }}"
        )
    };
    assert_eq!(grains(&population(7)), grains(&population(7)));
    assert_ne!(grains(&population(7)), grains(&population(8)));
    // What other machines must find as well.
    let table = grains(
        "radius = 1e-4\nbox = { lower = [0.0, 0.0], upper = [0.01, 0.02], count = 2, seed = 1 }",
    );
    println!("{:?}", table.position);
    let expected = [
        [0.004024856636648481, 0.0016915974368096832],
        [0.005965601809348548, 0.0044426266935792425],
    ];
    assert_eq!(table.position, expected.as_flattened());
}

#[test]
fn the_csv_reads_back_to_the_same_bits() {
    let table = grains(ALL[3].0);
    let text = table.to_csv();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("x,y,radius,density,vx,vy,fixed"));
    for (index, line) in lines.enumerate() {
        let values: Vec<f64> = line
            .split(',')
            .map(|word| word.parse().expect("a number"))
            .collect();
        assert_eq!(
            values[..3],
            [
                table.place(index)[0],
                table.place(index)[1],
                table.radius[index]
            ]
        );
    }
}

#[test]
fn velocity_and_fixed_reach_every_grain() {
    let table = grains(
        "radius = 1e-4\nvelocity = [0.1, -0.2]\nfixed = true\nlattice = { lower = [0.0, 0.0], upper = [0.01, 0.01], spacing = 1e-3 }",
    );
    assert_eq!(table.len(), 100);
    assert!(table.fixed.iter().all(|&fixed| fixed));
    assert!(
        table
            .velocity
            .chunks_exact(2)
            .all(|velocity| velocity == [0.1, -0.2])
    );
}
