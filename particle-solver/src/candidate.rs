//! What is asked of an advance, and what comes back.

use crate::contact::{Candidate as Pair, Impulses};
use crate::delassus::Residual;
use crate::grains::State;
use crate::vector::Vector;

/// One call of `advance`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Number of the step.
    pub step: u64,
    /// Pass within the step, from 0.
    pub pass: u32,
    /// Length Δt \[s\].
    pub dt: f64,
    /// Sub-steps to use; 0: the engine chooses.
    pub sub_steps: u32,
    /// Contact residual at which a solve stops; 0: that of the setup.
    pub tolerance: f64,
}

/// Which candidate it is: two of the same label may follow each other from pass to pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Label {
    /// Number of the step.
    pub step: u64,
    /// Pass within the step.
    pub pass: u32,
    /// Length Δt \[s\]: the passes of a halved step do not follow those of the whole one.
    pub dt: f64,
}

impl Request {
    /// Label of the candidate that answers this request.
    pub fn label(&self) -> Label {
        Label {
            step: self.step,
            pass: self.pass,
            dt: self.dt,
        }
    }

    /// Label of the candidate of the pass before; none in pass 0.
    pub fn label_before(&self) -> Option<Label> {
        let pass = self.pass.checked_sub(1)?;
        Some(Label {
            pass,
            ..self.label()
        })
    }
}

/// What the fluid does to the grains during the step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Forces<'a> {
    /// γ \[kg/s\].
    pub drag: Option<&'a [f64]>,
    /// q \[N\], interleaved.
    pub force: Option<&'a [f64]>,
}

/// Numbers of a candidate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Report {
    /// Sub-steps made.
    pub sub_steps: u32,
    /// Active contacts at the end.
    pub contacts: usize,
    /// Most candidate contacts of a sub-step.
    pub candidates: usize,
    /// Sweeps of all solves.
    pub sweeps: usize,
    /// Largest residual of a sub-step.
    pub residual: Residual,
    /// Largest overlap at the end, of the smaller radius.
    pub penetration_max: f64,
    /// Kinetic energy at the end \[J\].
    pub kinetic_energy: f64,
    /// Contact problems solved; more than one a sub-step when margins had to grow.
    pub attempts: usize,
}

/// An active contact at the end of an advance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveContact {
    /// The pair, its normal, and its gap at the start of the last sub-step.
    pub pair: Pair,
    /// (normal, tangential) impulse over the length of the sub-step \[N\].
    pub force: [f64; 2],
}

/// A computed, not yet accepted step.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// What it was computed for.
    pub label: Label,
    /// The state at the end.
    pub state: State,
    /// (xⁿ⁺¹ − xⁿ)/Δt \[m/s\].
    pub mean_velocity: Vec<Vector>,
    /// 0 free, 1 touches, 2 force-connected to a wall or a fixed grain, in any sub-step.
    pub contact: Vec<u8>,
    /// Numbers.
    pub report: Report,
    /// Active contacts of the last sub-step.
    pub active: Vec<ActiveContact>,
    /// Impulses of the first sub-step, where the next pass starts.
    pub(crate) first_impulses: Impulses,
}
