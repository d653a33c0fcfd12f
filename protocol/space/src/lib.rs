//! What depends on the number of dimensions, and nothing else: no physics, no protocol.
//!
//! Everything above is written once for `D` dimensions, with `N = D + 1`: the corners of a simplex,
//! and the unknowns (velocity, pressure) of a node. Read in this order:
//!
//! * [`vector`]: points and vectors, their sums in a fixed order
//! * [`linear`]: numbers or vectors that add, scale and have a length
//! * [`dimension`]: what cannot be written for every `D` at once
//! * [`simplex`]: the one geometry of triangles and tetrahedra
//! * [`quadrature`]: rules on segments, triangles and tetrahedra
//! * [`periodic`]: images across periodic sides
//! * [`grid`]: the one cell grid: pairs of bodies within reach of each other
//! * [`flat`]: vectors as the flat numbers that cross a process boundary, without a copy

pub mod dimension;
pub mod flat;
pub mod grid;
#[cfg(test)]
mod grid_tests;
pub mod linear;
pub mod periodic;
pub mod quadrature;
pub mod simplex;
#[cfg(test)]
mod simplex_tests;
pub mod vector;

pub use dimension::{Dim, Dimension, Spin, Tangent};
pub use linear::Linear;
pub use periodic::Period;
pub use simplex::Simplex;
pub use vector::{Vector, dot, hypot, norm};
