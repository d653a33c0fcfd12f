//! The same box and the same collapsing column with rapier2d-f64: CPU time, overlap, error.
//!
//! `cargo bench -p particle-solver --features rapier --bench rapier`
//!
//! Rapier has soft contacts; its defaults (30 Hz) overlap a hundred times more than with the
//! tuned frequencies used here, so only tuned rows are a fair comparison. The reference of the
//! column's position error is this engine at tolerance 1e-4 with the same step: the difference
//! between the two models counts as rapier's error, overlap and remaining motion do not depend
//! on that choice. Rows are run in turn, three times; the smallest CPU time counts.

use particle_solver::{ContactEngine, Facet, Forces, Grains, Request, Setup, State};
use rapier2d_f64::prelude as rapier;
use space::grid::Grid;
use space::{Vector, hypot};

const DT: f64 = 2e-3;
const STEPS: u64 = 100;
const FRICTION: f64 = 0.3;
const COUNT: usize = 2000;
const WIDTH: f64 = 50.0;

/// One row of a table.
#[derive(Clone, Copy)]
enum Row {
    /// This engine to a tolerance.
    Ours(f64),
    /// Rapier: solver iterations, contact frequency \[Hz\] (0: its defaults).
    Rapier(usize, f64),
}

/// What a run gives.
struct Outcome {
    milliseconds: f64,
    position: Vec<Vector<2>>,
    kinetic_energy: f64,
}

fn main() {
    let (grains, settled) = settled();
    let rows = [
        Row::Ours(1e-1),
        Row::Ours(1e-2),
        Row::Ours(1e-3),
        Row::Rapier(4, 0.0),
        Row::Rapier(4, 400.0),
        Row::Rapier(16, 400.0),
        Row::Rapier(16, 2000.0),
        Row::Rapier(64, 2000.0),
    ];
    for (open, name) in [(false, "settled box"), (true, "collapsing column")] {
        let reference = ours(&grains, &settled, open, 1e-4);
        println!("{name}: {COUNT} disks, {STEPS} steps of {DT} s, friction {FRICTION}");
        println!(
            "solver               CPU ms/step  overlap/r mean  max      kinetic energy  rms dx/r"
        );
        let mut best: Vec<Option<Outcome>> = rows.iter().map(|_| None).collect();
        for _ in 0..3 {
            for (row, best) in rows.iter().zip(&mut best) {
                let outcome = match *row {
                    Row::Ours(tolerance) => ours(&grains, &settled, open, tolerance),
                    Row::Rapier(iterations, frequency) => {
                        theirs(&grains, &settled, open, iterations, frequency)
                    }
                };
                let slower = best
                    .as_ref()
                    .is_some_and(|best| best.milliseconds < outcome.milliseconds);
                if !slower {
                    *best = Some(outcome);
                }
            }
        }
        for (row, outcome) in rows.iter().zip(best.into_iter().flatten()) {
            print_row(row, &outcome, &grains, &reference, open);
        }
    }
}

fn print_row(row: &Row, outcome: &Outcome, grains: &Grains, reference: &Outcome, open: bool) {
    let name = match row {
        Row::Ours(tolerance) => format!("ours {tolerance:.0e}"),
        Row::Rapier(iterations, 0.0) => format!("rapier {iterations:2} default"),
        Row::Rapier(iterations, frequency) => format!("rapier {iterations:2} {frequency} Hz"),
    };
    let (mean, max) = overlap(grains, &outcome.position, open);
    let square: f64 = outcome
        .position
        .iter()
        .zip(&reference.position)
        .map(|(x, y)| (x[0] - y[0]).powi(2) + (x[1] - y[1]).powi(2))
        .sum();
    let error = (square / COUNT as f64).sqrt() / 0.5;
    println!(
        "{name:20} {:8.2}     {mean:.2e}        {max:.1e}  {:.2e}        {error:.2e}",
        outcome.milliseconds, outcome.kinetic_energy
    );
}

fn setup(open: bool, tolerance: f64) -> Setup<2> {
    let wall = |a: [f64; 2], b: [f64; 2]| Facet::at_rest([a, b].map(Vector::from));
    let mut walls = vec![wall([0.0, 1e3], [0.0, 0.0]), wall([0.0, 0.0], [1e3, 0.0])];
    if !open {
        walls[1] = wall([0.0, 0.0], [WIDTH, 0.0]);
        walls.push(wall([WIDTH, 0.0], [WIDTH, 1e3]));
    }
    Setup {
        gravity: Vector::from([0.0, -9.81]),
        walls,
        period: [None; 2],
        friction: FRICTION,
        wall_friction: FRICTION,
        inertia_factor: 0.5,
        tolerance,
        solver: Some(Solver::Converged),
        sweeps_max: 200_000,
        sub_steps_max: 100,
    }
}

