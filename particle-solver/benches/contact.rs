//! Unit costs: one sweep, one search for contacts, one step of a settled box.
//!
//! `cargo bench -p particle-solver --bench contact`

#![allow(
    missing_docs,
    reason = "criterion_group! writes a public function without docs"
)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use particle_solver::contact::delassus::{Material, System};
use particle_solver::contact::law::Friction;
use particle_solver::contact::loads::Loads;
use particle_solver::contact::pairs::{Margin, pairs};
use particle_solver::search::neighbours::Neighbours;
use particle_solver::search::place::Place;
use particle_solver::small::choice::Solver;
use particle_solver::solve::sweep::{RELAXATION, sweep};
use particle_solver::walls::near::Walls;
use particle_solver::{ContactEngine, Facet, Forces, Grains, Request, Setup, State};
use space::Vector;

/// A dense box of `count` disks, radius 0.5 (1 ± 0.2), dropped from a lattice and settled.
fn settled(count: usize, columns: usize, friction: f64, steps: u64) -> ContactEngine<2> {
    let mut seed = 12_345u64;
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut grains = Grains::default();
    let mut position = Vec::new();
    for place in 0..count {
        let radius = 0.5 * (0.8 + 0.4 * random());
        grains.radius.push(radius);
        grains.mass.push(std::f64::consts::PI * radius * radius);
        grains.fixed.push(false);
        let x = 1.22 * ((place % columns) as f64 + 0.5) + 0.02 * random();
        position.push(Vector::from([x, 1.22 * ((place / columns) as f64 + 0.5)]));
    }
    let width = 1.22 * columns as f64;
    let wall = |a: [f64; 2], b: [f64; 2]| Facet::at_rest([a, b].map(Vector::from));
    let setup = Setup {
        gravity: Vector::from([0.0, -9.81]),
        walls: vec![
            wall([0.0, 1e3], [0.0, 0.0]),
            wall([0.0, 0.0], [width, 0.0]),
            wall([width, 0.0], [width, 1e3]),
        ],
        period: [None; 2],
        friction,
        wall_friction: friction,
        inertia_factor: 0.5,
        tolerance: 1e-2,
        solver: Some(Solver::Converged),
        sweeps_max: 100_000,
        sub_steps_max: 100,
    };
    let state = State::new(&grains, position, vec![Vector::zeros(); count]).expect("finite");
    let mut engine = ContactEngine::new(setup, grains, state).expect("valid");
    for step in 1..=steps {
        engine
            .advance(&request(step), &Forces::default())
            .expect("converges");
        engine.commit().expect("has a candidate");
    }
    engine
}

fn request(step: u64) -> Request {
    Request {
        step,
        pass: 0,
        dt: 2e-3,
        sub_steps: 0,
        tolerance: 0.0,
    }
}

/// Bench at 10 000 grains; they need not be at rest for unit costs, only close.
fn unit_costs(criterion: &mut Criterion) {
    let engine = settled(10_000, 250, 0.3, 400);
    let (grains, accepted) = (engine.grains(), engine.accepted());
    let setup = engine.setup();
    let walls = Walls::new(&setup.walls, &setup.period).expect("valid");
    let loads = Loads {
        dt: 2e-3,
        gravity: setup.gravity,
        drag: None,
        force: None,
    };
    let free = loads.free_motion(grains, accepted);
    let push: Vec<f64> = grains.radius.iter().map(|radius| 0.02 * radius).collect();
    let place = Place {
        grains,
        position: &accepted.position,
        walls: &walls,
        period: setup.period,
    };
    let find = |neighbours: &mut Neighbours<2>| {
        let margin = Margin {
            dt: loads.dt,
            free_velocity: &free.velocity,
            push: &push,
        };
        pairs(neighbours, &place, &margin).expect("few enough")
    };
    let mut group = criterion.benchmark_group("unit costs, 10000 grains");
    group.throughput(Throughput::Elements(grains.count() as u64));
    for search_always in [true, false] {
        let mut neighbours = Neighbours {
            search_always,
            ..Neighbours::default()
        };
        let name = if search_always { "search" } else { "kept list" };
        group.bench_function(format!("detection, {name}"), |bencher| {
            bencher.iter(|| find(&mut neighbours));
        });
    }
    let pairs = find(&mut Neighbours::default());
    for friction in [0.0, 0.3] {
        let material = Material {
            friction: Friction {
                grains: friction,
                walls: friction,
            },
            inertia_factor: 0.5,
        };
        let mut system =
            System::assemble(grains, &material, &loads, &free, (&pairs, walls.grounds()));
        group.throughput(Throughput::Elements(pairs.len() as u64));
        group.bench_function(format!("sweep, friction {friction}"), |bencher| {
            bencher.iter(|| sweep(&mut system, RELAXATION));
        });
    }
    group.finish();
}

fn whole_steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step of a box of 2000 grains");
    group.sample_size(20);
    for friction in [0.0, 0.3] {
        let mut engine = settled(2000, 50, friction, 1500);
        group.bench_function(format!("friction {friction}, tolerance 1e-2"), |bencher| {
            bencher.iter(|| {
                engine
                    .advance(&request(9999), &Forces::default())
                    .expect("converges");
            });
        });
    }
    group.finish();
}

criterion_group!(benches, unit_costs, whole_steps);
criterion_main!(benches);
