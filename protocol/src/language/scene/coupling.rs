//! The resolved scene as the coupler gets it: both engines' parts, how they are coupled, what is put out.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::language::field::Field;
use crate::language::role::Role;

use super::boundary::GrainBoundary;
use super::door::{dimension, fits};
use super::fluid::FluidScene;
use super::particles::ParticleScene;
use super::refinement::{Indicator, NearGrains};

/// A grain is a point of the mesh up to this ratio of its diameter to the cells around it; a larger one is
/// spread.
pub const LUMPED_RATIO_MAX: f64 = 0.25;

/// What the coupler needs to know: the resolved scene, written to the run folder as JSON.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CouplerScene {
    /// Dimension of the space: 2 or 3; every vector has as many numbers.
    pub dimension: usize,
    /// When the run ends \[s\].
    pub end_time: f64,
    /// Coupling step \[s\].
    pub coupling_step: f64,
    /// A step that fails is halved down to this \[s\]; none: to 1/64 of the coupling step, or to the smallest
    /// adaptive one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_min: Option<f64>,
    /// Adaptive step, when asked for.
    pub adaptive: Option<AdaptiveStep>,
    /// g \[m/s²\].
    pub gravity: Vec<f64>,
    /// The fluid engine's part; none: no fluid process.
    pub fluid: Option<FluidScene>,
    /// The particle engine's part; none: no particle process.
    pub particles: Option<ParticleScene>,
    /// No grain moves and there is no particle process: the coupler answers for them.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub grains_stay: bool,
    /// What grains meet at the boundaries of the fluid's mesh, by name: its facets are walls beside those
    /// of `particles`. None: those are all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grain_boundaries: Option<BTreeMap<String, GrainBoundary>>,
    /// Boundaries of the fluid by which grains leave and are taken out, by name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grain_exits: Vec<String>,
    /// Cells near grains, beside those of the fluid's refinement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near_grains: Option<NearGrains>,
    /// Cells where the flow bends, beside them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub indicator: Option<Indicator>,
    /// CSV with the initial grains: x,y,radius,density,vx,vy,fixed, in space with z and vz; relative to the run folder.
    pub grains_file: Option<String>,
    /// Coupling scheme.
    pub scheme: Scheme,
    /// Drag law.
    pub drag: DragLaw,
    /// What a grain is.
    pub geometry: Geometry,
    /// Does the fluid feel the grains?
    pub reaction: bool,
    /// Time between snapshots \[s\]; none: only the last state.
    pub output_every: Option<f64>,
    /// Limits on waiting for an engine.
    pub limits: Limits,
}

/// Has a run until `end_time` reached its end at this time \[s\]? Sums of steps miss it by round-off.
pub fn is_over(time: f64, end_time: f64) -> bool {
    time >= end_time * (1.0 - 1e-12)
}

impl CouplerScene {
    /// Is the dimension the same throughout, and has every vector as many numbers? An error names what
    /// has not.
    pub fn check(&self) -> Result<(), String> {
        fits(dimension(self.dimension)?, "gravity", &self.gravity)?;
        let fluid = self.fluid.as_ref();
        let particles = self.particles.as_ref();
        fluid.map_or(Ok(()), FluidScene::check)?;
        particles.map_or(Ok(()), ParticleScene::check)?;
        let parts = [
            ("fluid", fluid.map(|part| part.dimension)),
            ("particles", particles.map(|part| part.dimension)),
        ];
        for (part, dimension) in parts {
            if let Some(other) = dimension.filter(|&other| other != self.dimension) {
                return Err(format!(
                    "the part of the {part} has {other} dimensions, the scene {}",
                    self.dimension
                ));
            }
        }
        Ok(())
    }

    /// Is there a process in this seat?
    pub fn has_process(&self, role: Role) -> bool {
        match role {
            Role::Fluid => self.fluid.is_some(),
            Role::Particles => self.particles.is_some() && !self.grains_stay,
        }
    }

    /// Fields of this engine's candidates that are not read in every pass: pressure, spins and, where the
    /// fluid does not feel the grains, contact states with a state that is put out; the pressure gradient,
    /// which only grains feel, never.
    pub fn unread(&self, role: Role) -> &'static [Field] {
        let felt = self.fluid.is_some() && self.reaction;
        match role {
            _ if !self.has_process(role) => &[],
            Role::Fluid if self.particles.is_some() => &[Field::Pressure],
            Role::Fluid => &[Field::Pressure, Field::PressureGradient],
            Role::Particles if felt => &[Field::GrainSpin],
            Role::Particles => &[Field::GrainContact, Field::GrainSpin],
        }
    }
}

/// Limits on waiting, all \[s\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Until an engine says hello.
    pub connect: f64,
    /// Until an engine is ready after `Configure`.
    pub configure: f64,
    /// Until an engine answers an `Advance`.
    pub step: f64,
}

/// Bounds of an adaptive coupling step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdaptiveStep {
    /// Smallest step (s); below it the run ends.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step_min: f64,
    /// Largest step (s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step_max: f64,
    /// Cells a grain may cross in a step.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub courant: f64,
}

/// Coupling scheme.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Scheme {
    /// Exactly one pass (the paper).
    Staggered,
    /// Passes until the interaction defect is below `tolerance`.
    Iterated {
        /// Force defect over the net force scale of the grains.
        #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
        tolerance: f64,
        /// Passes allowed; more is an error.
        #[schemars(range(min = 1))]
        passes_max: u32,
    },
    /// For comparison: the drag is implicit on either side, each with the other's velocity of the
    /// start of the step, and the solid's flux is that of the start. Unstable where dense and stiff.
    SemiImplicit,
    /// For comparison: the drag is evaluated with both velocities of the start of the step. Unstable
    /// once the step is longer than the relaxation times.
    Explicit,
}

/// Drag law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DragLaw {
    /// Dallavalle with φ^−1.8 (paper, eq. 5).
    Dallavalle,
    /// Di Felice 1994.
    DiFelice,
    /// Wen and Yu 1966.
    WenYu,
    /// Gidaspow 1994.
    Gidaspow,
    /// Beetstra 2007 with the polydisperse correction.
    Beetstra,
    /// Stokes, no hindrance.
    Stokes,
    /// The hindrance of MigFlow 1.4, for comparison runs.
    Migflow,
}

/// What a grain is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Geometry {
    /// A disk, per metre of depth: A = 2r, V = πr².
    Disk,
    /// A sphere in a slab of this depth: A = πr², V = 4/3 πr³. Of space, which is no slab, with depth 1.
    Sphere {
        /// Depth of the slab (m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        depth: f64,
    },
}
