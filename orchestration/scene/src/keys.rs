//! Every key of a scene, as it stands in the file. SI units; unknown keys are refused.

use std::collections::BTreeMap;

use protocol::configure::{
    AdaptiveStep, Convection, Diagonals, DragLaw, Geometry, Nonlinear, Profile, Scheme, TimeScheme,
    ViscousForm,
};
use recording::Compression;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::schema;
use crate::population_keys::Grains;

/// A Sillage scene: grains in a fluid in two dimensions. SI units throughout.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Duration and step.
    pub run: Run,
    /// Gravity; always written down, also when it is zero.
    pub gravity: Gravity,
    /// The fluid; without it no fluid process is started.
    pub fluid: Option<Fluid>,
    /// Grain populations; without any no particle process is started.
    #[serde(default)]
    pub grains: Vec<Grains>,
    /// Where grains may go.
    #[serde(default)]
    pub particles: Particles,
    /// Further wall segments.
    #[serde(default)]
    pub walls: Vec<WallSegment>,
    /// Contacts between grains; required when there are grains.
    pub contact: Option<Contact>,
    /// How grains and fluid are coupled; required when there are both.
    pub coupling: Option<Coupling>,
    /// Other engines than the built-in ones.
    #[serde(default)]
    pub engines: Engines,
    /// What is written.
    #[serde(default)]
    pub output: Output,
    /// Recording of all that processes exchange.
    pub record: Option<Record>,
    /// How long to wait for an engine.
    #[serde(default)]
    pub limits: LimitKeys,
}

/// Duration and step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// When the run ends (s).
    pub end_time: f64,
    /// Coupling step (s): how often fluid and grains exchange.
    pub coupling_step: f64,
    /// May engines leave out what their bounds allow? false: everything is computed in every step,
    /// for comparison.
    #[serde(default = "yes")]
    pub leave_out: bool,
}

/// Gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Acceleration g (m/s²), e.g. [0.0, -9.81].
    pub acceleration: [f64; 2],
}

/// The fluid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Density (kg/m³).
    pub density: f64,
    /// Dynamic viscosity (Pa s).
    pub dynamic_viscosity: f64,
    /// Where the fluid is.
    pub domain: Domain,
    /// Condition on each boundary: "all", or left, right, bottom, top of a rectangle, or the
    /// names of the mesh. A name goes before "all".
    pub boundaries: BTreeMap<String, BoundaryKey>,
    /// Convection v·∇v: true, false (creeping flow), or "auto": left out while it is small.
    #[serde(default = "as_needed")]
    #[schemars(schema_with = "schema::convection")]
    pub convection: Convection,
    /// Time scheme: "backward-euler", "bdf2" or "steady".
    #[serde(default = "backward_euler")]
    #[schemars(schema_with = "schema::time_scheme")]
    pub time_scheme: TimeScheme,
    /// Convection within a step: "picard", or { newton = { tolerance, iterations_max } }.
    #[serde(default = "picard")]
    #[schemars(schema_with = "schema::nonlinear")]
    pub nonlinear: Nonlinear,
    /// Viscous term: "symmetric", or "paper-literal" for reproduction.
    #[serde(default = "symmetric")]
    #[schemars(schema_with = "schema::viscous_form")]
    pub viscous_form: ViscousForm,
    /// Factor of the grad-div stabilisation; left out: 1 with grains, 0.1 without.
    pub grad_div: Option<f64>,
    /// Uniform initial superficial velocity (m/s).
    #[serde(default)]
    pub initial_velocity: [f64; 2],
}

/// Where the fluid is: a rectangle, or a mesh file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// A rectangle cut into cells; boundaries left, right, bottom, top.
    pub rectangle: Option<Rectangle>,
    /// A Gmsh 4.1 file beside the scene, with named physical curves.
    pub mesh: Option<String>,
}

/// A rectangle cut into cells, each into two triangles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Lower left corner (m).
    pub lower: [f64; 2],
    /// Upper right corner (m).
    pub upper: [f64; 2],
    /// Cells in x and y.
    pub cells: [usize; 2],
    /// How cells are cut: "alternate" (no preferred direction) or "uniform" (translation invariant).
    #[serde(default = "alternate")]
    #[schemars(schema_with = "schema::diagonals")]
    pub diagonals: Diagonals,
    /// Ratio of the largest to the smallest cell in x and y; 1: all equal.
    #[serde(default = "ungraded")]
    pub grading: [f64; 2],
}

/// A boundary condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum BoundaryKey {
    /// u = 0.
    NoSlip,
    /// u·n = 0, no tangential traction.
    Slip,
    /// Joined with the opposite side of the rectangle.
    Periodic,
    /// Velocity given; also a moving wall.
    Inflow {
        /// Superficial velocity (m/s); the largest one when parabolic.
        velocity: [f64; 2],
        /// Shape across the boundary: "uniform" or "parabolic".
        #[serde(default = "uniform")]
        #[schemars(schema_with = "schema::profile")]
        profile: Profile,
    },
    /// Pressure given at the highest point, hydrostatic below it.
    Open {
        /// Pressure (Pa).
        pressure: f64,
    },
}

