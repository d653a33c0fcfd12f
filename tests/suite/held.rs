//! Plugs of fixed grains in a channel: their edge and the places of their grains must not matter.

use coupler::drag::{Fluid, Shape, coefficient};
use protocol::engine::InitialGrains;
use protocol::scene::{
    Boundary, CouplerScene, DragLaw, FluidScene, Geometry, MeshSource, Profile, Scheme, Wall,
};
use space::Vector;
use space::flat::numbers;
use tests::grains::{Noise, disks, frozen, lattice};
use tests::{box_walls, couple, fluid, particles, pressure, scene, with_boundaries};

const CELLS: usize = 16;
const SPEED: f64 = 1e-6;
/// Root mean square of |u − U|/U that the corners of an oblique edge make at moderate drag.
const CORNERS: f64 = 0.52;

fn channel(dt: f64) -> CouplerScene {
    let sides = [("left", Boundary::Slip), ("right", Boundary::Slip)];
    let inflow = Boundary::Inflow {
        velocity: vec![0.0, SPEED],
        profile: Profile::Uniform,
    };
    let ends = [
        ("bottom", inflow),
        ("top", Boundary::Open { pressure: 0.0 }),
    ];
    let conditions: Vec<_> = sides.into_iter().chain(ends).collect();
    let mut fluid = with_boundaries(
        fluid(
            1.0,
            1.0,
            [0.0; 2],
            [0.0, 0.0],
            [1.0, 4.0],
            [CELLS, 4 * CELLS],
        ),
        &conditions,
    );
    fluid.initial_velocity = vec![0.0, SPEED];
    let mut scene = scene(Some(fluid), Some(particles([0.0; 2])), dt, 1);
    scene.scheme = Scheme::Staggered;
    scene.grains_stay = true;
    scene
}

fn plug(centres: &[[f64; 2]], per_cell: f64, solid_fraction: f64) -> InitialGrains {
    let cell = 1.0 / CELLS as f64;
    let radius = cell * (solid_fraction / per_cell / std::f64::consts::PI).sqrt();
    frozen(disks(centres, &vec![radius; centres.len()], 2.0))
}

/// A lattice of so many grains a cell, cut off along two lines of this slope.
fn cut(per_cell: usize, slope: f64) -> Vec<[f64; 2]> {
    let side = (per_cell as f64).sqrt() * CELLS as f64;
    let spacing = 1.0 / side.round();
    let all = lattice(
        [0.0, 0.0],
        spacing,
        [side.round() as usize, 4 * side.round() as usize],
    );
    all.into_iter()
        .filter(|x| (1.5..2.5).contains(&(x[1] + slope * (x[0] - 0.5))))
        .collect()
}

fn random(per_cell: usize) -> Vec<[f64; 2]> {
    let mut noise = Noise::new(17);
    (0..per_cell * CELLS * CELLS)
        .map(|_| [noise.draw(), 1.5 + noise.draw()])
        .collect()
}

/// Root mean square and largest |u − U|/U of the superficial velocity after some steps.
fn deviation(grains: &InitialGrains, dt: f64, steps: usize) -> (f64, f64) {
    let mut coupling = couple(channel(dt), grains);
    for _ in 0..steps {
        coupling
            .advance(dt)
            .unwrap_or_else(|error| panic!("{error}"));
    }
    let state = &coupling.state;
    let (mut sum, mut largest) = (0.0, 0.0_f64);
    for (w, porosity) in state.flow.velocity.iter().zip(&state.porosity) {
        let off = (w[0] * porosity / SPEED).hypot(w[1] * porosity / SPEED - 1.0);
        sum += off * off;
        largest = largest.max(off);
    }
    ((sum / state.porosity.len() as f64).sqrt(), largest)
}

