//! The fluid seat: the only file that knows the protocol. It translates, nothing more.

use std::path::Path;
use std::process::ExitCode;

use protocol::engine::{
    Computed, FacetDescription, FluidEngine, Inputs, MeshDescription, Outputs, PlaneOrSpace,
};
use protocol::field::Field;
use protocol::message::{
    Advance, BoundaryKind, Capability, Diagnostic, Failure, FailureKind, MeshBoundary,
};
use protocol::report::FluidReport;
use protocol::scene::{
    self, CREEPING_REYNOLDS, Convection, FluidScene, MeanFlow, MeshSource, fixed,
};

use gmsh::Options;
use space::{Dim, Dimension, Vector, flat};

use crate::boundary::condition::Condition;
use crate::candidate::Request;
use crate::config::{FluidConfig, Nonlinear, TimeScheme};
use crate::equations::coefficients::ViscousForm;
use crate::error::FluidError;
use crate::mesh::rectangle::{Diagonals, Rectangle};
use crate::mesh::{Place, Root, Zone};
use crate::refined::{Refined, Refinement};
use crate::solid::SolidFields;
use crate::source::{MeshFile, Source};
use crate::state::State;
use crate::step::FluidSolver;

/// Numbers of a candidate that the report tells.
const TYPED: [&str; 3] = ["solid_power", "reynolds", "convection"];

/// The built-in fluid engine.
pub type Engine = PlaneOrSpace<Fluid<2, 3>, Fluid<3, 4>>;

/// The same in `D` dimensions.
#[derive(Default)]
pub struct Fluid<const D: usize, const N: usize>
where
    Dim<D>: Dimension<D>,
{
    solver: Option<FluidSolver<D, N>>,
    /// How its mesh follows, where the scene asks for that.
    refined: Option<Refined<D, N>>,
}

/// `main` of the engine's process.
pub fn run() -> ExitCode {
    protocol::engine::run_fluid(Engine::default())
}

impl<const D: usize, const N: usize> FluidEngine for Fluid<D, N>
where
    Dim<D>: Seated<D, N>,
{
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
        let source = source(&scene.mesh).map_err(unusable)?;
        let solver = match &scene.refinement {
            None => source.solver(config).map_err(refuse)?,
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

impl<const D: usize, const N: usize> Fluid<D, N>
where
    Dim<D>: Dimension<D>,
{
    fn solver(&mut self) -> Result<&mut FluidSolver<D, N>, Failure> {
        let missing = || Failure::new(FailureKind::Engine, "the engine is not configured");
        self.solver.as_mut().ok_or_else(missing)
    }
}

/// The class of an error that happened while running.
fn failure(error: FluidError) -> Failure {
    let kind = match &error {
        FluidError::Porosity { .. } | FluidError::NotFinite { .. } => FailureKind::NotFinite,
        FluidError::NotConverged { .. }
        | FluidError::LinearResidual { .. }
        | FluidError::Krylov { .. } => FailureKind::NotConverged,
        FluidError::Unbalanced { .. } | FluidError::TooFine { .. } => FailureKind::Scene,
        _ => FailureKind::Engine,
    };
    Failure::new(kind, error.to_string())
}

fn unusable(why: String) -> Failure {
    Failure::new(FailureKind::Scene, why)
}

fn config<const D: usize>(scene: &FluidScene) -> Result<FluidConfig<D>, String> {
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

fn condition<const D: usize>(boundary: &scene::Boundary<[f64; D]>) -> Condition<D> {
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

fn refinement<const D: usize>(asked: &scene::Refinement) -> Result<Refinement<D>, String> {
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

/// Dimensions that scenes have, with the cells that there are in each.
pub trait Seated<const D: usize, const N: usize>: Dimension<D> {
    /// Cells that a scene describes; an error for those of another dimension.
    fn cells(mesh: &MeshSource) -> Result<Box<dyn Source<D, N>>, String>;
}

impl Seated<2, 3> for Dim<2> {
    fn cells(mesh: &MeshSource) -> Result<Box<dyn Source<2, 3>>, String> {
        let MeshSource::Rectangle {
            lower,
            upper,
            cells,
            diagonals,
            grading,
        } = mesh
        else {
            return Err("a box is of space: in the plane write a rectangle".to_owned());
        };
        Ok(Box::new(Rectangle {
            lower: fixed(lower)?.into(),
            upper: fixed(upper)?.into(),
            cells: fixed(cells)?,
            diagonals: match diagonals {
                scene::Diagonals::Alternate => Diagonals::Alternate,
                scene::Diagonals::Uniform => Diagonals::Uniform,
            },
            grading: fixed(grading)?.into(),
            periodic: [false; 2],
        }))
    }
}

impl Seated<3, 4> for Dim<3> {
    fn cells(mesh: &MeshSource) -> Result<Box<dyn Source<3, 4>>, String> {
        let MeshSource::Box {
            lower,
            upper,
            cells,
        } = mesh
        else {
            return Err("a rectangle is of the plane: in space write a box".to_owned());
        };
        Ok(Box::new(Root {
            lower: fixed(lower)?.into(),
            upper: fixed(upper)?.into(),
            cells: fixed(cells)?,
            periodic: [false; 3],
        }))
    }
}

fn source<const D: usize, const N: usize>(
    mesh: &MeshSource,
) -> Result<Box<dyn Source<D, N>>, String>
where
    Dim<D>: Seated<D, N>,
{
    let MeshSource::File {
        path,
        scale,
        surfaces,
    } = mesh
    else {
        return Dim::<D>::cells(mesh);
    };
    let (scale, surfaces) = (*scale, surfaces.clone());
    Ok(Box::new(MeshFile {
        path: path.into(),
        options: Options { scale, surfaces },
    }))
}

/// The mesh as the coupler needs it.
fn describe<const D: usize, const N: usize>(solver: &FluidSolver<D, N>) -> MeshDescription
where
    Dim<D>: Dimension<D>,
{
    let mesh = solver.mesh();
    tracing::info!(
        nodes = mesh.node_count(),
        simplices = mesh.simplices.len(),
        "mesh"
    );
    let nodes = mesh.simplices.iter().flatten();
    MeshDescription {
        dimension: D,
        node_position: flat::numbers(&mesh.position).to_vec(),
        simplex_nodes: nodes.map(|&node| node as u32).collect(),
        simplex_position: flat::numbers(mesh.corners.as_flattened()).to_vec(),
        nodal_mass: mesh.nodal_mass.clone(),
        period: mesh.period.to_vec(),
        facets: describe_facets(solver),
    }
}

/// Its boundary; sides that are joined have none.
fn describe_facets<const D: usize, const N: usize>(solver: &FluidSolver<D, N>) -> FacetDescription
where
    Dim<D>: Dimension<D>,
{
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
fn kind<const D: usize>(condition: &Condition<D>) -> Option<BoundaryKind> {
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
