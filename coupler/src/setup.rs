//! From a scene and its engines to the system that is run and the state it starts from.

use protocol::engine::InitialGrains;
use protocol::message::{Capability, Role};
use protocol::partner::Partner;
use protocol::scene::{CouplerScene, FluidScene, Geometry, ParticleScene, Scheme};
use space::{Dim, Dimension, Vector};

use crate::alone::{Dry, FluidAlone};
use crate::coupled::engines::Engines;
use crate::coupled::lambda::Policy;
use crate::coupled::proximity::Proximity;
use crate::coupled::setting::Deferred;
use crate::coupled::step::Coupled;
use crate::drag::laws::Fluid;
use crate::error::CouplerError;
use crate::exits::Exits;
use crate::follow::Follow;
use crate::immersion::{Immersion, shapes};
use crate::one_way::OneWay;
use crate::seats::door;
use crate::seats::fluid::FluidSeat;
use crate::seats::particles::ParticleSeat;
use crate::state::{Flow, Grains, State};
use crate::system::System;
use crate::transfer::deposit::Transfer;
use crate::transfer::mesh::Mesh;
use crate::walls::with_facets;

/// Contact residual wished for, of the tolerance of the passes: errors of all contacts below a grain
/// add up in it, so a held bed is as still as its contact solve is exact.
const CONTACT_SHARE: f64 = 0.001;

/// A run at its start.
pub struct Begun<const D: usize, const N: usize> {
    /// Who computes.
    pub system: System<D, N>,
    /// The initial state.
    pub state: State<D>,
    /// How the mesh follows grains and flow, where it does.
    pub follow: Option<Follow<D, N>>,
}

/// Configure the engines and take over their initial state.
pub fn begin<const D: usize, const N: usize>(
    scene: &CouplerScene,
    fluid: Option<Partner>,
    particles: Option<Partner>,
    grains: &InitialGrains,
) -> Result<Begun<D, N>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let fluid = match (fluid, &scene.fluid) {
        (Some(partner), Some(part)) => {
            let seat = FluidSeat::new(partner, part, scene.unread(Role::Fluid))?;
            Some((seat, part))
        }
        _ => None,
    };
    let part = particle_part(scene, fluid.as_ref().map(|(seat, _)| seat))?;
    let particles = match (particles, &part) {
        (Some(partner), Some(part)) => {
            let (unread, tolerance) = (scene.unread(Role::Particles), tolerance(scene, part));
            let seated = ParticleSeat::new(partner, part, grains, unread, tolerance)?;
            Some((seated, part))
        }
        (None, Some(part)) if scene.grains_stay => Some((ParticleSeat::fixed(grains)?, part)),
        _ => None,
    };
    match (fluid, particles) {
        (Some(fluid), Some(particles)) => immersed(scene, fluid, particles),
        (Some((fluid, part)), None) => {
            let porosity = vec![1.0; fluid.mesh.nodal_mass.len()];
            Ok(Begun {
                follow: follow(scene, part, &fluid),
                state: state(Grains::default(), at_start(part, &porosity)?, porosity),
                system: System::FluidAlone(Box::new(FluidAlone { fluid })),
            })
        }
        (None, Some(((particles, grains), _))) => Ok(Begun {
            system: System::Dry(Dry { particles }),
            state: state(grains, Flow::default(), Vec::new()),
            follow: None,
        }),
        (None, None) => Err(CouplerError::Nothing),
    }
}

/// The particle engine's part, with the walls of the fluid's mesh where they are the grains' too.
fn particle_part<const D: usize, const N: usize>(
    scene: &CouplerScene,
    fluid: Option<&FluidSeat<D, N>>,
) -> Result<Option<ParticleScene>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    match (&scene.particles, &scene.grain_boundaries, fluid) {
        (Some(part), Some(sides), Some(seat)) => {
            let engine = &seat.engine().hello().engine;
            with_facets::<D>(part, &seat.description.facets, sides, engine).map(Some)
        }
        (part, ..) => Ok(part.clone()),
    }
}