/// Disks dropped from a lattice until they lie.
fn settled() -> (Grains, State<2>) {
    let mut seed = 12_345u64;
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut grains, mut position) = (Grains::default(), Vec::new());
    for place in 0..COUNT {
        let radius = 0.5 * (0.8 + 0.4 * random());
        grains.radius.push(radius);
        grains.mass.push(std::f64::consts::PI * radius * radius);
        grains.fixed.push(false);
        let x = 1.22 * ((place % 40) as f64 + 0.5) + 0.02 * random();
        position.push(Vector::from([x, 1.22 * ((place / 40) as f64 + 0.5)]));
    }
    let state = State::new(&grains, position, vec![Vector::zeros(); COUNT]).expect("finite");
    let mut engine = ContactEngine::new(setup(false, 1e-2), grains.clone(), state).expect("valid");
    advance(&mut engine, 3000);
    (grains, engine.accepted().clone())
}

fn advance(engine: &mut ContactEngine<2>, steps: u64) {
    for step in 1..=steps {
        let request = Request {
            step,
            pass: 0,
            dt: DT,
            sub_steps: 1,
            tolerance: 0.0,
        };
        engine
            .advance(&request, &Forces::default())
            .expect("converges");
        engine.commit().expect("has a candidate");
    }
}

fn ours(grains: &Grains, start: &State<2>, open: bool, tolerance: f64) -> Outcome {
    let mut engine =
        ContactEngine::new(setup(open, tolerance), grains.clone(), start.clone()).expect("valid");
    let begin = process_seconds();
    advance(&mut engine, STEPS);
    let milliseconds = 1e3 * (process_seconds() - begin) / STEPS as f64;
    let state = engine.accepted();
    let kinetic_energy = state.kinetic_energy(grains, 0.5);
    Outcome {
        milliseconds,
        position: state.position.clone(),
        kinetic_energy,
    }
}

fn theirs(
    grains: &Grains,
    start: &State<2>,
    open: bool,
    iterations: usize,
    frequency: f64,
) -> Outcome {
    let mut world = rapier::PhysicsWorld::new();
    world.gravity = rapier::Vector::new(0.0, -9.81);
    let parameters = &mut world.integration_parameters;
    parameters.dt = DT;
    parameters.num_solver_iterations = iterations;
    parameters.max_ccd_substeps = 0;
    if frequency > 0.0 {
        let softness = rapier::SpringCoefficients::new(frequency, 1.0);
        parameters.contact_softness = softness;
        parameters.static_contact_softness = softness;
    }
    let mut wall = |normal: [f64; 2], at: [f64; 2]| {
        let normal = rapier::Vector::new(normal[0], normal[1]);
        let shape = rapier::SharedShape::halfspace(normal);
        let place = rapier::Vector::new(at[0], at[1]);
        world.colliders.insert(
            rapier::ColliderBuilder::new(shape)
                .translation(place)
                .friction(FRICTION),
        );
    };
    wall([0.0, 1.0], [0.0, 0.0]);
    wall([1.0, 0.0], [0.0, 0.0]);
    if !open {
        wall([-1.0, 0.0], [WIDTH, 0.0]);
    }
    let handles: Vec<_> = (0..COUNT)
        .map(|grain| {
            let [[x, y], [vx, vy]]: [[f64; 2]; 2] =
                [start.position[grain].into(), start.velocity[grain].into()];
            let body = rapier::RigidBodyBuilder::dynamic()
                .translation(rapier::Vector::new(x, y))
                .linvel(rapier::Vector::new(vx, vy))
                .angvel(start.spin[grain])
                .can_sleep(false);
            let handle = world.bodies.insert(body);
            let ball = rapier::ColliderBuilder::ball(grains.radius[grain])
                .friction(FRICTION)
                .restitution(0.0)
                .density(1.0);
            world
                .colliders
                .insert_with_parent(ball, handle, &mut world.bodies);
            handle
        })
        .collect();
    let begin = process_seconds();
    for _ in 0..STEPS {
        world.step();
    }
    let milliseconds = 1e3 * (process_seconds() - begin) / STEPS as f64;
    let mut end = start.clone();
    for (grain, handle) in handles.iter().enumerate() {
        let body = &world.bodies[*handle];
        end.position[grain] = [body.translation().x, body.translation().y].into();
        end.velocity[grain] = [body.linvel().x, body.linvel().y].into();
        end.spin[grain] = body.angvel();
    }
    let kinetic_energy = end.kinetic_energy(grains, 0.5);
    Outcome {
        milliseconds,
        position: end.position,
        kinetic_energy,
    }
}

/// Mean and largest overlap over touching pairs and walls, of r = 0.5.
fn overlap(grains: &Grains, position: &[Vector<2>], open: bool) -> (f64, f64) {
    let mut overlaps = Vec::new();
    Grid::build(position, &grains.radius, &[None; 2]).for_each_pair(|i, j, apart, _| {
        let size = grains.radius[i] + grains.radius[j];
        overlaps.push(size - hypot(&apart));
    });
    for (position, radius) in position.iter().zip(&grains.radius) {
        let far = if open {
            f64::INFINITY
        } else {
            WIDTH - position[0]
        };
        overlaps.extend([position[1], position[0], far].map(|distance| radius - distance));
    }
    let touching = overlaps.iter().copied().filter(|overlap| *overlap > 0.0);
    let (sum, count, max) = touching.fold((0.0, 0.0, 0.0f64), |(sum, count, max), overlap| {
        (sum + overlap, count + 1.0, max.max(overlap))
    });
    (sum / f64::max(count, 1.0) / 0.5, max / 0.5)
}

/// CPU time of this process so far \[s\].
fn process_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
