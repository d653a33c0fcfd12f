//! Simplices, their nodes, and the facets of the boundary. Read in this order:
//!
//! * [`facet`], [`simplices`]: a facet of the boundary, and the mesh itself
//! * `parts`: which nodes hang together
//! * `facets`: which sides of simplices are the boundary, and of which name
//! * [`rectangle`], [`mod@file`]: the two ways to a mesh; rectangles know no space
//! * [`sizes`], [`bisection`]: the third, cells as large as a function of the place says, from a [`root`] of cells or
//!   from a mesh ([`longest`])
//! * [`nested`]: coarser ones under such a mesh

pub mod bisection;
pub mod facet;
mod facets;
pub mod file;
pub mod longest;
pub mod nested;
mod parts;
pub mod rectangle;
pub mod root;
pub mod simplices;
pub mod sizes;

pub use bisection::{Bisection, Forest, Spot};
pub use facet::BoundaryFacet;
pub use longest::LongestEdge;
pub use nested::Coarser;
pub use rectangle::{Diagonals, Rectangle};
pub use root::Root;
pub use simplices::Mesh;
pub use sizes::{Place, Sizes, Zone};
