//! Control messages. Order and meaning: `README.md` of this package.

use serde::{Deserialize, Serialize};

use super::field::{FROM_FLUID, FROM_PARTICLES, Field};
use super::report::Report;
use super::scene::{FluidScene, ParticleScene, Refinement};

pub use super::role::Role;

/// What an engine can do beyond the minimum; the coupler adapts to what is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Capability {
    /// Fluid: takes the affine solid response (entrained fraction, solid mobility), not only β, s and j⁰.
    AffineResponse,
    /// Particles: `GrainDrag` enters the free velocity and the contact operator implicitly.
    ImplicitDrag,
    /// Particles: reports `GrainContact` with value 2 for grains held by a wall.
    ContactState,
    /// Both: `Save` and `Restore` bring back the same bits.
    Checkpoint,
    /// Fluid: leaves convection out while it is small (`Convection::AsNeeded`); others get `Always`.
    ConvectionAsNeeded,
    /// Both: knows `Withhold` and `Tell`; the loop of this crate declares it for every engine.
    FieldsOnRequest,
    /// Particles: walls that move along themselves rub on the grains; others get no such wall.
    MovingWalls,
    /// Fluid: steers the mean flow through periodic sides (`FluidScene::mean_flow`); others are not asked to.
    SteersMeanFlow,
    /// Particles: every candidate has `GrainSpin`.
    Spin,
    /// Particles: knows `Remove`; others are refused a scene that grains may leave.
    RemovesGrains,
    /// Fluid: takes `FluidScene::refinement` and knows `Adapt`; others are refused a scene with it.
    Adapts,
}

/// First message of an engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// The seat it takes.
    pub role: Role,
    /// Name of the engine, e.g. "sillage-fluid".
    pub engine: String,
    /// Its version.
    pub version: String,
    /// `PROTOCOL_VERSION` it was built with.
    pub protocol: u32,
    /// Process id, watched by its partners.
    pub process: u32,
    /// What it can do.
    pub capabilities: Vec<Capability>,
    /// The run's token, where the link has one; blank once it was looked at, and in recordings.
    #[serde(default)]
    pub token: Option<String>,
}

impl Hello {
    /// Fields of its candidates: those of its seat, and those that it declares.
    pub fn answer(&self) -> Vec<Field> {
        let spins = self.capabilities.contains(&Capability::Spin);
        match self.role {
            Role::Fluid => FROM_FLUID.to_vec(),
            Role::Particles => {
                let spin = spins.then_some(Field::GrainSpin);
                FROM_PARTICLES.into_iter().chain(spin).collect()
            }
        }
    }
}

/// The scene's part of one engine. Particles receive their initial grains as fields with it:
/// `GrainPosition`, `GrainVelocity`, `GrainRadius`, `GrainMass`, `GrainVolume`, `GrainFixed`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Configure {
    /// For the fluid engine.
    Fluid(Box<FluidScene>),
    /// For the particle engine; `grain_count` grains follow as fields.
    Particles {
        /// The scene's part.
        scene: Box<ParticleScene>,
        /// How many grains follow.
        grain_count: u64,
    },
}

/// An engine is ready; counts of the fields that follow.
/// Mesh: `NodePosition`, `SimplexNodes`, `SimplexPosition`, `NodalMass`; where there are facets also
/// `FacetPosition`, `FacetBoundary`, `FacetVelocity`.
/// Grains: `GrainPosition`, `GrainVelocity`, `GrainRadius`, `GrainMass`, `GrainVolume`, `GrainFixed`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Ready {
    /// The fluid engine's mesh.
    Mesh {
        /// Mesh epoch: grows by one whenever the mesh changes.
        epoch: u64,
        /// Dimension of the space, that of the scene.
        dimension: u32,
        /// Number of nodes.
        nodes: u64,
        /// Number of simplices.
        simplices: u64,
        /// Period along each axis \[m\], where the mesh is periodic.
        period: Vec<Option<f64>>,
        /// Number of facets of the boundary; 0: the engine does not tell them.
        #[serde(default)]
        facets: u64,
        /// The boundaries that facets belong to.
        #[serde(default)]
        boundaries: Vec<MeshBoundary>,
    },
    /// The particle engine's grains.
    Grains {
        /// Grain epoch: grows by one whenever grains appear or vanish.
        epoch: u64,
        /// Dimension of the space, that of the scene.
        dimension: u32,
        /// Number of grains.
        grains: u64,
    },
}

