//! What a scene needs and what it does without.
//!
//! `whole` is the plan; `choices` what a run chooses by itself, with the shares of `cost`.

mod cells;
pub mod choices;
mod cost;
mod kept;
mod whole;

pub use choices::Choice;
pub use whole::{Exchange, Plan, Process, plan, processes, scene_json, write_inputs};
