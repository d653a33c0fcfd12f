//! The fluid seat: the only file that knows the protocol. It translates, nothing more.

use std::path::Path;
use std::process::ExitCode;

use protocol::engine::{Computed, FacetDescription, FluidEngine, Inputs, MeshDescription, Outputs};
use protocol::field::Field;
use protocol::message::{
    Advance, BoundaryKind, Capability, Diagnostic, Failure, FailureKind, MeshBoundary,
};
use protocol::report::FluidReport;
use protocol::scene::{
    self, CREEPING_REYNOLDS, Convection, FluidScene, MeanFlow, MeshSource, fixed,
};

use gmsh::Options;
use space::{Vector, flat};

use crate::boundary::condition::{Condition, periodic_directions};
use crate::candidate::Request;
use crate::config::{FluidConfig, Nonlinear, TimeScheme};
use crate::equations::coefficients::ViscousForm;
use crate::error::FluidError;
use crate::mesh::file;
use crate::mesh::rectangle::{Diagonals, Rectangle};
use crate::mesh::simplices::Mesh;
use crate::mesh::{Place, Root, Zone};
use crate::refined::{self, Refined, Refinement};
use crate::solid::SolidFields;
use crate::state::State;
use crate::step::FluidSolver;

/// Numbers of a candidate that the report tells.
const TYPED: [&str; 3] = ["solid_power", "reynolds", "convection"];

/// The built-in fluid engine, in the plane: the scene's meshes are plane.
#[derive(Default)]
pub struct Engine {
    solver: Option<FluidSolver<2, 3>>,
    /// How its mesh follows, where the scene asks for that.
    refined: Option<Refined<2, 3>>,
}

/// `main` of the engine's process.
pub fn run() -> ExitCode {
    protocol::engine::run_fluid(Engine::default())
}

impl FluidEngine for Engine {
    fn identity(&self) -> (&'static str, &'static str) {
        ("sillage-fluid", env!("CARGO_PKG_VERSION"))
    }

    fn capabilities(&self) -> Vec<Capability> {
        vec![
            Capability::AffineResponse,
            Capability::Checkpoint,
            Capability::ConvectionAsNeeded,
            Capability::SteersMeanFlow,
            Capability::Adapts,
        ]
    }

    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        let config = config(scene).map_err(unusable)?;
        let refuse = |error: FluidError| Failure::new(FailureKind::Scene, error.to_string());
        let source = Source::of(&scene.mesh).map_err(unusable)?;
        let solver = match &scene.refinement {
            None => {
                let mesh = source.mesh(&config).map_err(refuse)?;
                FluidSolver::new(config, mesh).map_err(refuse)?
            }
            Some(sizes) => {
                let sizes = refinement(sizes).map_err(unusable)?;
                let (solver, follows) = source.refined(config, &sizes).map_err(refuse)?;
                self.refined = Some(follows);
                solver
            }
        };
        let description = describe(&solver);
        self.solver = Some(solver);
        Ok(description)
    }

    fn adapt(&mut self, sizes: &scene::Refinement) -> Result<Option<MeshDescription>, Failure> {
        let sizes = refinement(sizes).map_err(unusable)?;
        let (Some(solver), Some(refined)) = (&mut self.solver, &mut self.refined) else {
            return Ok(None);
        };
        refined.adapt(solver, &sizes).map_err(failure)?;
        Ok(Some(describe(solver)))
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        mut outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure> {
        let fields = SolidFields {
            porosity: inputs.get(Field::Porosity),
            drag: inputs.get(Field::Drag),
            drag_source: inputs.get(Field::DragSource),
            entrained_fraction: inputs.get(Field::EntrainedFraction),
            solid_flux: inputs.get(Field::SolidFlux),
            solid_mobility: inputs.get(Field::SolidMobility),
            fixed_drag: inputs.get(Field::FixedDrag),
        };
        let request = Request {
            step: request.step,
            pass: request.pass,
            dt: request.dt,
        };
        let candidate = self.solver()?.advance(&request, &fields);
        let candidate = candidate.map_err(failure)?;
        let copies = [
            (
                Field::InterstitialVelocity,
                flat::numbers(&candidate.interstitial_velocity),
            ),
            (
                Field::PressureGradient,
                flat::numbers(&candidate.pressure_gradient),
            ),
            (Field::Pressure, &candidate.state.pressure[..]),
        ];
        for (field, values) in copies {
            outputs.take(field).copy_from_slice(values);
        }
        let numbers = candidate.diagnostics.iter();
        let told = |wanted: &str| {
            let found = numbers.clone().find(|(name, _)| name == wanted);
            found.map(|(_, value)| *value)
        };
        Ok(Computed {
            report: FluidReport {
                solid_power: told("solid_power"),
                reynolds: told("reynolds"),
                convects: told("convection").map(|there| there != 0.0),
            },
            diagnostics: numbers
                .clone()
                .filter(|(name, _)| !TYPED.contains(&name.as_str()))
                .map(|(name, value)| Diagnostic {
                    name: name.clone(),
                    value: *value,
                })
                .collect(),
        })
    }

    fn commit(&mut self) -> Result<(), Failure> {
        self.solver()?.commit().map_err(failure)
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.solver()?.state().save(path).map_err(failure)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        let solver = self.solver()?;
        let state = State::load(path, solver.mesh().node_count()).map_err(failure)?;
        solver.set_state(state);
        Ok(())
    }
}

