//! The fluid seat: the only file that knows the protocol.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use protocol::engine::{
    Computed, FacetDescription, FluidEngine, Inputs, MeshDescription, Outputs, PlaneOrSpace,
};
use protocol::field::Field;
use protocol::message::{Advance, Capability, Failure, FailureKind};
use protocol::report::FluidReport;
use protocol::scene::{Boundary, Diagonals, FluidScene, MeshSource, fixed};
use space::{Dim, Dimension, Vector, flat};

use crate::formula::Formula;
use crate::lattice::{Lattice, Mesh};

/// All that a checkpoint holds.
const MARK: &str = "prescribed-fluid: formulas have no state\n";
/// Of each axis, the side where it begins.
const FIRST_SIDES: [&str; 3] = ["left", "bottom", "back"];

/// A fluid whose velocity and pressure are given as formulas in x, y, in space z (m) and t (s).
#[derive(Debug, Clone, Parser)]
#[command(version)]
struct Formulas {
    /// Interstitial velocity (m/s): two formulas
    #[arg(long, num_args = 2, value_names = ["VX", "VY"], value_parser = Formula::parse,
          allow_hyphen_values = true)]
    velocity: Vec<Formula>,
    /// Its third component, in space; left out: 0
    #[arg(long, value_name = "VZ", value_parser = Formula::parse, allow_hyphen_values = true)]
    velocity_z: Option<Formula>,
    /// Full pressure (Pa); left out: hydrostatic, ρ g·x
    #[arg(long, value_name = "P", value_parser = Formula::parse, allow_hyphen_values = true)]
    pressure: Option<Formula>,
}

impl Formulas {
    fn all(&self) -> impl Iterator<Item = &Formula> {
        let others = self.velocity_z.iter().chain(&self.pressure);
        self.velocity.iter().chain(others)
    }

    /// A component of the velocity; none: 0.
    fn velocity(&self, axis: usize) -> Option<&Formula> {
        match axis {
            2 => self.velocity_z.as_ref(),
            _ => self.velocity.get(axis),
        }
    }
}

/// In the plane or in space, as the scene says.
type Engine = PlaneOrSpace<Prescribed<2, 3>, Prescribed<3, 4>>;

/// In `D` dimensions, `N` corners a simplex.
struct Prescribed<const D: usize, const N: usize> {
    formulas: Formulas,
    /// The mesh of the scene.
    mesh: Mesh<D, N>,
    /// ρ g \[N/m³\]
    weight: Vector<D>,
}

/// `main` of the engine's process.
pub fn run() -> ExitCode {
    let formulas = Formulas::parse();
    let engine = Engine::new(Prescribed::new(formulas.clone()), Prescribed::new(formulas));
    protocol::engine::run_fluid(engine)
}

impl<const D: usize, const N: usize> Prescribed<D, N> {
    fn new(formulas: Formulas) -> Self {
        Prescribed {
            formulas,
            mesh: Mesh::default(),
            weight: Vector::zeros(),
        }
    }

    /// A formula that only space has.
    fn refuse_depth(&self) -> Result<(), String> {
        if D == 3 {
            return Ok(());
        }
        if let Some(formula) = &self.formulas.velocity_z {
            return Err(format!(
                "--velocity-z is `{formula}`, the scene has no third dimension"
            ));
        }
        match self.formulas.all().find(|formula| formula.has_depth()) {
            Some(formula) => Err(format!("`{formula}` depends on z, the scene has none")),
            None => Ok(()),
        }
    }
}

/// The rectangle or box of a scene.
fn lattice<const D: usize>(scene: &FluidScene) -> Result<Lattice<D>, String> {
    let (lower, upper, cells, alternate) = match &scene.mesh {
        MeshSource::Rectangle {
            lower,
            upper,
            cells,
            diagonals,
            grading,
        } => {
            if grading.iter().any(|&grading| grading != 1.0) {
                let why = format!("prescribed-fluid has uniform cells, grading is {grading:?}");
                return Err(why);
            }
            (lower, upper, cells, *diagonals == Diagonals::Alternate)
        }
        MeshSource::Box {
            lower,
            upper,
            cells,
        } => (lower, upper, cells, false),
        MeshSource::File { .. } => {
            let why = "prescribed-fluid takes [fluid.domain] rectangle or box, not a mesh file";
            return Err(why.to_owned());
        }
    };
    let is_periodic = |side: &str| scene.boundaries.get(side) == Some(&Boundary::Periodic);
    Ok(Lattice {
        lower: Vector::from(fixed::<D, f64>(lower)?),
        upper: Vector::from(fixed::<D, f64>(upper)?),
        cells: fixed(cells)?,
        alternate,
        periodic: std::array::from_fn(|axis| is_periodic(FIRST_SIDES[axis])),
    })
}

impl<const D: usize, const N: usize> FluidEngine for Prescribed<D, N>
where
    Dim<D>: Dimension<D>,
{
    fn identity(&self) -> (&'static str, &'static str) {
        ("prescribed-fluid", env!("CARGO_PKG_VERSION"))
    }

    fn capabilities(&self) -> Vec<Capability> {
        vec![Capability::Checkpoint]
    }

    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        self.refuse_depth().map_err(unusable_scene)?;
        let lattice = lattice::<D>(scene).map_err(unusable_scene)?;
        let gravity: [f64; D] = fixed(&scene.gravity).map_err(unusable_scene)?;
        self.weight = Vector::from(gravity) * scene.density;
        self.mesh = lattice.mesh();
        let corners = self.mesh.corners.as_flattened();
        let length = |axis: usize| lattice.upper[axis] - lattice.lower[axis];
        let period = (0..D).map(|axis| lattice.periodic[axis].then(|| length(axis)));
        Ok(MeshDescription {
            dimension: D,
            node_position: flat::numbers(&self.mesh.position).to_vec(),
            simplex_nodes: self.mesh.simplices.as_flattened().to_vec(),
            simplex_position: flat::numbers(corners).to_vec(),
            nodal_mass: self.mesh.mass.clone(),
            period: period.collect(),
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
        for (node, point) in self.mesh.position.iter().enumerate() {
            for axis in 0..D {
                let formula = self.formulas.velocity(axis);
                let value = formula.map_or(Ok(0.0), |v| v.at(point.as_slice(), end));
                velocity[D * node + axis] = value.map_err(infinite)?;
            }
            let hydrostatic = || Ok(self.weight.dot(point));
            let formula = self.formulas.pressure.as_ref();
            let value = formula.map_or_else(hydrostatic, |p| p.at(point.as_slice(), end));
            pressure[node] = value.map_err(infinite)?;
        }
        let gradient = self.mesh.averaged_gradient(pressure);
        outputs
            .take(Field::PressureGradient)
            .copy_from_slice(flat::numbers(&gradient));
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
