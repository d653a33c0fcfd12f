//! The fluid seat: the only file that knows the protocol. It translates, nothing more.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use protocol::configure::{self, Convection, FluidScene, MeshSource};
use protocol::engine::{FluidAnswer, FluidEngine, MeshDescription, SolidResponse};
use protocol::messages::{Advance, Capability, Diagnostic, Failure, FailureKind};

use space::flat;

use crate::boundary::condition::{Condition, periodic_directions};
use crate::candidate::Request;
use crate::config::{CREEPING_REYNOLDS, FluidConfig, Nonlinear, TimeScheme};
use crate::equations::coefficients::ViscousForm;
use crate::error::FluidError;
use crate::mesh::gmsh;
use crate::mesh::rectangle::{Diagonals, Rectangle};
use crate::mesh::simplices::Mesh;
use crate::solid::SolidFields;
use crate::state::State;
use crate::step::FluidSolver;

/// The built-in fluid engine, in the plane: the scene's meshes are plane.
#[derive(Default)]
pub struct Engine {
    solver: Option<FluidSolver<2, 3>>,
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
        ]
    }

    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        let config = config(scene);
        let refuse = |error: FluidError| Failure::new(FailureKind::Scene, error.to_string());
        let mesh = mesh(&scene.mesh, &config.boundaries).map_err(refuse)?;
        let description = describe(&mesh);
        tracing::info!(
            nodes = mesh.node_count(),
            triangles = mesh.simplices.len(),
            "mesh"
        );
        self.solver = Some(FluidSolver::new(config, mesh).map_err(refuse)?);
        Ok(description)
    }

    fn advance(
        &mut self,
        request: &Advance,
        solid: &SolidResponse<'_>,
        answer: FluidAnswer<'_>,
    ) -> Result<Vec<Diagnostic>, Failure> {
        let fields = SolidFields {
            porosity: solid.porosity,
            drag: solid.drag,
            drag_source: solid.drag_source,
            entrained_fraction: solid.entrained_fraction,
            solid_flux: solid.solid_flux,
            solid_mobility: solid.solid_mobility,
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
                answer.interstitial_velocity,
                flat::numbers(&candidate.interstitial_velocity),
            ),
            (
                answer.pressure_gradient,
                flat::numbers(&candidate.pressure_gradient),
            ),
            (answer.pressure, &candidate.state.pressure[..]),
        ];
        for (target, source) in copies {
            target.copy_from_slice(source);
        }
        let numbers = candidate.diagnostics.iter();
        Ok(numbers
            .map(|(name, value)| Diagnostic {
                name: name.clone(),
                value: *value,
            })
            .collect())
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
        FluidError::Unbalanced { .. } => FailureKind::Scene,
        _ => FailureKind::Engine,
    };
    Failure::new(kind, error.to_string())
}

fn config(scene: &FluidScene) -> FluidConfig<2> {
    let mut config = FluidConfig::new(scene.density, scene.dynamic_viscosity);
    let named = scene.boundaries.iter();
    config.boundaries = named
        .map(|(name, boundary)| (name.clone(), condition(boundary)))
        .collect();
    config.gravity = scene.gravity.into();
    config.convection = scene.convection != Convection::Never;
    config.creeping_below = (scene.convection == Convection::AsNeeded).then_some(CREEPING_REYNOLDS);
    config.grad_div = scene.grad_div;
    config.threads = scene.threads;
    config.initial_velocity = scene.initial_velocity.into();
    config.time_scheme = match scene.time_scheme {
        configure::TimeScheme::BackwardEuler => TimeScheme::BackwardEuler,
        configure::TimeScheme::Bdf2 => TimeScheme::Bdf2,
        configure::TimeScheme::Steady => TimeScheme::Steady,
    };
    config.nonlinear = match scene.nonlinear {
        configure::Nonlinear::Picard => Nonlinear::Picard,
        configure::Nonlinear::Newton {
            tolerance,
            iterations_max,
        } => Nonlinear::Newton {
            tolerance,
            iterations_max,
        },
    };
    config.viscous_form = match scene.viscous_form {
        configure::ViscousForm::Symmetric => ViscousForm::Symmetric,
        configure::ViscousForm::PaperLiteral => ViscousForm::PaperLiteral,
    };
    config
}

fn condition(boundary: &configure::Boundary) -> Condition<2> {
    match boundary {
        configure::Boundary::NoSlip => Condition::NoSlip,
        configure::Boundary::Slip => Condition::Slip,
        configure::Boundary::Periodic => Condition::Periodic,
        configure::Boundary::Inflow { velocity, profile } => match profile {
            configure::Profile::Uniform => Condition::uniform(*velocity),
            configure::Profile::Parabolic => Condition::Parabolic((*velocity).into()),
        },
        configure::Boundary::Open { pressure } => Condition::Open(*pressure),
    }
}

