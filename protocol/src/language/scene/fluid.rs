//! What the fluid engine needs to know.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::boundary::Boundary;
use super::convection::Convection;
use super::door::{dimension, fits};
use super::mean_flow::MeanFlow;
use super::refinement::Refinement;

/// What the fluid engine needs to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluidScene {
    /// Dimension of the space: 2 or 3; every vector has as many numbers.
    pub dimension: usize,
    /// ρ \[kg/m³\].
    pub density: f64,
    /// μ \[Pa s\].
    pub dynamic_viscosity: f64,
    /// g \[m/s²\].
    pub gravity: Vec<f64>,
    /// The mesh.
    pub mesh: MeshSource,
    /// Condition on every named boundary.
    pub boundaries: BTreeMap<String, Boundary>,
    /// Is ρφ v·∇v there?
    pub convection: Convection,
    /// Time scheme.
    pub time_scheme: TimeScheme,
    /// How the convection is solved within a step.
    pub nonlinear: Nonlinear,
    /// Form of the viscous term.
    pub viscous_form: ViscousForm,
    /// Factor of the grad-div stabilisation; 1 for suspensions, 0.1 for clear flow around bodies.
    pub grad_div: f64,
    /// Uniform initial superficial velocity \[m/s\].
    pub initial_velocity: Vec<f64>,
    /// Threads the engine may use.
    pub threads: usize,
    /// What the flow through periodic sides does on the whole; steered only by an engine with
    /// `Capability::SteersMeanFlow`.
    #[serde(default)]
    pub mean_flow: MeanFlow,
    /// How large cells are, for an engine with `Capability::Adapts`; none: as the mesh has them.
    #[serde(default)]
    pub refinement: Option<Refinement>,
}

impl FluidScene {
    /// Do all vectors have as many numbers as the space has dimensions? An error names the one that has
    /// not.
    pub fn check(&self) -> Result<(), String> {
        let d = dimension(self.dimension)?;
        fits(d, "gravity", &self.gravity)?;
        fits(d, "initial_velocity", &self.initial_velocity)?;
        self.mean_flow
            .try_map(|v| fits(d, "mean_flow.velocity", v))?;
        if let MeshSource::Rectangle {
            lower,
            upper,
            cells,
            grading,
            ..
        } = &self.mesh
        {
            fits(d, "mesh.rectangle.lower", lower)?;
            fits(d, "mesh.rectangle.upper", upper)?;
            fits(d, "mesh.rectangle.cells", cells)?;
            fits(d, "mesh.rectangle.grading", grading)?;
        }
        if let MeshSource::Box {
            lower,
            upper,
            cells,
        } = &self.mesh
        {
            fits(d, "mesh.box.lower", lower)?;
            fits(d, "mesh.box.upper", upper)?;
            fits(d, "mesh.box.cells", cells)?;
        }
        if let Some(refinement) = &self.refinement {
            let checked = refinement.check(d);
            checked.map_err(|why| format!("refinement: {why}"))?;
        }
        self.boundaries.iter().try_for_each(|(name, boundary)| {
            let what = format!("velocity of the boundary {name}");
            let checked = boundary.try_map(|velocity| fits(d, &what, velocity));
            checked.map(drop)
        })
    }
}

/// Where the mesh comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum MeshSource {
    /// A rectangle cut into cells, each into simplices. Boundaries: left, right, bottom, top.
    Rectangle {
        /// Lower left corner \[m\].
        lower: Vec<f64>,
        /// Upper right corner \[m\].
        upper: Vec<f64>,
        /// Cells along each axis.
        cells: Vec<usize>,
        /// How cells are cut.
        diagonals: Diagonals,
        /// Ratio of the largest to the smallest cell along each axis (both ends refined); 1: uniform.
        grading: Vec<f64>,
    },
    /// A Gmsh file, 2.2 or 4.1 (crate `gmsh`), of triangles or, in space, tetrahedra.
    File {
        /// Path, absolute or relative to the scene.
        path: String,
        /// Metres of a unit of the file.
        #[serde(default = "metres")]
        scale: f64,
        /// Surfaces, in space volumes, that are filled, by name or number; none: the only one.
        #[serde(default)]
        surfaces: Vec<String>,
    },
    /// A box of space cut into cells, each into six tetrahedra. Boundaries: left, right, bottom, top, back, front.
    Box {
        /// Lower corner \[m\].
        lower: Vec<f64>,
        /// Upper corner \[m\].
        upper: Vec<f64>,
        /// Cells along each axis.
        cells: Vec<usize>,
    },
}

fn metres() -> f64 {
    1.0
}

/// Diagonals of the cells of a rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Diagonals {
    /// Alternate from cell to cell: no preferred direction.
    Alternate,
    /// All the same: translation invariant, every node has the same mass.
    Uniform,
}

/// Time scheme of the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TimeScheme {
    /// First order.
    BackwardEuler,
    /// Second order; the first step is backward Euler.
    Bdf2,
    /// No time derivative: one `Advance` is the steady state.
    Steady,
}

/// Nonlinear solve of one `Advance`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Nonlinear {
    /// Convecting velocity extrapolated from accepted steps: one linear solve.
    Picard,
    /// Newton to a relative residual.
    Newton {
        /// Relative residual at which it stops.
        #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
        tolerance: f64,
        /// Iterations allowed.
        #[schemars(range(min = 1))]
        iterations_max: usize,
    },
}

/// Form of the viscous term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ViscousForm {
    /// −∇·(2μφ D(v)): Galilean invariant.
    Symmetric,
    /// −∇·(μφ∇v) − μ v ∇²φ: the paper's three terms as printed.
    PaperLiteral,
}