/// Print, then assert: a lattice cut along the mesh and places at random make no flow; an oblique
/// edge makes that of its corners at the walls, whatever the grains.
fn table(rows: &[(&str, usize, f64)], dt: f64, steps: usize) {
    println!("| plug | grains a cell | rms of u − U over U | largest |");
    for &(name, per_cell, solid_fraction) in rows {
        let centres = match name {
            "lattice" => cut(per_cell, 0.0),
            "random" => random(per_cell),
            _ => cut(per_cell, 0.7),
        };
        let grains = plug(&centres, per_cell as f64, solid_fraction);
        let (rms, largest) = deviation(&grains, dt, steps);
        println!("| {name} | {per_cell} | {rms:.3} | {largest:.2} |");
        let (most, peak) = match name {
            "lattice" => (0.03, 0.25),
            "random" => (0.1, 1.0),
            _ => (1.15 * CORNERS, 5.0),
        };
        assert!(
            rms < most && largest < peak,
            "{name} {per_cell}: {rms} {largest}"
        );
    }
}

const ROWS: [(&str, usize, f64); 7] = [
    ("lattice", 160, 0.2),
    ("lattice", 630, 0.2),
    ("random", 160, 0.2),
    ("random", 630, 0.2),
    ("oblique", 16, 0.5),
    ("oblique", 64, 0.5),
    ("oblique", 400, 0.5),
];

#[test]
fn plugs_of_fixed_grains_make_no_flow_of_their_own() {
    table(&ROWS, 1e6, 20);
}

#[test]
#[ignore = "takes a minute: cargo test --release -p tests --test suite -- --ignored finer --nocapture"]
fn plugs_of_finer_grains() {
    table(&[("random", 6300, 0.2), ("oblique", 4000, 0.5)], 1e6, 12);
}

/// Steps much shorter than viscosity needs across a cell: what a step does wrong must not add up.
#[test]
#[ignore = "takes a minute: cargo test --release -p tests --test suite -- --ignored short --nocapture"]
fn plugs_in_short_steps() {
    let h2 = 1.0 / (CELLS * CELLS) as f64;
    for part in [1e-1, 1e-2] {
        println!("Δt {part} h²/ν");
        table(
            &[("random", 160, 0.2), ("oblique", 16, 0.5)],
            part * h2,
            300,
        );
    }
}

/// Disks of the beds below, side by side on the floor.
const ACROSS: usize = 32;

/// Equal disks that rained without fluid into a box as wide as `ACROSS` of them, and lie there: a
/// packing with a rough surface, in units of the width.
fn settled(layers: usize) -> InitialGrains {
    let mut noise = Noise::new(29);
    let diameter = 1.0 / ACROSS as f64;
    let pitch = 1.1 * diameter;
    let columns = ACROSS - 4;
    let centres: Vec<[f64; 2]> = lattice([0.04, 0.0], pitch, [columns, layers])
        .iter()
        .map(|x| {
            [
                x[0] + noise.around(0.04 * diameter),
                x[1] + noise.around(0.04 * diameter),
            ]
        })
        .collect();
    let radius = 0.5 * diameter;
    let mut grains = disks(&centres, &vec![radius; centres.len()], 2.0);
    let mut engine = particles([0.0, -1.0]);
    engine.walls = vec![
        Wall::segment([0.0, 9.0], [0.0, 0.0]),
        Wall::segment([0.0, 0.0], [1.0, 0.0]),
        Wall::segment([1.0, 0.0], [1.0, 9.0]),
    ];
    engine.tolerance = 1e-3;
    let dt = 0.02 * diameter.sqrt();
    let mut coupling = couple(scene(None, Some(engine), dt, 1), &grains);
    for step in 1..=2000 {
        coupling
            .advance(dt)
            .unwrap_or_else(|error| panic!("settling, step {step}: {error}"));
    }
    grains.position = numbers(&coupling.state.grains.position).to_vec();
    grains
}

/// A bed of equal disks, fixed, between two levels, in a flow so long that it is steady.
struct Bed {
    /// Drop over that of the drag law at the mean porosity, minus 1.
    of_mean: f64,
    /// Drop over the mean of the drag law at the porosities of the nodes, minus 1.
    of_nodes: f64,
    solid_fraction: f64,
    per_cell: f64,
}