fn mesh(
    source: &MeshSource,
    boundaries: &BTreeMap<String, Condition<2>>,
) -> Result<Mesh<2, 3>, FluidError> {
    match source {
        MeshSource::File { path } => gmsh::read(Path::new(path)),
        MeshSource::Rectangle {
            lower,
            upper,
            cells,
            diagonals,
            grading,
        } => Rectangle {
            lower: (*lower).into(),
            upper: (*upper).into(),
            cells: *cells,
            diagonals: match diagonals {
                configure::Diagonals::Alternate => Diagonals::Alternate,
                configure::Diagonals::Uniform => Diagonals::Uniform,
            },
            grading: (*grading).into(),
            periodic: periodic_directions(boundaries)?,
        }
        .mesh(),
    }
}

/// The mesh as the coupler needs it.
fn describe(mesh: &Mesh<2, 3>) -> MeshDescription {
    MeshDescription {
        node_position: flat::numbers(&mesh.position).to_vec(),
        triangles: mesh
            .simplices
            .iter()
            .map(|nodes| nodes.map(|node| node as u32))
            .collect(),
        triangle_position: mesh
            .corners
            .iter()
            .map(|corners| std::array::from_fn(|k| corners[k / 2][k % 2]))
            .collect(),
        nodal_mass: mesh.nodal_mass.clone(),
        period: mesh.period,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(boundaries: &[(&str, configure::Boundary)]) -> FluidScene {
        FluidScene {
            density: 1200.0,
            dynamic_viscosity: 0.12,
            gravity: [0.0, -9.81],
            mesh: MeshSource::Rectangle {
                lower: [0.0; 2],
                upper: [0.1, 0.3],
                cells: [1, 6],
                diagonals: configure::Diagonals::Uniform,
                grading: [1.0; 2],
            },
            boundaries: boundaries
                .iter()
                .map(|(name, b)| ((*name).to_owned(), b.clone()))
                .collect(),
            convection: true.into(),
            time_scheme: configure::TimeScheme::Bdf2,
            nonlinear: configure::Nonlinear::Picard,
            viscous_form: configure::ViscousForm::Symmetric,
            grad_div: 1.0,
            initial_velocity: [0.0; 2],
            threads: 1,
        }
    }

    fn step(engine: &mut Engine, nodes: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let (mut v, mut g, mut p) = (vec![0.0; 2 * nodes], vec![0.0; 2 * nodes], vec![0.0; nodes]);
        let answer = FluidAnswer {
            interstitial_velocity: &mut v,
            pressure_gradient: &mut g,
            pressure: &mut p,
        };
        let fields = Vec::new();
        let request = Advance {
            step: 1,
            pass: 0,
            time: 0.0,
            dt: 0.01,
            sub_steps: 0,
            tolerance: 1e-3,
            fields,
        };
        engine
            .advance(&request, &SolidResponse::default(), answer)
            .unwrap();
        engine.commit().unwrap();
        (v, g, p)
    }

    #[test]
    fn a_periodic_column_of_one_cell_rests_and_survives_a_checkpoint() {
        use configure::Boundary::{NoSlip, Periodic};
        let mut engine = Engine::default();
        let sides = [("left", Periodic), ("right", Periodic), ("all", NoSlip)];
        let mesh = engine.configure(&scene(&sides)).unwrap();
        assert_eq!((mesh.nodal_mass.len(), mesh.triangles.len()), (7, 12));
        assert_eq!(mesh.period, [Some(0.1), None]);
        let (v, g, p) = step(&mut engine, 7);
        assert!(v.iter().all(|v| v.abs() < 1e-12));
        assert!(
            g.chunks(2)
                .all(|g| g[0].abs() < 1e-8 && (g[1] + 11772.0).abs() < 1e-7)
        );
        assert!((p[0] - p[6] - 11772.0 * 0.3).abs() < 1e-8);

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        engine.save(&path).unwrap();
        let next = step(&mut engine, 7);
        engine.restore(&path).unwrap();
        assert_eq!(next, step(&mut engine, 7));
    }

    #[test]
    fn a_scene_that_cannot_be_run_is_a_scene_failure() {
        use configure::Boundary::{NoSlip, Open, Periodic};
        let mut one_sided = scene(&[("left", Periodic), ("all", NoSlip)]);
        let unknown = scene(&[("outlet", Open { pressure: 0.0 }), ("all", NoSlip)]);
        let check = |scene: &FluidScene, parts: &[&str]| {
            let failure = Engine::default().configure(scene).unwrap_err();
            println!("{}", failure.why);
            assert_eq!(failure.kind, FailureKind::Scene);
            assert!(parts.iter().all(|part| failure.why.contains(part)));
        };
        check(&one_sided, &["\"left\"", "\"right\"", "periodic"]);
        check(&unknown, &["\"outlet\"", "bottom"]);
        one_sided.mesh = MeshSource::File {
            path: "no/such.msh".into(),
        };
        check(&one_sided, &["no/such.msh"]);
    }
}