/// A named boundary of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshBoundary {
    /// Its name in the scene.
    pub name: String,
    /// What it is to the fluid.
    pub kind: BoundaryKind,
}

/// What a boundary is to the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoundaryKind {
    /// A wall that holds the fluid.
    NoSlip,
    /// A wall along which it slides.
    Slip,
    /// A wall that moves along itself, with `FacetVelocity`.
    MovingWall,
    /// The velocity is given, `FacetVelocity`: along the facet it is that of a moving wall.
    Inflow,
    /// The pressure is given.
    Open,
}

/// Compute a candidate for the step that starts at the accepted state; never changes that state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advance {
    /// Step number, from 1.
    pub step: u64,
    /// Pass within the step, from 0; a new pass throws the previous candidate away.
    pub pass: u32,
    /// Time at the start of the step \[s\].
    pub time: f64,
    /// Length of the step \[s\].
    pub dt: f64,
    /// Particles: number of sub-steps to use; 0 lets the engine choose.
    pub sub_steps: u32,
    /// Relative accuracy asked of an inexact solve (contact): of |g|Δt.
    pub tolerance: f64,
    /// The fields that follow; one that is absent has the default of its catalogue entry.
    pub fields: Vec<Field>,
}

/// A number that an engine reports with a candidate, e.g. ("kinetic_energy", 1.2e-6).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnostic {
    /// Name from the list in `README.md`, or the engine's own.
    pub name: String,
    /// Value in SI units.
    #[serde(deserialize_with = "number_or_null")]
    pub value: f64,
}

/// JSON, in which recordings hold messages, has no word for what is not finite and says null.
fn number_or_null<'de, D: serde::Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    if source.is_human_readable() {
        return Ok(Option::deserialize(source)?.unwrap_or(f64::NAN));
    }
    f64::deserialize(source)
}

/// A candidate is ready; its fields follow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// The step it belongs to.
    pub step: u64,
    /// The pass it belongs to.
    pub pass: u32,
    /// The fields that follow.
    pub fields: Vec<Field>,
    /// What the coupler goes by.
    pub report: Report,
    /// Numbers of this candidate for people: without them a run has the same bits.
    pub diagnostics: Vec<Diagnostic>,
}

/// Why an engine could not do what was asked; the run's exit code follows from `kind`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// The class of the failure.
    pub kind: FailureKind,
    /// What happened, with the number, the bound and the place.
    pub why: String,
}

/// Classes of failures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FailureKind {
    /// The scene's part is not usable (exit 2).
    Scene,
    /// The engine cannot do this, or broke (exit 4).
    Engine,
    /// A value is not finite or an invariant is broken (exit 7).
    NotFinite,
    /// An iteration did not converge (exit 8).
    NotConverged,
}

/// Grains in one `Remove`, so that it is a message of ordinary size.
pub const REMOVED_MAX: usize = 4096;