impl Bed {
    fn new(grains: &InitialGrains, shape: Geometry, cells: usize, levels: [f64; 2]) -> Bed {
        let mut setup = channel(1e6);
        setup.geometry = shape;
        if let Some(FluidScene {
            mesh: MeshSource::Rectangle { cells: own, .. },
            ..
        }) = &mut setup.fluid
        {
            *own = vec![cells, 4 * cells];
        }
        let mut coupling = couple(setup, &frozen(grains.clone()));
        for _ in 0..12 {
            coupling
                .advance(1e6)
                .unwrap_or_else(|error| panic!("{error}"));
        }
        let pressure = pressure(&mut coupling);
        let mesh = &coupling.system.fluid().expect("a fluid").mesh;
        let level = |y: f64| {
            let at = mesh.node_position.iter().zip(&pressure);
            let at: Vec<f64> = at
                .filter(|(x, _)| (x[1] - y).abs() < 1e-9)
                .map(|(_, p)| *p)
                .collect();
            at.iter().sum::<f64>() / at.len() as f64
        };
        let gradient = (level(levels[0]) - level(levels[1])) / (levels[1] - levels[0]);
        let nodes = mesh.node_position.iter().zip(&coupling.state.porosity);
        let within: Vec<f64> = nodes
            .filter(|(x, _)| (levels[0] - 1e-9..levels[1] + 1e-9).contains(&x[1]))
            .map(|(_, porosity)| *porosity)
            .collect();
        let mean = within.iter().sum::<f64>() / within.len() as f64;
        let depth = match shape {
            Geometry::Disk => 1.0,
            Geometry::Sphere { depth } => depth,
        };
        let law = |porosity: f64| {
            let shape = Shape::new(shape, grains.radius[0], 1.0);
            let water = Fluid {
                density: 1.0,
                dynamic_viscosity: 1.0,
            };
            let slip = SPEED / porosity;
            let drag = coefficient(DragLaw::Dallavalle, &water, porosity, slip, &shape);
            (1.0 - porosity) / grains.volume[0] * drag * slip / porosity
        };
        let nodal = within.iter().map(|&porosity| law(porosity)).sum::<f64>();
        Bed {
            of_mean: gradient / law(mean) - 1.0,
            of_nodes: gradient / (nodal / within.len() as f64) - 1.0,
            solid_fraction: 1.0 - mean,
            per_cell: (1.0 - mean) * depth / grains.volume[0] / (cells * cells) as f64,
        }
    }
}

/// A lattice whose grains are moved at random as far as they do not touch.
fn jittered(per_cell: usize, solid_fraction: f64) -> Vec<[f64; 2]> {
    let mut noise = Noise::new(41);
    let side = ((per_cell as f64).sqrt() * CELLS as f64).round() as usize;
    let spacing = 1.0 / side as f64;
    let gap = spacing * (1.0 - 2.0 * (solid_fraction / std::f64::consts::PI).sqrt());
    lattice([0.0, 1.5], spacing, [side, side])
        .iter()
        .map(|x| {
            [
                x[0] + noise.around(0.5 * gap),
                x[1] + noise.around(0.5 * gap),
            ]
        })
        .collect()
}

#[test]
#[ignore = "takes minutes: cargo test --release -p tests --test suite -- --ignored packed --nocapture"]
fn packed_beds_have_the_drop_of_their_mean_porosity() {
    println!(
        "| bed | grains a cell | c | drop: law at the mean φ | mean of the law at the nodes |"
    );
    let tell = |name: &str, grains: &InitialGrains, shape: Geometry, cells: usize, levels| {
        let bed = Bed::new(grains, shape, cells, levels);
        println!(
            "| {name} | {:.0} | {:.3} | {:+.2} % | {:+.2} % |",
            bed.per_cell,
            bed.solid_fraction,
            100.0 * bed.of_mean,
            100.0 * bed.of_nodes
        );
        // between grains in series and in parallel; where a cell has many, both are one
        assert!(bed.of_mean > -0.01 && bed.of_nodes < 0.01, "{name}");
        assert!(bed.of_mean < 0.01 || bed.per_cell < 60.0, "{name}");
    };
    for per_cell in [10, 100, 1000] {
        let grains = plug(&jittered(per_cell, 0.4), per_cell as f64, 0.4);
        tell(
            "moved at random",
            &grains,
            Geometry::Disk,
            CELLS,
            [1.75, 2.25],
        );
        let grains = plug(&random(per_cell), per_cell as f64, 0.2);
        tell(
            "random places",
            &grains,
            Geometry::Disk,
            CELLS,
            [1.75, 2.25],
        );
    }
    // spheres in a slab, so that there is room between them
    let mut grains = settled(40);
    let shape = Geometry::Sphere {
        depth: 2.4 * grains.radius[0],
    };
    let sphere = 4.0 / 3.0 * std::f64::consts::PI * grains.radius[0].powi(3);
    grains.volume.fill(sphere);
    grains.mass.fill(2.0 * sphere);
    for cells in [4, 8, 16] {
        tell("settled", &grains, shape, cells, [0.25, 0.75]);
    }
}

