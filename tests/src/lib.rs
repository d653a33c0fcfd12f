//! What the tests share: coupled scenes built in code, run with our engines on threads over the
//! protocol's in-process transport, and reference tables.

use std::collections::BTreeMap;

use coupler::simulation::Simulation;
use protocol::engine::{InitialGrains, serve_fluid, serve_particles};
use protocol::local::{LIMITS, connect};
use protocol::message::Role;
use protocol::partner::Partner;
use protocol::scene::{
    Boundary, CouplerScene, Diagonals, DragLaw, FluidScene, Geometry, Limits, MeshSource,
    NearGrains, Nonlinear, ParticleScene, Refinement, Scheme, TimeScheme, ViscousForm, Wall,
};
use recording::Recorder;
use space::{Dim, Dimension};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

pub mod arguments;
pub mod exchange;
pub mod grains;
pub mod in_space;
pub mod inputs;
pub mod laws;
pub mod meshes;
pub mod profile;
pub mod recorded;
pub mod reference;

/// A rectangle of fluid at rest, closed by no-slip walls, Stokes flow unless changed.
pub fn fluid(
    density: f64,
    viscosity: f64,
    gravity: [f64; 2],
    lower: [f64; 2],
    upper: [f64; 2],
    cells: [usize; 2],
) -> FluidScene {
    let sides = ["left", "right", "bottom", "top"];
    FluidScene {
        dimension: 2,
        density,
        dynamic_viscosity: viscosity,
        gravity: gravity.to_vec(),
        mesh: MeshSource::Rectangle {
            lower: lower.to_vec(),
            upper: upper.to_vec(),
            cells: cells.to_vec(),
            diagonals: Diagonals::Alternate,
            grading: vec![1.0, 1.0],
        },
        boundaries: sides
            .into_iter()
            .map(|side| (side.to_owned(), Boundary::NoSlip))
            .collect::<BTreeMap<_, _>>(),
        convection: false.into(),
        time_scheme: TimeScheme::BackwardEuler,
        nonlinear: Nonlinear::Picard,
        viscous_form: ViscousForm::Symmetric,
        grad_div: 1.0,
        initial_velocity: vec![0.0, 0.0],
        threads: 1,
        refinement: None,
        mean_flow: Default::default(),
    }
}

/// Set a condition on some sides.
pub fn with_boundaries(mut scene: FluidScene, conditions: &[(&str, Boundary)]) -> FluidScene {
    for (side, condition) in conditions {
        scene
            .boundaries
            .insert((*side).to_owned(), condition.clone());
    }
    scene
}

/// Cut all cells along the same diagonal: a lattice then has exactly uniform porosity.
pub fn with_uniform_diagonals(mut scene: FluidScene) -> FluidScene {
    if let MeshSource::Rectangle { diagonals, .. } = &mut scene.mesh {
        *diagonals = Diagonals::Uniform;
    }
    scene
}

/// Frictionless grains without walls.
pub fn particles(gravity: [f64; 2]) -> ParticleScene {
    ParticleScene {
        dimension: 2,
        gravity: gravity.to_vec(),
        walls: Vec::new(),
        period: vec![None, None],
        friction: 0.0,
        wall_friction: 0.0,
        inertia_factor: 0.5,
        tolerance: 1e-4,
        solver: None,
        sweeps_max: 50_000,
        sub_steps_max: 100,
        threads: 1,
    }
}

/// The four walls of a box, grains inside.
pub fn box_walls(lower: [f64; 2], upper: [f64; 2]) -> Vec<Wall> {
    let corners = [lower, [upper[0], lower[1]], upper, [lower[0], upper[1]]];
    (0..4)
        .map(|side| Wall::segment(corners[side], corners[(side + 1) % 4]))
        .collect()
}

/// A scene of both, in one pass a step unless contacts ask for more.
pub fn scene(
    fluid: Option<FluidScene>,
    particles: Option<ParticleScene>,
    coupling_step: f64,
    steps: usize,
) -> CouplerScene {
    let gravity = fluid
        .as_ref()
        .map(|part| part.gravity.clone())
        .or(particles.as_ref().map(|part| part.gravity.clone()));
    CouplerScene {
        dimension: 2,
        end_time: coupling_step * steps as f64,
        coupling_step,
        step_min: None,
        adaptive: None,
        gravity: gravity.unwrap_or(vec![0.0, 0.0]),
        fluid,
        particles,
        grains_stay: false,
        grain_boundaries: None,
        grain_exits: Vec::new(),
        near_grains: None,
        indicator: None,
        grains_file: None,
        scheme: Scheme::Iterated {
            tolerance: 1e-3,
            passes_max: 40,
        },
        drag: DragLaw::Dallavalle,
        geometry: Geometry::Disk,
        reaction: true,
        output_every: None,
        limits: Limits {
            connect: 10.0,
            configure: 60.0,
            step: 600.0,
        },
    }
}

