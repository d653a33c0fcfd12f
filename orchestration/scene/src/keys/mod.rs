//! Every key of a scene, as it stands in the file.
//!
//! `scene_file` names the tables; `fluid` with `boundary`, `grains`, `room`, `coupling` and `conduct` have
//! their keys. What may be chosen by name stands in `protocol::scene`, with its schema.

mod boundary;
mod conduct;
mod coupling;
mod fluid;
mod grains;
mod ranges;
mod room;
mod scene_file;

pub use conduct::{Checkpoint, EngineCommand, Engines, LimitKeys, Output, Record};
pub use coupling::{Contact, Coupling};
pub use fluid::{Domain, Fluid, Rectangle, RefinementKeys};
pub use grains::{Arrangement, Cloud, FilledBox, Grains, Lattice, Pattern, Radius, RadiusRange};
pub use ranges::DENSEST;
pub use room::{DefaultWalls, GrainDomain, Particles, Side, WallSegment};
pub use scene_file::{Gravity, Run, SceneFile, scene_schema};
