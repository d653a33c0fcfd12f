//! Where each coupling scheme is stable: maps of small scenes with closed forms.
//!
//! This crate owns its physics openly: `scenes` and `plugs` have the cases, `limits` closed forms, `maps` the
//! axes. `whole` runs every cell, `verdict` judges it, `results` and `heat` tell.

pub mod heat;
pub mod limits;
pub mod maps;
mod plugs;
pub mod results;
pub mod scenes;
pub mod schemes;
pub mod verdict;
mod whole;

pub use whole::{Outcome, chosen, list, stability};
