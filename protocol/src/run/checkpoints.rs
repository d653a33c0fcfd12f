//! Names of what a run keeps of itself, so that it can be resumed: the coupler makes a draft, the
//! orchestrator completes it.
//!
//! ```text
//!   checkpoints/step-0000000120.part/    coupler, fluid, particles: each by its process     (draft)
//!   checkpoints/step-0000000120/         the same, outputs.json and manifest.json           (complete)
//! ```

/// Folder of the checkpoints, in that of the run.
pub const FOLDER: &str = "checkpoints";
/// State of the coupler, and of each engine by the name of its seat.
pub const COUPLER: &str = "coupler";

/// The folder of a complete checkpoint.
pub fn complete(step: u64) -> String {
    format!("step-{step:010}")
}

/// The folder of one that is not complete yet.
pub fn draft(step: u64) -> String {
    complete(step) + ".part"
}

/// The step of a complete checkpoint; none of another folder.
pub fn step_of(folder: &str) -> Option<u64> {
    let digits = folder.strip_prefix("step-")?;
    let step = digits.parse().ok()?;
    (complete(step) == folder).then_some(step)
}
