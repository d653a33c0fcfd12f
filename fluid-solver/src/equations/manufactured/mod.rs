//! Manufactured solutions: the source comes from exact derivatives, so that every term of the
//! equations is exercised. For tests, and for the study of what accuracy costs. Read in this order:
//!
//! * [`jet`]: numbers that carry their derivatives
//! * [`exact`]: an exact flow, its source, and errors against it
//! * [`flows`], [`flows_in_space`]: flows

pub mod exact;
pub mod flows;
pub mod flows_in_space;
pub mod jet;

pub use exact::{Exact, at_nodes, errors};
pub use flows::{lethe, suspension};
pub use flows_in_space::{lethe_in_space, straining_in_space, suspension_in_space};
