//! The place of a candidate in the run.

use protocol::message::{Advance, Diagnostic};

use crate::state::State;

/// What is asked of both engines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Step number, from 1.
    pub step: u64,
    /// Pass within the step; 0 predicts contacts.
    pub pass: u32,
    /// Start of the step \[s\].
    pub time: f64,
    /// Its length \[s\].
    pub dt: f64,
}

impl Request {
    /// A pass of the step that follows an accepted state.
    pub fn after<const D: usize>(state: &State<D>, pass: u32, dt: f64) -> Request {
        Request {
            step: state.step + 1,
            pass,
            time: state.time,
            dt,
        }
    }

    /// As it crosses the boundary; `sub_steps` 0 lets the engine choose, `tolerance` is that of its
    /// contact solve.
    pub(super) fn advance(&self, sub_steps: u32, tolerance: f64) -> Advance {
        Advance {
            step: self.step,
            pass: self.pass,
            time: self.time,
            dt: self.dt,
            sub_steps,
            tolerance,
            fields: Vec::new(),
        }
    }
}

/// The value of a diagnostic, if the engine reported it.
pub fn value(diagnostics: &[Diagnostic], name: &str) -> Option<f64> {
    diagnostics
        .iter()
        .find(|diagnostic| diagnostic.name == name)
        .map(|diagnostic| diagnostic.value)
}
