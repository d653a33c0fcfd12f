//! Every key of a scene, as it stands in the file.
//!
//! `scene_file` names the tables; `fluid` with `boundary`, `grains`, `room`, `coupling` and `conduct` have
//! their keys, `numbers` their vectors. What may be chosen by name stands in `protocol::scene`, with its schema.

mod boundary;
mod conduct;
mod coupling;
mod fluid;
mod grains;
mod numbers;
mod ranges;
mod room;
mod scene_file;

pub use conduct::{Checkpoint, EngineCommand, Engines, LimitKeys, Output, Record};
pub use coupling::{Contact, Coupling};
pub use fluid::{BoxOfCells, Domain, Fluid, Rectangle, RefinementKeys};
pub use grains::{Arrangement, Cloud, FilledBox, Grains, Lattice, Pattern, Radius, RadiusRange};
pub use numbers::{Numbers, form};
pub use ranges::DENSEST;
pub use room::{Cylinder, DefaultWalls, GrainDomain, Particles, SIDES, Side, WallKeys};
pub use scene_file::{Gravity, Run, SceneFile, scene_schema};