/// Where grains may go.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Particles {
    /// "domain": the sides of the domain that are neither periodic nor open; "none".
    #[serde(default)]
    pub walls: DefaultWalls,
    /// The rectangle of a scene without fluid, or one that differs from the fluid's.
    pub domain: Option<GrainDomain>,
}

/// Walls made from the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "kebab-case")]
pub enum DefaultWalls {
    /// A wall on every side that is neither periodic nor open.
    #[default]
    Domain,
    /// Only the segments written as `walls`.
    None,
}

/// Rectangle of the grains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainDomain {
    /// Lower left corner (m).
    pub lower: [f64; 2],
    /// Upper right corner (m).
    pub upper: [f64; 2],
    /// Sides without a wall: any of "left", "right", "bottom", "top".
    #[serde(default)]
    pub open: Vec<Side>,
    /// Periodic in x and y.
    #[serde(default)]
    pub periodic: [bool; 2],
}

/// A side of a rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Smallest x.
    Left,
    /// Largest x.
    Right,
    /// Smallest y.
    Bottom,
    /// Largest y.
    Top,
}

/// A wall segment; grains stay on the left of from → to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallSegment {
    /// Start (m).
    pub from: [f64; 2],
    /// End (m).
    pub to: [f64; 2],
}

/// Contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Coulomb coefficient between grains.
    #[serde(default)]
    pub friction: f64,
    /// Coulomb coefficient between grains and walls; left out: as between grains.
    pub wall_friction: Option<f64>,
    /// Residual at which a contact solve stops, of |g| Δt.
    pub tolerance: f64,
    /// Sweeps allowed in a contact solve; more is an error.
    #[serde(default = "sweeps_max")]
    pub sweeps_max: usize,
    /// Sub-steps allowed in a coupling step; more is an error.
    #[serde(default = "sub_steps_max")]
    pub sub_steps_max: u32,
}

/// Coupling of grains and fluid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// { iterated = { tolerance, passes_max } }; or "staggered": one pass. For comparison only, as
    /// they lose stability where stiff: "semi-implicit" and "explicit".
    #[schemars(schema_with = "schema::scheme")]
    pub scheme: Option<Scheme>,
    /// Drag law: dallavalle, di-felice, wen-yu, gidaspow, beetstra, stokes or migflow.
    #[serde(default = "dallavalle")]
    #[schemars(schema_with = "schema::drag")]
    pub drag: DragLaw,
    /// Does the fluid feel the grains? false: one-way.
    #[serde(default = "yes")]
    pub reaction: bool,
    /// What a grain is: "disk", or { sphere = { depth } } in a slab.
    #[serde(default = "disk")]
    #[schemars(schema_with = "schema::geometry")]
    pub geometry: Geometry,
    /// Smoothing length of deposited fields (m); 0: none; left out: chosen from grain and cell size.
    pub smoothing_length: Option<f64>,
    /// Adaptive coupling step: { step_min, step_max, courant }.
    #[schemars(schema_with = "schema::adaptive")]
    pub adaptive: Option<AdaptiveStep>,
}

/// Engines to use instead of the built-in ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Engines {
    /// Takes the fluid seat.
    pub fluid: Option<EngineCommand>,
    /// Takes the particle seat.
    pub particles: Option<EngineCommand>,
}

/// How to start an engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EngineCommand {
    /// Program and arguments; started in the folder of the scene.
    pub command: Vec<String>,
}

/// What is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Time between states written (s); left out: only the first and the last.
    pub every: Option<f64>,
    /// Draw a picture of every state written.
    #[serde(default = "yes")]
    pub frames: bool,
    /// Names of the fields in the ParaView files; left out: all that exist.
    pub fields: Option<Vec<String>>,
}

/// Recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Record {
    /// File, relative to the run folder; its name ends in ".mcap".
    pub file: String,
    /// "zstd" (smaller) or "none".
    #[schemars(schema_with = "schema::compression")]
    pub compression: Compression,
}

impl Default for Record {
    fn default() -> Self {
        Record {
            file: "exchange.mcap".to_string(),
            compression: Compression::Zstd,
        }
    }
}

/// How long to wait for an engine, all (s).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LimitKeys {
    /// Until an engine says hello.
    pub connect: f64,
    /// Until an engine is ready after its scene.
    pub configure: f64,
    /// Until an engine answers one step.
    pub step: f64,
}

impl Default for LimitKeys {
    fn default() -> Self {
        LimitKeys {
            connect: 30.0,
            configure: 120.0,
            step: 600.0,
        }
    }
}

impl Default for Output {
    fn default() -> Self {
        Output {
            every: None,
            frames: true,
            fields: None,
        }
    }
}

fn yes() -> bool {
    true
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
fn uniform() -> Profile {
    Profile::Uniform
}
fn dallavalle() -> DragLaw {
    DragLaw::Dallavalle
}
fn disk() -> Geometry {
    Geometry::Disk
}
// Resource limits, not accuracies: crossing one is an error, so a generous number is safe.
fn sweeps_max() -> usize {
    100_000
}
fn sub_steps_max() -> u32 {
    1000
}
