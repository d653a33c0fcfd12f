//! The tables of a scene, as they stand in its file. SI units; unknown keys are refused.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::conduct::{Checkpoint, Engines, LimitKeys, Output, Record};
use super::coupling::{Contact, Coupling};
use super::fluid::Fluid;
use super::grains::Grains;
use super::ranges::{parts, positive, without_null};
use super::room::{Particles, WallKeys};

/// A Sillage scene: grains in a fluid, in the plane or in space. SI units throughout.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = parts)]
pub struct SceneFile<const D: usize> {
    /// Duration and step.
    pub run: Run,
    /// Gravity; always written down, also when it is zero.
    pub gravity: Gravity<D>,
    /// The fluid; without it no fluid process is started.
    pub fluid: Option<Fluid<D>>,
    /// Grain populations; without any no particle process is started.
    #[serde(default)]
    pub grains: Vec<Grains<D>>,
    /// Where grains may go.
    #[serde(default)]
    pub particles: Particles<D>,
    /// Further walls.
    #[serde(default)]
    pub walls: Vec<WallKeys<D>>,
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
    /// What is kept of a run, so that it can be resumed.
    #[serde(default)]
    pub checkpoint: Checkpoint,
    /// How long to wait for an engine.
    #[serde(default)]
    pub limits: LimitKeys,
}

/// Duration and step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// When the run ends (s).
    #[schemars(transform = positive)]
    pub end_time: f64,
    /// Coupling step (s): how often fluid and grains exchange.
    #[schemars(transform = positive)]
    pub coupling_step: f64,
    /// A step that fails is halved down to this (s); left out: to coupling_step/64, or to the step_min of
    /// adaptive steps.
    #[schemars(transform = positive)]
    pub step_min: Option<f64>,
    /// May engines leave out what their bounds allow? false: everything is computed in every step,
    /// for comparison.
    #[serde(default = "yes")]
    pub leave_out: bool,
}

/// Gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gravity<const D: usize> {
    /// Acceleration g (m/s²), e.g. [0.0, -9.81], in space [0.0, -9.81, 0.0].
    #[serde(with = "super::numbers")]
    #[schemars(with = "super::numbers::Numeric")]
    pub acceleration: [f64; D],
}

/// The JSON Schema of a scene file.
pub fn scene_schema() -> Value {
    let settings = SchemaSettings::draft2020_12().with_transform(without_null());
    let generator = settings.into_generator();
    generator.into_root_schema_for::<SceneFile<3>>().to_value()
}

fn yes() -> bool {
    true
}
