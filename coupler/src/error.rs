//! What can end a coupled run.

use space::Vector;
use thiserror::Error;

/// Errors of the coupler; `exit_code` is what the process leaves with.
#[derive(Debug, Error)]
pub enum CouplerError {
    /// A link or an engine failed.
    #[error(transparent)]
    Protocol(#[from] protocol::error::Error),
    /// The recording cannot be begun.
    #[error(transparent)]
    Recording(#[from] recording::RecordingError),
    /// The resolved scene or its grains file cannot be used.
    #[error("{file}: {why}")]
    Scene {
        /// The file.
        file: String,
        /// What is wrong, where, and what is allowed.
        why: String,
    },
    /// The walls of the grains cannot be made, or not be run.
    #[error("walls of the grains: {why}")]
    Walls {
        /// What is wrong, and the remedy.
        why: String,
    },
    /// There is neither a fluid nor a grain.
    #[error("nothing to couple: the scene has neither a fluid nor grains")]
    Nothing,
    /// Numbers that are no vectors of this run.
    #[error("{what}: {count} numbers are no vectors of {dimension}")]
    Dimension {
        /// Whose.
        what: String,
        /// How many numbers.
        count: usize,
        /// Numbers of a vector.
        dimension: usize,
    },
    /// A grain is not on the mesh.
    #[error(
        "grain {grain} at {at} m is outside the fluid's mesh; grains must stay inside: \
         check the walls (particles.boundaries makes one of an open side with \"wall\" and takes grains out \
         there with \"removed\"), or take a smaller coupling step"
    )]
    GrainOutside {
        /// Which grain.
        grain: usize,
        /// Its position \[m\].
        at: String,
    },
    /// The porosity is not positive at a node.
    #[error(
        "porosity {porosity:.4} at node {node} {at} m: it must stay above 0; the \
         grains there are packed too densely for the cells, or overlap: use larger cells or fewer grains"
    )]
    Porosity {
        /// Which node.
        node: usize,
        /// φ there.
        porosity: f64,
        /// Its position \[m\].
        at: String,
    },
    /// The passes of a step did not bring the defect below the tolerance.
    #[error(
        "step {step}: interaction defect {defect:.2e} after {passes} passes, above the tolerance \
         {tolerance:.1e} ({held} grains held, {touching} touching, {grains} in all): \
         allow more passes, or take a smaller coupling step"
    )]
    NotConverged {
        /// Which step.
        step: u64,
        /// Defect of the last pass.
        defect: f64,
        /// The tolerance asked for.
        tolerance: f64,
        /// Passes done.
        passes: u32,
        /// Grains force-connected to a wall.
        held: usize,
        /// Other grains with an active contact.
        touching: usize,
        /// All grains.
        grains: usize,
    },
    /// A contact state that is none.
    #[error(
        "step {step}: the particle engine says grain_contact {number} of grain {grain}, allowed: 0 free, \
         1 touches, 2 held"
    )]
    ContactState {
        /// Which step.
        step: u64,
        /// Which grain.
        grain: usize,
        /// What it says.
        number: f64,
    },
    /// A value that must be finite is not.
    #[error("step {step}: {what} is not finite")]
    NotFinite {
        /// Which step.
        step: u64,
        /// The quantity and its place.
        what: String,
    },
    /// What a step exchanged does not balance.
    #[error(
        "step {step}: {what} is {defect:.2e}, allowed is {bound:.0e}: what grains and fluid gave each other \
         does not balance; a smaller coupling step, or a report of this scene"
    )]
    Unbalanced {
        /// Which step.
        step: u64,
        /// Which defect.
        what: &'static str,
        /// How large it is.
        defect: f64,
        /// How large it may be.
        bound: f64,
    },
    /// A step failed at the smallest length too.
    #[error(
        "step {step}: needs a coupling step of {dt:.3e} s, below the smallest allowed, {step_min:.3e} s \
         (run.step_min; without it coupling_step/64, or step_min when adaptive): {why}"
    )]
    StepTooSmall {
        /// Which step.
        step: u64,
        /// The step length that would be needed \[s\].
        dt: f64,
        /// The bound \[s\].
        step_min: f64,
        /// Why it was halved.
        why: String,
    },
    /// What was kept of a run cannot be written, or not be resumed.
    #[error("checkpoint {file}: {why}")]
    Checkpoint {
        /// The file.
        file: String,
        /// Why not.
        why: String,
    },
    /// Asked to stop.
    #[error("stopped on request after step {step}")]
    Interrupted {
        /// Last accepted step.
        step: u64,
    },
}

impl CouplerError {
    /// Exit code of a process that ends with this error.
    pub fn exit_code(&self) -> i32 {
        match self {
            CouplerError::Protocol(error) => error.exit_code(),
            CouplerError::Recording(error) => error.exit_code(),
            CouplerError::Scene { .. }
            | CouplerError::Walls { .. }
            | CouplerError::Checkpoint { .. }
            | CouplerError::Nothing => 2,
            CouplerError::GrainOutside { .. }
            | CouplerError::Dimension { .. }
            | CouplerError::ContactState { .. }
            | CouplerError::Porosity { .. }
            | CouplerError::Unbalanced { .. }
            | CouplerError::NotFinite { .. } => 7,
            CouplerError::NotConverged { .. } | CouplerError::StepTooSmall { .. } => 8,
            CouplerError::Interrupted { .. } => 130,
        }
    }
}

/// A position as errors tell it.
pub fn place<const D: usize>(position: &Vector<D>) -> String {
    let numbers: Vec<String> = position.iter().map(|x| format!("{x:.6e}")).collect();
    format!("({})", numbers.join(", "))
}
