//! A random packing of disks in a box under a flow that is switched on: held, then lifted.

use coupler::simulation::Simulation;
use protocol::engine::InitialGrains;
use protocol::scene::{
    Boundary, ContactSolver, CouplerScene, ParticleScene, Profile, Scheme, Wall,
};
use space::flat::numbers;
use tests::grains::{Noise, disks, frozen, lattice};
use tests::{couple, fluid, mean, particles, pressure, scene, with_boundaries};

const DIAMETER: f64 = 1e-3;
const WIDTH: f64 = 20.0 * DIAMETER;
const HEIGHT: f64 = 25.0 * DIAMETER;
const DENSITY: f64 = 1000.0;
const GRAIN_DENSITY: f64 = 2000.0;
const VISCOSITY: f64 = 0.1;
/// Part of a diameter that the fluid at U_mf may move in a step.
const STEP_OF_DIAMETER: f64 = 0.05;

fn container(friction: f64, gravity: f64) -> ParticleScene {
    let mut engine = particles([0.0, -gravity]);
    // grains as large as these are spread over two cells: in steps of 1e6 relaxation times the first one
    // moves pairs past each other by some hundred sub-steps
    engine.sub_steps_max = 1000;
    let wall = Wall::segment;
    engine.walls = vec![
        wall([0.0, 4.0 * HEIGHT], [0.0, 0.0]),
        wall([0.0, 0.0], [WIDTH, 0.0]),
        wall([WIDTH, 0.0], [WIDTH, 4.0 * HEIGHT]),
    ];
    engine.friction = friction;
    engine.wall_friction = friction;
    engine.tolerance = 1e-4;
    // without friction a packing made in small steps still creeps after a second, and sinks when the flow comes
    engine.solver = Some(ContactSolver::Converged);
    engine
}

/// 200 disks, ±10 %, rained into the box without fluid and left until they rest.
fn packing(friction: f64) -> InitialGrains {
    let mut noise = Noise::new(5);
    let radii: Vec<f64> = (0..200)
        .map(|_| 0.5 * DIAMETER * (1.0 + noise.around(0.1)))
        .collect();
    let centres: Vec<[f64; 2]> = lattice([0.0, 0.0], 1.2 * DIAMETER, [16, 13])
        .iter()
        .take(200)
        .map(|x| {
            [
                x[0] + 0.3 * DIAMETER + noise.around(0.04 * DIAMETER),
                x[1] + noise.around(0.04 * DIAMETER),
            ]
        })
        .collect();
    let mut grains = disks(&centres, &radii, GRAIN_DENSITY);
    let dt = 2e-4;
    let mut coupling = couple(scene(None, Some(container(friction, 9.81)), dt, 1), &grains);
    for step in 1..=5000 {
        coupling
            .advance(dt)
            .unwrap_or_else(|error| panic!("packing, step {step}: {error}"));
    }
    let speed = numbers(&coupling.state.grains.velocity)
        .iter()
        .fold(0.0_f64, |max, v| max.max(v.abs()));
    println!("packing at friction {friction}: fastest grain {speed:.1e} m/s");
    assert!(speed < 1e-3, "the packing moves at {speed} m/s");
    grains.position = numbers(&coupling.state.grains.position).to_vec();
    immersed(friction, grains)
}

/// Let a packing rest in the fluid: gaps of 1e-5 radii, which a dry step closes at once, take
/// hundreds of the shortest steps in the fluid, and until then the bed sinks.
fn immersed(friction: f64, mut grains: InitialGrains) -> InitialGrains {
    let dt = 1e3 * relaxation(&grains);
    let mut coupling = couple(through_flow(friction, 9.81, 0.0, dt), &grains);
    for step in 1..=40 {
        coupling
            .advance(dt)
            .unwrap_or_else(|error| panic!("immersed, step {step}: {error}"));
    }
    grains.position = numbers(&coupling.state.grains.position).to_vec();
    grains
}

/// m/γ of a mean grain of the packing \[s\].
fn relaxation(grains: &InitialGrains) -> f64 {
    let mass = grains.mass.iter().sum::<f64>() / grains.mass.len() as f64;
    mass / (11.52 * VISCOSITY * 0.2_f64.powf(-2.8))
}