impl Engine {
    fn solver(&mut self) -> Result<&mut FluidSolver<2, 3>, Failure> {
        let missing = || Failure::new(FailureKind::Engine, "the engine is not configured");
        self.solver.as_mut().ok_or_else(missing)
    }
}

/// The class of an error that happened while running.
fn failure(error: FluidError) -> Failure {
    let kind = match &error {
        FluidError::Porosity { .. } | FluidError::NotFinite { .. } => FailureKind::NotFinite,
        FluidError::NotConverged { .. } | FluidError::LinearResidual { .. } => {
            FailureKind::NotConverged
        }
        FluidError::Unbalanced { .. } | FluidError::TooFine { .. } => FailureKind::Scene,
        _ => FailureKind::Engine,
    };
    Failure::new(kind, error.to_string())
}

fn unusable(why: String) -> Failure {
    Failure::new(FailureKind::Scene, why)
}

fn config(scene: &FluidScene) -> Result<FluidConfig<2>, String> {
    let mut config = FluidConfig::new(scene.density, scene.dynamic_viscosity);
    let named = scene.boundaries.iter();
    config.boundaries = named
        .map(|(name, boundary)| Ok((name.clone(), condition(&boundary.try_map(|v| fixed(v))?))))
        .collect::<Result<_, String>>()?;
    config.gravity = fixed(&scene.gravity)?.into();
    config.convection = scene.convection != Convection::Never;
    config.creeping_below = (scene.convection == Convection::AsNeeded).then_some(CREEPING_REYNOLDS);
    config.grad_div = scene.grad_div;
    config.threads = scene.threads;
    config.initial_velocity = fixed(&scene.initial_velocity)?.into();
    config.mean_flow = match &scene.mean_flow {
        MeanFlow::Free => None,
        MeanFlow::Zero => Some(Vector::zeros()),
        MeanFlow::Velocity(velocity) => Some(fixed(velocity)?.into()),
    };
    config.time_scheme = match scene.time_scheme {
        scene::TimeScheme::BackwardEuler => TimeScheme::BackwardEuler,
        scene::TimeScheme::Bdf2 => TimeScheme::Bdf2,
        scene::TimeScheme::Steady => TimeScheme::Steady,
    };
    config.nonlinear = match scene.nonlinear {
        scene::Nonlinear::Picard => Nonlinear::Picard,
        scene::Nonlinear::Newton {
            tolerance,
            iterations_max,
        } => Nonlinear::Newton {
            tolerance,
            iterations_max,
        },
    };
    config.viscous_form = match scene.viscous_form {
        scene::ViscousForm::Symmetric => ViscousForm::Symmetric,
        scene::ViscousForm::PaperLiteral => ViscousForm::PaperLiteral,
    };
    Ok(config)
}

fn condition(boundary: &scene::Boundary<[f64; 2]>) -> Condition<2> {
    match boundary {
        scene::Boundary::NoSlip => Condition::NoSlip,
        scene::Boundary::Slip => Condition::Slip,
        scene::Boundary::Periodic => Condition::Periodic,
        scene::Boundary::Inflow { velocity, profile } => match profile {
            scene::Profile::Uniform => Condition::uniform(*velocity),
            scene::Profile::Parabolic => Condition::Parabolic((*velocity).into()),
        },
        scene::Boundary::Open { pressure } => Condition::Open(*pressure),
        scene::Boundary::MovingWall { velocity } => Condition::MovingWall((*velocity).into()),
    }
}

fn refinement(asked: &scene::Refinement) -> Result<Refinement<2>, String> {
    let zone = |region: &scene::Region| {
        let place = match region {
            scene::Region::Ball { centre, radius, .. } => Place::Ball {
                centre: fixed(centre)?.into(),
                radius: *radius,
            },
            scene::Region::Box { lower, upper, .. } => Place::Box {
                lower: fixed(lower)?.into(),
                upper: fixed(upper)?.into(),
            },
        };
        let size = region.size();
        Ok(Zone { place, size })
    };
    Ok(Refinement {
        zones: asked
            .regions
            .iter()
            .map(zone)
            .collect::<Result<_, String>>()?,
        growth: asked.growth,
        largest: asked.largest,
    })
}

/// Where the mesh comes from.
enum Source<'a> {
    File(&'a Path, Options),
    Rectangle(Rectangle),
}

