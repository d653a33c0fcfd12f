//! Manufactured solutions: the source comes from exact derivatives, so that every term of the
//! equations is exercised. For tests, and for the study of what accuracy costs. Read in this order:
//!
//! * [`jet`]: numbers that carry their derivatives
//! * [`exact`]: an exact flow, its source, and errors against it
//! * [`flows`]: flows in the plane

pub mod exact;
pub mod flows;
pub mod jet;

pub use exact::{Exact, at_nodes, errors};
pub use flows::{lethe, suspension};
