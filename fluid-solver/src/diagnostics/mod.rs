//! Numbers of a candidate. Read in this order:
//!
//! * [`solved`]: a solution with what is needed to judge it
//! * [`powers`]: the energy identity
//! * [`forces`]: forces on boundaries, inflow, pressure drop

pub mod forces;
pub mod powers;
pub mod solved;

pub use powers::Powers;
pub use solved::Solved;
