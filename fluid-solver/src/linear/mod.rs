//! The linear system, in blocks of N unknowns a node. Read in this order:
//!
//! * [`pattern`], [`system`]: which entries exist; matrix and right-hand side
//! * [`measure`]: how equations are scaled, and how good a solution is
//! * [`method`]: which of the two solvers is taken
//!
//! The direct solver:
//!
//! * [`dissection`]: in which order nodes are eliminated
//! * [`multifrontal`]: the factor on the fronts of that order
//! * [`pivoting`]: the safe factor, where that one is not accurate enough
//! * [`solver`]: refinement, and the choice between the two
//!
//! The iterative solver, for large meshes in space:
//!
//! * [`block_rows`], [`ilu`]: matrices in single precision and their incomplete factors
//! * [`transfer`], [`hierarchy`]: from a mesh to a coarser one, and all of them
//! * [`multigrid`]: a cycle over them
//! * [`krylov`], [`iterative`]: the iteration that it preconditions, and what is done where that is not enough

pub mod block_rows;
pub mod dissection;
pub mod hierarchy;
pub mod ilu;
pub mod iterative;
pub mod krylov;
pub mod measure;
pub mod method;
pub mod multifrontal;
pub mod multigrid;
pub mod pattern;
pub mod pivoting;
pub mod solver;
pub mod system;
pub mod transfer;

pub use method::Method;
pub use pattern::Pattern;
pub use solver::{LinearSolver, Solution};
pub use system::System;
