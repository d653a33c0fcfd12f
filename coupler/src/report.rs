//! What one accepted step did.

use crate::budget::Budget;

/// A step in numbers.
#[derive(Debug, Clone, Copy, Default)]
pub struct StepReport {
    /// Its length \[s\].
    pub dt: f64,
    /// Lengths that were tried and failed before it.
    pub failed: u32,
    /// Fluid solves.
    pub passes: u32,
    /// Sub-steps of the grains.
    pub sub_steps: u32,
    /// Interaction defect of the pass accepted.
    pub interaction_defect: f64,
    /// Balances.
    pub budget: Budget,
}