impl Source<'_> {
    fn of(source: &MeshSource) -> Result<Source<'_>, String> {
        Ok(match source {
            MeshSource::File {
                path,
                scale,
                surfaces,
            } => {
                let (scale, surfaces) = (*scale, surfaces.clone());
                Source::File(Path::new(path), Options { scale, surfaces })
            }
            MeshSource::Rectangle {
                lower,
                upper,
                cells,
                diagonals,
                grading,
            } => Source::Rectangle(Rectangle {
                lower: fixed(lower)?.into(),
                upper: fixed(upper)?.into(),
                cells: fixed(cells)?,
                diagonals: match diagonals {
                    scene::Diagonals::Alternate => Diagonals::Alternate,
                    scene::Diagonals::Uniform => Diagonals::Uniform,
                },
                grading: fixed(grading)?.into(),
                periodic: [false; 2],
            }),
        })
    }
}

impl Source<'_> {
    fn mesh(self, config: &FluidConfig<2>) -> Result<Mesh<2, 3>, FluidError> {
        match self {
            Source::File(path, options) => {
                file::read(path, &options, |name| config.boundaries.contains_key(name))
            }
            Source::Rectangle(rectangle) => {
                let periodic = periodic_directions(&config.boundaries)?;
                let rectangle = Rectangle {
                    periodic,
                    ..rectangle
                };
                rectangle.mesh()
            }
        }
    }

    /// A solver whose mesh is refined from this one.
    fn refined(
        self,
        config: FluidConfig<2>,
        sizes: &Refinement<2>,
    ) -> Result<(FluidSolver<2, 3>, Refined<2, 3>), FluidError> {
        match self {
            Source::Rectangle(rectangle) if rectangle.grading == Vector::from([1.0; 2]) => {
                let root = Root {
                    lower: rectangle.lower,
                    upper: rectangle.upper,
                    cells: rectangle.cells,
                    periodic: periodic_directions(&config.boundaries)?,
                };
                refined::solver(config, &root, sizes)
            }
            Source::Rectangle(_) => Err(FluidError::Mesh(
                "a rectangle is refined from cells of one size: leave its grading out".to_owned(),
            )),
            Source::File(..) => {
                let mesh = self.mesh(&config)?;
                refined::solver_on_mesh(config, &mesh, sizes)
            }
        }
    }
}

/// The mesh as the coupler needs it.
fn describe(solver: &FluidSolver<2, 3>) -> MeshDescription {
    let mesh = solver.mesh();
    tracing::info!(
        nodes = mesh.node_count(),
        triangles = mesh.simplices.len(),
        "mesh"
    );
    let nodes = mesh.simplices.iter().flatten();
    MeshDescription {
        dimension: 2,
        node_position: flat::numbers(&mesh.position).to_vec(),
        simplex_nodes: nodes.map(|&node| node as u32).collect(),
        simplex_position: flat::numbers(mesh.corners.as_flattened()).to_vec(),
        nodal_mass: mesh.nodal_mass.clone(),
        period: mesh.period.to_vec(),
        facets: describe_facets(solver),
    }
}

/// Its boundary; sides that are joined have none.
fn describe_facets(solver: &FluidSolver<2, 3>) -> FacetDescription {
    let (mesh, constraints) = (solver.mesh(), solver.constraints());
    let names = mesh.boundary_names.iter().enumerate();
    let boundaries = names.filter_map(|(number, name)| {
        let kind = kind(constraints.condition(number))?;
        let name = name.clone();
        Some((number, MeshBoundary { name, kind }))
    });
    let (numbers, boundaries): (Vec<usize>, Vec<MeshBoundary>) = boundaries.unzip();
    let mut told = FacetDescription {
        boundaries,
        ..FacetDescription::default()
    };
    for facet in &mesh.facets {
        let of_facet = numbers.iter().position(|&number| number == facet.boundary);
        let Some(boundary) = of_facet else { continue };
        let corners = facet.corner.map(|k| mesh.corners[facet.simplex][k]);
        told.position.extend_from_slice(flat::numbers(&corners));
        told.boundary.push(boundary as u32);
        let velocity = constraints.given_velocity(mesh, facet);
        told.velocity.extend(velocity.iter());
    }
    told
}

/// What a condition makes of its boundary; none where sides are joined.
fn kind(condition: &Condition<2>) -> Option<BoundaryKind> {
    match condition {
        Condition::NoSlip => Some(BoundaryKind::NoSlip),
        Condition::Slip => Some(BoundaryKind::Slip),
        Condition::Periodic => None,
        Condition::Uniform(_) | Condition::Parabolic(_) | Condition::Function(_) => {
            Some(BoundaryKind::Inflow)
        }
        Condition::Open(_) => Some(BoundaryKind::Open),
        Condition::MovingWall(_) => Some(BoundaryKind::MovingWall),
    }
}
