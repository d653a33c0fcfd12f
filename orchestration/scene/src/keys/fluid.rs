//! Keys of the fluid: `[fluid]`.

use std::collections::BTreeMap;

use protocol::scene::{
    Boundary, Convection, Diagonals, Indicator, MeanFlow, Nonlinear, Region, TimeScheme,
    ViscousForm,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::numbers::Numbers;
use super::ranges::{
    exactly_one_of, not_empty, not_negative, one_or_more, positive, refined_somewhere,
    scale_of_mesh,
};

/// The fluid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid<const D: usize> {
    /// Density (kg/m³).
    #[schemars(transform = positive)]
    pub density: f64,
    /// Dynamic viscosity (Pa s).
    #[schemars(transform = positive)]
    pub dynamic_viscosity: f64,
    /// Where the fluid is.
    pub domain: Domain,
    /// Condition on each boundary: "all", or left, right, bottom, top of a rectangle, back and front too of a
    /// box, or the names of the mesh. A name goes before "all".
    #[serde(with = "super::boundary::map")]
    #[schemars(with = "BTreeMap<String, super::boundary::BoundaryKey<D>>")]
    #[schemars(transform = not_empty)]
    pub boundaries: BTreeMap<String, Boundary<[f64; D]>>,
    /// Convection v·∇v: true, false (creeping flow), or "auto": left out while it is small.
    #[serde(default = "as_needed")]
    pub convection: Convection,
    /// Time scheme: "backward-euler", "bdf2" or "steady".
    #[serde(default = "backward_euler")]
    pub time_scheme: TimeScheme,
    /// Convection within a step: "picard", or { newton = { tolerance, iterations_max } }.
    #[serde(default = "picard")]
    pub nonlinear: Nonlinear,
    /// Viscous term: "symmetric", or "paper-literal" for reproduction.
    #[serde(default = "symmetric")]
    pub viscous_form: ViscousForm,
    /// Factor of the grad-div stabilisation; left out: 1 with grains, 0.1 without.
    #[schemars(transform = not_negative)]
    pub grad_div: Option<f64>,
    /// Uniform initial superficial velocity (m/s).
    #[serde(default)]
    pub initial_velocity: Numbers<f64, D>,
    /// Mean flux of the mixture through periodic sides: "free" (as the forces have it), "zero" (as in a shut
    /// vessel), or { velocity = […] } (m/s), the latter two steered by a uniform pressure gradient. Required
    /// where all sides are periodic and there is gravity.
    pub mean_flow: Option<MeanFlow<Numbers<f64, D>>>,
    /// Cells of other sizes than those of the rectangle or mesh, which are divided where that is asked for.
    pub refinement: Option<RefinementKeys>,
}

/// Cells that are small near grains, where the flow bends or in regions: h = min(largest, size + growth · distance).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = refined_somewhere)]
pub struct RefinementKeys {
    /// Cells near grains (m); the mesh follows them.
    #[schemars(transform = positive)]
    pub near_grains: Option<f64>,
    /// How far grains may go before the mesh follows (m); left out: twice near_grains. The zone of small cells
    /// reaches two to three margins beyond the grains.
    #[schemars(transform = positive)]
    pub margin: Option<f64>,
    /// By how much cells grow away from there, in metres a metre.
    #[serde(default = "growth")]
    #[schemars(transform = positive)]
    pub growth: f64,
    /// Largest cells (m); left out: those of the rectangle.
    #[schemars(transform = positive)]
    pub largest: Option<f64>,
    /// Cells where the flow bends, e.g. in shear layers and wakes: { jump, smallest (m) }; the mesh follows it.
    pub indicator: Option<Indicator>,
    /// Places where cells are small: { ball = { centre, radius, size } } or { box = { lower, upper, size } } (m).
    #[serde(default)]
    pub regions: Vec<Region>,
}

/// Where the fluid is: a rectangle of the plane, a box of space, or a mesh file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = exactly_one_of(&["rectangle", "box", "mesh"]), transform = scale_of_mesh)]
pub struct Domain {
    /// A rectangle cut into cells; boundaries left, right, bottom, top.
    pub rectangle: Option<Rectangle>,
    /// A box of space cut into cells; boundaries left, right, bottom, top, back, front.
    #[serde(rename = "box")]
    pub cells: Option<BoxOfCells>,
    /// A Gmsh file beside the scene, format 2.2 or 4.1, of triangles; of tetrahedra where gravity has three
    /// numbers. Its boundaries are named by the physical groups of its curves or surfaces, or have the number of
    /// the group, curve or surface.
    pub mesh: Option<String>,
    /// Metres of a unit of the mesh file, e.g. 1e-3 for millimetres; left out: 1.
    #[schemars(transform = positive)]
    pub scale: Option<f64>,
    /// Surfaces (in space: volumes) of the mesh file that are filled with fluid, by name or number; left out: the
    /// only one.
    #[serde(default)]
    pub surfaces: Vec<String>,
}

/// A rectangle cut into cells, each into two triangles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Lower left corner (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "[f64; 2]")]
    pub lower: [f64; 2],
    /// Upper right corner (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "[f64; 2]")]
    pub upper: [f64; 2],
    /// Cells in x and y.
    #[schemars(transform = one_or_more)]
    #[serde(with = "super::numbers")]
    #[schemars(with = "[usize; 2]")]
    pub cells: [usize; 2],
    /// How cells are cut: "alternate" (no preferred direction) or "uniform" (translation invariant).
    #[serde(default = "alternate")]
    pub diagonals: Diagonals,
    /// Ratio of the largest to the smallest cell in x and y; 1: all equal.
    #[serde(with = "super::numbers", default = "ungraded")]
    #[schemars(transform = one_or_more)]
    #[schemars(with = "[f64; 2]")]
    pub grading: [f64; 2],
}

/// A box of space cut into cells, each into six tetrahedra.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxOfCells {
    /// Lower corner (m): left, bottom, back.
    #[serde(with = "super::numbers")]
    #[schemars(with = "[f64; 3]")]
    pub lower: [f64; 3],
    /// Upper corner (m): right, top, front.
    #[serde(with = "super::numbers")]
    #[schemars(with = "[f64; 3]")]
    pub upper: [f64; 3],
    /// Cells in x, y and z.
    #[schemars(transform = one_or_more)]
    #[serde(with = "super::numbers")]
    #[schemars(with = "[usize; 3]")]
    pub cells: [usize; 3],
}

fn growth() -> f64 {
    0.2
}
fn as_needed() -> Convection {
    Convection::AsNeeded
}
fn backward_euler() -> TimeScheme {
    TimeScheme::BackwardEuler
}
fn picard() -> Nonlinear {
    Nonlinear::Picard
}
fn symmetric() -> ViscousForm {
    ViscousForm::Symmetric
}
fn alternate() -> Diagonals {
    Diagonals::Alternate
}
fn ungraded() -> [f64; 2] {
    [1.0, 1.0]
}
