//! What holds at the boundary, resolved to nodes once for a mesh. Read in this order:
//!
//! * [`condition`]: a condition, by the name of its boundary
//! * [`frame`]: velocity unknowns along a wall
//! * [`constraints`]: what is known about the unknowns of every node
//! * `slip`, `inflow`, `moving`, `open`: where that comes from
//! * [`floating`]: pressures that are known up to a constant
//! * [`flux`]: what flows across boundaries whose velocity is given

pub mod condition;
pub mod constraints;
pub mod floating;
pub mod flux;
pub mod frame;
mod inflow;
mod moving;
mod node;
mod open;
mod slip;

pub use condition::{Condition, VelocityFunction};
pub use constraints::Constraints;
pub use floating::Floating;
pub use flux::BoundaryFlux;
pub use frame::Frame;