/// Cells of this size near the grains, the cells of the scene being the root; the margin as it is chosen where a scene
/// says nothing, and the growth too: 0.2.
pub fn refined(mut scene: CouplerScene, near_grains: f64) -> CouplerScene {
    let fluid = scene.fluid.as_mut().expect("a fluid");
    fluid.refinement = Some(Refinement {
        growth: 0.2,
        largest: None,
        regions: Vec::new(),
    });
    scene.near_grains = Some(NearGrains {
        size: near_grains,
        margin: 2.0 * near_grains,
    });
    scene
}

/// Where cells are small: for tables.
pub fn place_of(refined: bool) -> &'static str {
    match refined {
        true => "near grains",
        false => "everywhere",
    }
}

/// Nodes of the mesh of the accepted state.
pub fn node_count(coupling: &Simulation<2, 3>) -> usize {
    let seat = coupling.system.fluid().expect("a fluid");
    seat.mesh.node_position.len()
}

/// Start our engines on threads and couple them.
pub fn couple(scene: CouplerScene, grains: &InitialGrains) -> Simulation<2, 3> {
    couple_recorded(scene, grains, None)
}

/// The same in space.
pub fn couple_in_space(scene: CouplerScene, grains: &InitialGrains) -> Simulation<3, 4> {
    simulation(scene, grains, None)
}

/// One of our engines on a thread, its link recorded when there is a recorder.
pub fn engine(role: Role, recorder: Option<&Recorder>) -> Partner {
    let link = match role {
        Role::Fluid => connect(role, |link| {
            serve_fluid(&mut fluid_solver::serve::Engine::default(), link)
        }),
        Role::Particles => connect(role, |link| {
            serve_particles(&mut particle_solver::serve::Engine::default(), link)
        }),
    }
    .unwrap_or_else(|error| panic!("{error}"));
    let link = match recorder {
        Some(recorder) => recorder.tap(role, link),
        None => link,
    };
    Partner::greet(role, link, &LIMITS).unwrap_or_else(|error| panic!("{error}"))
}

/// The same, with all that is exchanged recorded.
pub fn couple_recorded(
    scene: CouplerScene,
    grains: &InitialGrains,
    recorder: Option<&Recorder>,
) -> Simulation<2, 3> {
    simulation(scene, grains, recorder)
}

fn simulation<const D: usize, const N: usize>(
    scene: CouplerScene,
    grains: &InitialGrains,
    recorder: Option<&Recorder>,
) -> Simulation<D, N>
where
    Dim<D>: Dimension<D>,
{
    // SILLAGE_LOG=coupler=debug shows passes.
    let asked = std::env::var("SILLAGE_LOG").unwrap_or("error".to_owned());
    let targets: Targets = asked.parse().expect("levels of targets");
    let lines = tracing_subscriber::fmt::layer()
        .without_time()
        .with_test_writer();
    let _ = tracing_subscriber::registry()
        .with(targets)
        .with(lines)
        .try_init();
    let fluid = scene.fluid.is_some().then(|| engine(Role::Fluid, recorder));
    let particles = scene
        .particles
        .is_some()
        .then(|| engine(Role::Particles, recorder));
    Simulation::new(scene, fluid, particles, grains).unwrap_or_else(|error| panic!("{error}"))
}

/// Nodal pressure of the accepted state \[Pa\].
pub fn pressure<const D: usize, const N: usize>(coupling: &mut Simulation<D, N>) -> Vec<f64>
where
    Dim<D>: Dimension<D>,
{
    let (fluid, _) = coupling.system.seats_mut();
    let seat = fluid.expect("a fluid");
    seat.pressure().expect("the engine tells it").to_vec()
}

/// Mean of one component of an interleaved field.
pub fn mean(interleaved: &[f64], axis: usize) -> f64 {
    let count = interleaved.len() / 2;
    interleaved.iter().skip(axis).step_by(2).sum::<f64>() / count as f64
}

/// Observed order of convergence between consecutive rows of (size, error).
pub fn orders(rows: &[(f64, f64)]) -> Vec<f64> {
    rows.windows(2)
        .map(|pair| (pair[0].1 / pair[1].1).ln() / (pair[0].0 / pair[1].0).ln())
        .collect()
}
