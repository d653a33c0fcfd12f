//! Where each coupling scheme is stable: maps of small scenes with closed forms.
//!
//! This crate owns its physics openly: `scenes` and `plugs` have the cases, `suspended` what is suspended in them,
//! `limits` closed forms, `maps` the axes, all of them in the plane and in space. `whole` runs every cell, `verdict` judges it, `results` and `heat` tell.

pub mod dimension;
pub mod heat;
pub mod limits;
pub mod maps;
mod plugs;
pub mod results;
pub mod scenes;
pub mod schemes;
mod suspended;
mod text;
pub mod verdict;
mod whole;

pub use dimension::Dimension;
pub use whole::{Outcome, chosen, list, stability};
