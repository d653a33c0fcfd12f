//! Numbers of a candidate. Read in this order:
//!
//! * [`solved`]: a solution with what is needed to judge it
//! * [`powers`]: the energy identity
//! * [`forces`]: forces on boundaries, inflow, pressure drop
//! * [`content`]: volume, momentum and energy, and what a change of mesh does to them

pub mod content;
pub mod forces;
pub mod powers;
pub mod solved;

pub use content::{Content, MeshChange};
pub use powers::Powers;
pub use solved::Solved;
