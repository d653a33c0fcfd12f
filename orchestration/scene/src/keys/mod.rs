//! Every key of a scene, as it stands in the file.
//!
//! `scene_file` names the tables; `fluid`, `grains`, `room`, `coupling` and `conduct` have their keys,
//! `schema` what editors are told of the protocol's enums.

mod conduct;
mod coupling;
mod fluid;
mod grains;
mod room;
mod scene_file;
mod schema;

pub use conduct::{EngineCommand, Engines, LimitKeys, Output, Record};
pub use coupling::{Contact, Coupling};
pub use fluid::{BoundaryKey, Domain, Fluid, Rectangle};
pub use grains::{Arrangement, Cloud, FilledBox, Grains, Lattice, Pattern, Radius, RadiusRange};
pub use room::{DefaultWalls, GrainDomain, Particles, Side, WallSegment};
pub use scene_file::{Gravity, Run, SceneFile, scene_schema};
pub use schema::DRAG_LAWS;