/// Hexagonal layers from wall to wall, and on them disks in some of the pits: a heap with a rough surface
/// that stands as it is.
fn heap() -> InitialGrains {
    const LAYERS: usize = 6;
    let across = ACROSS / 2;
    let radius = 0.5 / across as f64;
    let mut noise = Noise::new(7);
    let mut below = vec![true; across];
    let mut centres = Vec::new();
    for layer in 0..LAYERS {
        let shift = layer % 2;
        let places = (0..across - shift).map(|k| {
            // a disk of an odd layer lies between k and k + 1, of an even one between k − 1 and k
            let (left, right) = if shift == 1 {
                (k, k + 1)
            } else {
                (k.wrapping_sub(1), k)
            };
            let stands = |k: usize| below.get(k).copied().unwrap_or(true);
            layer == 0 || stands(left) && stands(right) && (layer < 3 || noise.draw() < 0.6)
        });
        let layer_is: Vec<bool> = places.collect();
        for (k, _) in layer_is.iter().enumerate().filter(|(_, there)| **there) {
            centres.push([
                radius * (1.0 + 2.0 * k as f64 + shift as f64),
                radius * (1.0 + 3.0_f64.sqrt() * layer as f64),
            ]);
        }
        below = layer_is;
    }
    disks(&centres, &vec![radius * (1.0 - 1e-9); centres.len()], 2.0)
}

#[test]
fn a_bed_with_a_rough_surface_rests() {
    let bed = heap();
    let (density, weight) = (1.0, [0.0, -1.0]);
    let diameter = 2.0 * bed.radius[0];
    // 12 μ A/d = V Δρ g/U_t
    let terminal = std::f64::consts::PI * diameter * diameter / 48.0;
    println!("{} disks", bed.radius.len());
    println!("| bed | tolerance | largest velocity of the fluid / U_t | of the grains |");
    for (name, tolerance) in [
        ("held", 1e-3),
        ("on contacts", 1e-3),
        ("on contacts", 1e-5),
        ("on contacts", 1e-7),
    ] {
        let held = name == "held";
        let lower = [0.0; 2];
        let part = fluid(density, 1.0, weight, lower, [1.0; 2], [CELLS / 2; 2]);
        let mut engine = particles(weight);
        engine.walls = box_walls(lower, [1.0; 2]);
        let dt = 0.1;
        let mut setup = scene(Some(part), Some(engine), dt, 1);
        setup.grains_stay = held;
        setup.scheme = Scheme::Iterated {
            tolerance,
            passes_max: 40,
        };
        let grains = if held {
            frozen(bed.clone())
        } else {
            bed.clone()
        };
        let mut coupling = couple(setup, &grains);
        for step in 1..=60 {
            coupling
                .advance(dt)
                .unwrap_or_else(|error| panic!("held {held}, step {step}: {error}"));
        }
        let largest = |velocity: &[Vector<2>]| {
            let speeds = velocity.iter().map(|v| v[0].hypot(v[1]));
            speeds.fold(0.0, f64::max) / terminal
        };
        let fluid = largest(&coupling.state.flow.velocity);
        let solid = largest(&coupling.state.grains.velocity);
        println!("| {name} | {tolerance:e} | {fluid:.1e} | {solid:.1e} |");
        assert!(fluid < 1e-8 || !held, "{name}: {fluid:e}");
    }
}
