//! Error against run time: a scene run many times.
//!
//! `whole` is a study from its file (`keys`, `points`) over runs or other programs (`program`) and what
//! is measured of them (`measure`) to `results`, `analysis`, `plot` and `page`.

pub mod analysis;
pub mod keys;
pub mod measure;
pub mod page;
pub mod plot;
pub mod points;
pub mod program;
pub mod results;
mod whole;

pub use whole::{Outcome, list, study};