fn through_flow(friction: f64, gravity: f64, speed: f64, dt: f64) -> CouplerScene {
    let fluid = with_boundaries(
        fluid(
            DENSITY,
            VISCOSITY,
            [0.0, -gravity],
            [0.0, 0.0],
            [WIDTH, HEIGHT],
            [8, 10],
        ),
        &[
            ("left", Boundary::Slip),
            ("right", Boundary::Slip),
            (
                "bottom",
                Boundary::Inflow {
                    velocity: vec![0.0, speed],
                    profile: Profile::Uniform,
                },
            ),
            ("top", Boundary::Open { pressure: 0.0 }),
        ],
    );
    let mut scene = scene(Some(fluid), Some(container(friction, gravity)), dt, 1);
    scene.scheme = Scheme::Iterated {
        tolerance: 1e-3,
        passes_max: 40,
    };
    scene
}

/// Pressure at the bottom without its hydrostatic part, over the packing's weight a width.
fn carried_by_fluid(coupling: &mut Simulation<2, 3>, gravity: f64) -> f64 {
    let nodal = pressure(coupling);
    let seat = coupling.system.fluid().expect("a fluid");
    let bottom: Vec<f64> = (0..nodal.len())
        .filter(|node| seat.mesh.node_position[*node][1] == 0.0)
        .map(|node| nodal[node])
        .collect();
    let excess = bottom.iter().sum::<f64>() / bottom.len() as f64 - DENSITY * gravity * HEIGHT;
    let volume: f64 = coupling.state.grains.volume.iter().sum();
    excess * WIDTH / (volume * (GRAIN_DENSITY - DENSITY) * gravity)
}

#[test]
fn a_random_packing_takes_a_flow_switched_on_below_and_above_fluidisation() {
    for friction in [0.0, 0.3] {
        let grains = packing(friction);
        println!(
            "| friction | U/U_mf | a | passes per step | carried by the fluid | mean rise/U_mf | momentum defect |"
        );
        // the flow whose pressure drop on the frozen packing is its weight, per unit of gravity
        let probe = 1e-6;
        let mut still = couple(
            through_flow(friction, 9.81, probe, 1.0),
            &frozen(grains.clone()),
        );
        for _ in 0..5 {
            still.advance(1.0).unwrap_or_else(|error| panic!("{error}"));
        }
        let fluidisation_per_gravity = probe / carried_by_fluid(&mut still, 9.81) / 9.81;
        for ratio in [0.5, 1.3] {
            for stiffness in [1.0, 1e3, 1e6] {
                let dt = stiffness * relaxation(&grains);
                // long steps in weak gravity, so that a step is no longer than the motion it resolves
                let gravity =
                    (STEP_OF_DIAMETER * DIAMETER / dt / fluidisation_per_gravity).min(9.81);
                let fluidisation = fluidisation_per_gravity * gravity;
                let mut coupling = couple(
                    through_flow(friction, gravity, ratio * fluidisation, dt),
                    &grains,
                );
                let (mut passes, mut worst, mut fastest) = (Vec::new(), 0.0_f64, 0.0_f64);
                let steps = 12;
                for step in 1..=steps {
                    let report = coupling.advance(dt).unwrap_or_else(|error| {
                        panic!(
                            "friction {friction} U/U_mf {ratio} a {stiffness} step {step}: {error}"
                        )
                    });
                    passes.push(report.passes);
                    worst = worst.max(report.budget.momentum_defect);
                    fastest = fastest.max(
                        numbers(&coupling.state.grains.velocity)
                            .iter()
                            .fold(0.0_f64, |max, v| max.max(v.abs())),
                    );
                }
                let carried = carried_by_fluid(&mut coupling, gravity);
                let rise = mean(numbers(&coupling.state.grains.velocity), 1) / fluidisation;
                println!(
                    "| {friction} | {ratio} | {stiffness:e} | {passes:?} | {carried:.4} | {rise:.3} | {worst:.1e} |"
                );
                assert!(worst <= 2e-3, "momentum defect {worst}");
                assert!(
                    fastest < 50.0 * ratio * fluidisation,
                    "growth: {fastest} for U_mf {fluidisation}"
                );
                // a frictional packing is loose and, in steps of forty sub-steps, consolidates on its way
                if ratio < 1.0 && (friction == 0.0 || stiffness < 1e6) {
                    assert!((carried / ratio - 1.0).abs() < 0.05, "carried {carried}");
                }
            }
        }
    }
}
