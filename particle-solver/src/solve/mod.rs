//! Solving all contacts of a sub-step.
//!
//! Read in this order: one [`sweep`] over the contacts, sweeps with [`momentum`], and the [`schedule`]:
//! which of them is used when, and when it is enough.

pub mod momentum;
pub mod schedule;
pub mod sweep;
