//! The linear system: a sparse direct solver for blocks of N unknowns a node. Read in this order:
//!
//! * [`pattern`], [`system`]: which entries exist; matrix and right-hand side
//! * [`dissection`]: in which order nodes are eliminated
//! * [`multifrontal`]: the factor on the fronts of that order
//! * [`pivoting`]: the safe factor, where that one is not accurate enough
//! * [`solver`]: scaling, refinement, and the choice between the two

pub mod dissection;
pub mod multifrontal;
pub mod pattern;
pub mod pivoting;
pub mod solver;
pub mod system;

pub use pattern::Pattern;
pub use solver::{LinearSolver, Solution};
pub use system::System;
