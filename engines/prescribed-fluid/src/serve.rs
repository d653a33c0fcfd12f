//! The fluid seat: the only file that knows the protocol.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use protocol::engine::{Computed, FacetDescription, FluidEngine, Inputs, MeshDescription, Outputs};
use protocol::field::Field;
use protocol::message::{Advance, Capability, Failure, FailureKind};
use protocol::report::FluidReport;
use protocol::scene::{Boundary, Diagonals, FluidScene, MeshSource, fixed};

use crate::formula::Formula;
use crate::rectangle::{Mesh, Rectangle};

/// All that a checkpoint holds.
const MARK: &str = "prescribed-fluid: formulas have no state\n";

/// A fluid whose velocity and pressure are given as formulas in x, y (m) and t (s).
#[derive(Debug, Parser)]
#[command(version)]
struct Engine {
    /// Interstitial velocity (m/s): two formulas
    #[arg(long, num_args = 2, value_names = ["VX", "VY"], value_parser = Formula::parse,
          allow_hyphen_values = true)]
    velocity: Vec<Formula>,
    /// Full pressure (Pa); left out: hydrostatic, ρ g·x
    #[arg(long, value_name = "P", value_parser = Formula::parse, allow_hyphen_values = true)]
    pressure: Option<Formula>,
    /// The mesh of the scene.
    #[arg(skip)]
    mesh: Mesh,
    /// ρ g \[N/m³\]
    #[arg(skip)]
    weight: [f64; 2],
}

/// `main` of the engine's process.
pub fn run() -> ExitCode {
    protocol::engine::run_fluid(Engine::parse())
}

impl FluidEngine for Engine {
    fn identity(&self) -> (&'static str, &'static str) {
        ("prescribed-fluid", env!("CARGO_PKG_VERSION"))
    }

    fn capabilities(&self) -> Vec<Capability> {
        vec![Capability::Checkpoint]
    }

    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        let refuse = |why: String| Err(Failure::new(FailureKind::Scene, why));
        let MeshSource::Rectangle {
            lower,
            upper,
            cells,
            diagonals,
            grading,
        } = &scene.mesh
        else {
            return refuse(
                "prescribed-fluid takes [fluid.domain] rectangle, not a box or a mesh file".into(),
            );
        };
        let plane = |vector: &[f64]| fixed(vector).map_err(unusable_scene);
        let (lower, upper) = (plane(lower)?, plane(upper)?);
        if plane(grading)? != [1.0, 1.0] {
            return refuse(format!(
                "prescribed-fluid has uniform cells, grading is {grading:?}"
            ));
        }
        let is_periodic = |side: &str| scene.boundaries.get(side) == Some(&Boundary::Periodic);
        let periodic = [is_periodic("left"), is_periodic("bottom")];
        let uniform = *diagonals == Diagonals::Uniform;
        self.mesh = Rectangle {
            lower,
            upper,
            cells: fixed(cells).map_err(unusable_scene)?,
            uniform,
            periodic,
        }
        .mesh();
        self.weight = plane(&scene.gravity)?.map(|g| scene.density * g);
        let length = |axis: usize| periodic[axis].then(|| upper[axis] - lower[axis]);
        Ok(MeshDescription {
            dimension: 2,
            node_position: self.mesh.position.clone(),
            simplex_nodes: self.mesh.triangles.as_flattened().to_vec(),
            simplex_position: self.mesh.corners.as_flattened().to_vec(),
            nodal_mass: self.mesh.mass.clone(),
            period: vec![length(0), length(1)],
            facets: FacetDescription::default(),
        })
    }

    fn advance(
        &mut self,
        request: &Advance,
        _inputs: &Inputs<'_>,
        mut outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure> {
        let velocity = outputs.take(Field::InterstitialVelocity);
        let pressure = outputs.take(Field::Pressure);
        let end = request.time + request.dt;
        let infinite = |why| Failure::new(FailureKind::NotFinite, why);
        for (node, [x, y]) in self.mesh.position.as_chunks::<2>().0.iter().enumerate() {
            for axis in 0..2 {
                let value = self
                    .velocity
                    .get(axis)
                    .map_or(Ok(0.0), |v| v.at(*x, *y, end));
                velocity[2 * node + axis] = value.map_err(infinite)?;
            }
            let hydrostatic = self.weight[0] * x + self.weight[1] * y;
            let value = self
                .pressure
                .as_ref()
                .map_or(Ok(hydrostatic), |p| p.at(*x, *y, end));
            pressure[node] = value.map_err(infinite)?;
        }
        self.mesh
            .averaged_gradient(pressure, outputs.take(Field::PressureGradient));
        Ok(FluidReport::default().into())
    }

    fn commit(&mut self) -> Result<(), Failure> {
        Ok(())
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        std::fs::write(path, MARK).map_err(|error| unusable(path, error))
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        match std::fs::read(path) {
            Ok(bytes) if bytes == MARK.as_bytes() => Ok(()),
            Ok(_) => Err(unusable(path, "not a checkpoint of prescribed-fluid")),
            Err(error) => Err(unusable(path, error)),
        }
    }
}

fn unusable_scene(why: String) -> Failure {
    Failure::new(FailureKind::Scene, why)
}

fn unusable(path: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::new(FailureKind::Engine, format!("{}: {why}", path.display()))
}
