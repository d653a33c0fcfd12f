//! What the fluid engine needs to know.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::boundary::Boundary;
use super::convection::Convection;

/// What the fluid engine needs to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluidScene {
    /// ρ \[kg/m³\].
    pub density: f64,
    /// μ \[Pa s\].
    pub dynamic_viscosity: f64,
    /// g \[m/s²\].
    pub gravity: [f64; 2],
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
    pub initial_velocity: [f64; 2],
    /// Threads the engine may use.
    pub threads: usize,
}

/// Where the mesh comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum MeshSource {
    /// A rectangle cut into cells, each into two triangles. Boundaries: left, right, bottom, top.
    Rectangle {
        /// Lower left corner \[m\].
        lower: [f64; 2],
        /// Upper right corner \[m\].
        upper: [f64; 2],
        /// Cells in x and y.
        cells: [usize; 2],
        /// How cells are cut.
        diagonals: Diagonals,
        /// Ratio of the largest to the smallest cell in x and y (both ends refined); 1: uniform.
        grading: [f64; 2],
    },
    /// A Gmsh 4.1 file with named physical curves.
    File {
        /// Path, absolute or relative to the scene.
        path: String,
    },
}

/// Diagonals of the cells of a rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Diagonals {
    /// Alternate from cell to cell: no preferred direction.
    Alternate,
    /// All the same: translation invariant, every node has the same mass.
    Uniform,
}

/// Time scheme of the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Nonlinear {
    /// Convecting velocity extrapolated from accepted steps: one linear solve.
    Picard,
    /// Newton to a relative residual.
    Newton {
        /// Relative residual at which it stops.
        tolerance: f64,
        /// Iterations allowed.
        iterations_max: usize,
    },
}

/// Form of the viscous term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViscousForm {
    /// −∇·(2μφ D(v)): Galilean invariant.
    Symmetric,
    /// −∇·(μφ∇v) − μ v ∇²φ: the paper's three terms as printed.
    PaperLiteral,
}
