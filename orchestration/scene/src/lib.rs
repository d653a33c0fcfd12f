//! One TOML file → validated scene → what the coupler and the engines receive, and what the run
//! will be.
//!
//! Read in four steps: text (`document`), keys (`keys`, `read`), ranges (`check`), and resolution
//! of what is relative or left out (`boundaries`, `walls`, `outline`, `grains`, `resolve`). Problems carry file,
//! line, key and what is allowed; all range problems of a scene are reported at once. What is of the plane or of space alone
//! stands in `dimensions`. `plan` tells
//! which processes, terms and fields the scene needs; `memory` bounds what is asked for,
//! `refinement` says how large cells may be, `times` that steps and states go together. `kept` is a scene as a run folder has it, for a run that is resumed.

pub mod boundaries;
pub mod check;
pub mod dimensions;
pub mod document;
pub mod error;
mod flat_walls;
pub mod grains;
pub mod kept;
pub mod keys;
mod load;
mod mean_flow;
mod memory;
mod mesh;
pub mod mesh_file;
pub mod mesh_survey;
mod outline;
pub mod plan;
mod populations;
pub mod problem;
pub mod read;
pub mod record;
mod refinement;
pub mod resolve;
mod scene;
mod sides;
mod times;
pub mod walls;

pub use error::Error;
pub use load::{from_document, load, problems_of_keys};
pub use scene::Scene;