/// Grains in a fluid.
fn immersed<const D: usize, const N: usize>(
    scene: &CouplerScene,
    (mut fluid, part): (FluidSeat<D, N>, &FluidScene),
    ((particles, grains), walls): ((ParticleSeat<D>, Grains<D>), &ParticleScene),
) -> Result<Begun<D, N>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let mut follow = follow(scene, part, &fluid);
    let epoch = fluid.epoch();
    // the first mesh is right; nobody has computed a flow yet
    let begun = state(grains, Flow::default(), Vec::new());
    let wish = |follow: &mut Follow<D, N>| follow.wish(&begun, &fluid.mesh, epoch);
    if let Some(sizes) = follow.as_mut().and_then(wish) {
        fluid.adapt((1, epoch + 1), &sizes)?;
    }
    let grains = begun.grains;
    let exits = exits(scene, &fluid, &particles)?;
    let immersion = immersion(scene, part, &fluid.mesh, &grains.radius, exits)?;
    let porosity = match scene.reaction {
        true => immersion.porosity(&grains, &immersion.place(&grains, 0.0)?)?,
        false => vec![1.0; immersion.transfer.node_count()],
    };
    let state = state(grains, at_start(part, &porosity)?, porosity);
    if !scene.reaction {
        let system = OneWay {
            fluid,
            particles,
            immersion,
        };
        return Ok(Begun {
            system: System::OneWay(Box::new(system)),
            state,
            follow,
        });
    }
    let policy = Policy {
        free: 1.0,
        contacts_told: particles.tells_contacts(),
    };
    let deferred = match fluid.takes_affine_response() {
        true => Deferred::Lagged,
        false => Deferred::Converged,
    };
    let system = Coupled {
        engines: Engines::new(fluid, particles, proximity(walls)?),
        immersion,
        scheme: scene.scheme,
        policy,
        deferred,
    };
    Ok(Begun {
        system: System::Coupled(Box::new(system)),
        state,
        follow,
    })
}

/// How the mesh of a scene follows, where it does.
fn follow<const D: usize, const N: usize>(
    scene: &CouplerScene,
    part: &FluidScene,
    fluid: &FluidSeat<D, N>,
) -> Option<Follow<D, N>>
where
    Dim<D>: Dimension<D>,
{
    Follow::new(
        part.refinement.as_ref(),
        scene.near_grains,
        scene.indicator,
        (fluid.mesh.largest_cell(), &fluid.mesh.period),
    )
}

/// Grains of these radii \[m\] in the fluid of a scene.
fn immersion<const D: usize, const N: usize>(
    scene: &CouplerScene,
    part: &FluidScene,
    mesh: &Mesh<D, N>,
    radii: &[f64],
    exits: Exits<D>,
) -> Result<Immersion<D, N>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let depth = match scene.geometry {
        Geometry::Disk => 1.0,
        Geometry::Sphere { depth } => depth,
    };
    Ok(Immersion {
        transfer: Transfer::new(mesh, depth),
        fluid: Fluid {
            density: part.density,
            dynamic_viscosity: part.dynamic_viscosity,
        },
        gravity: door::vector(&scene.gravity, "gravity")?,
        law: scene.drag,
        shapes: shapes(scene.geometry, radii),
        exits,
    })
}

/// Where grains leave; refused where the engine keeps all.
fn exits<const D: usize, const N: usize>(
    scene: &CouplerScene,
    fluid: &FluidSeat<D, N>,
    particles: &ParticleSeat<D>,
) -> Result<Exits<D>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let exits = Exits::new(&fluid.description.facets, &scene.grain_exits)?;
    match particles.engine() {
        Some(engine) if exits.are_there() && !door::can(engine, Capability::RemovesGrains) => {
            let (engine, names) = (&engine.hello().engine, scene.grain_exits.join(", "));
            Err(CouplerError::Walls {
                why: format!(
                    "grains may leave by {names}, and the particle engine {engine} cannot take grains \
                     out (capability RemovesGrains): take another one, write [particles] boundaries with \
                     \"wall\" there, or \"open\", where a grain that leaves ends the run"
                ),
            })
        }
        _ => Ok(exits),
    }
}

fn state<const D: usize>(grains: Grains<D>, flow: Flow<D>, porosity: Vec<f64>) -> State<D> {
    State {
        grains,
        flow,
        porosity,
        ..State::default()
    }
}

/// Fluid at its initial velocity, pressure hydrostatic.
fn at_start<const D: usize>(part: &FluidScene, porosity: &[f64]) -> Result<Flow<D>, CouplerError> {
    let superficial: Vector<D> = door::vector(&part.initial_velocity, "initial_velocity")?;
    let gravity: Vector<D> = door::vector(&part.gravity, "gravity")?;
    Ok(Flow {
        velocity: porosity.iter().map(|phi| superficial / *phi).collect(),
        pressure_gradient: vec![gravity * part.density; porosity.len()],
    })
}

/// Contact residual asked for: that of the scene, and well below the defect that ends the passes,
/// which could not be reached otherwise.
fn tolerance(scene: &CouplerScene, part: &ParticleScene) -> f64 {
    match scene.scheme {
        Scheme::Iterated { tolerance, .. } if scene.fluid.is_some() => {
            part.tolerance.min(CONTACT_SHARE * tolerance)
        }
        _ => part.tolerance,
    }
}

/// Walls and periods that grains may meet.
fn proximity<const D: usize>(scene: &ParticleScene) -> Result<Proximity<D>, CouplerError> {
    Ok(Proximity {
        walls: scene
            .walls
            .iter()
            .map(door::corners)
            .collect::<Result<_, _>>()?,
        period: door::period(&scene.period)?,
    })
}
