//! The linear system, in blocks of N unknowns a node. Read in this order:
//!
//! * [`pattern`], [`system`]: which entries exist; matrix and right-hand side
//! * [`measure`]: how equations are scaled, and how good a solution is
//! * [`method`]: which of the two solvers is taken
//!
//! The direct solver:
//!
//! * [`order`]: in which order nodes are eliminated, and in which groups
//! * [`multifrontal`], [`plans`]: the factor on the fronts of that order
//! * `eliminate`, `invert`, `product`, `tile`, `substitution`, `real`: its numbers, in single or double precision
//! * [`pivoting`]: the safe factor, where that one is not accurate enough
//! * [`solver`]: refinement, and the choice between them
//!
//! The iterative solver, for large meshes in space:
//!
//! * [`block_rows`], [`ilu`]: matrices in single precision and their incomplete factors
//! * [`transfer`], [`hierarchy`]: from a mesh to a coarser one, and all of them
//! * [`multigrid`]: a cycle over them
//! * [`krylov`], [`iterative`]: the iteration that it preconditions, and what is done where that is not enough

pub mod block_rows;
mod eliminate;
pub mod hierarchy;
pub mod ilu;
mod invert;
pub mod iterative;
pub mod krylov;
pub mod measure;
pub mod method;
pub mod multifrontal;
pub mod multigrid;
pub mod order;
pub mod pattern;
pub mod pivoting;
pub mod plans;
mod product;
mod real;
pub mod solver;
mod substitution;
pub mod system;
mod tile;
pub mod transfer;

pub use method::Method;
pub use pattern::Pattern;
pub use solver::{LinearSolver, Solution};
pub use system::System;