/// Coupler → engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ToEngine {
    /// The engine's part of the scene.
    Configure(Configure),
    /// Compute a candidate.
    Advance(Advance),
    /// Accept the last candidate of this step. Not answered.
    Commit {
        /// The step to accept.
        step: u64,
    },
    /// Write the accepted state to a file.
    Save {
        /// Where.
        path: String,
    },
    /// Read the accepted state from a file.
    Restore {
        /// Where from.
        path: String,
    },
    /// The run is over: leave with exit code 0. Not answered.
    Finish,
    /// Leave these fields out of every `Done` from now on. Not answered.
    Withhold {
        /// Fields of a candidate; a second `Withhold` replaces the first.
        fields: Vec<Field>,
    },
    /// Send these withheld fields of the accepted state: after `Commit`, before the next `Advance`.
    Tell {
        /// Which.
        fields: Vec<Field>,
    },
    /// Take these grains out of the accepted state: after `Commit`, before the next `Advance`; a run that is
    /// resumed does so after `Ready`, before `Restore`. The others
    /// keep their order; answered by `Ready(Grains)` with the next epoch and their six fields.
    Remove {
        /// Their numbers in the present order, ascending; at most [`REMOVED_MAX`] at once.
        grains: Vec<u64>,
    },
    /// Take cells of these sizes, in place of all that was asked before: after `Ready` or `Commit`, before the
    /// next `Advance`; a run that is resumed does so before `Restore`. The state is carried over to the new
    /// mesh, which depends on the sizes and on nothing else. Answered by `Ready(Mesh)` with this epoch and its
    /// fields, or by `Kept`.
    Adapt {
        /// Epoch of the mesh that is asked for.
        epoch: u64,
        /// How large cells are.
        sizes: Refinement,
    },
}

/// Engine → coupler.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ToCoupler {
    /// First message.
    Hello(Hello),
    /// Answer to `Configure`.
    Ready(Ready),
    /// Answer to `Advance`.
    Done(Done),
    /// Answer to `Save` and `Restore`.
    Stored,
    /// Instead of any answer; the engine leaves afterwards unless it was an `Advance` (the coupler may then
    /// try a smaller step or finish) or a `Save` (the disk may be full for a while).
    Failed(Failure),
    /// Answer to `Tell`; the fields follow.
    Told {
        /// The fields that follow.
        fields: Vec<Field>,
    },
    /// Answer to `Adapt`: the mesh stays as it is, and so does its epoch.
    Kept,
}

/// Coupler → orchestrator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ToOrchestrator {
    /// Coupling begins. When there is a mesh its fields follow, when there are grains `GrainRadius`.
    Started {
        /// Dimension of the space.
        dimension: u32,
        /// Nodes of the mesh, 0 without fluid.
        nodes: u64,
        /// Simplices of the mesh.
        simplices: u64,
        /// Grains, 0 without particles.
        grains: u64,
        /// Names and versions of the engines.
        engines: Vec<Hello>,
    },
    /// One accepted step: named values, in the order of `steps.csv`.
    Step(Vec<Diagnostic>),
    /// Fields of the accepted state follow.
    Snapshot {
        /// Step number (0: the initial state).
        step: u64,
        /// Its time \[s\].
        time: f64,
        /// The fields that follow.
        fields: Vec<Field>,
        /// Grains that are left.
        grains: u64,
    },
    /// The run ended as asked; totals (seconds by phase, worst invariants).
    Finished(Vec<Diagnostic>),
    /// The run ended early with this exit code.
    Stopped {
        /// Exit code of the run.
        code: i32,
        /// Why.
        why: String,
        /// Totals up to here.
        totals: Vec<Diagnostic>,
    },
    /// The recording ends here for this reason; the run goes on.
    RecordingEnded(String),
    /// The accepted state of this step lies in its [draft](crate::run::checkpoints::draft): all that was
    /// told before belongs to it.
    Checkpoint {
        /// Which step.
        step: u64,
        /// Its time \[s\].
        time: f64,
    },
    /// The accepted state cannot be kept, for this reason; the run goes on.
    NoCheckpoint(String),
    /// The mesh is another one from the next state on; its fields follow.
    Mesh {
        /// Nodes.
        nodes: u64,
        /// Simplices.
        simplices: u64,
    },
}

/// Orchestrator → coupler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FromOrchestrator {
    /// A snapshot has been taken over; the next one may be sent.
    SnapshotTaken,
    /// Stop after this step (Ctrl-C): finish the engines, keep what was computed.
    Stop,
}
