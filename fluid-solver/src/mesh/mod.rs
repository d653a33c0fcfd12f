//! Simplices, their nodes, and the facets of the boundary. Read in this order:
//!
//! * [`facet`], [`simplices`]: a facet of the boundary, and the mesh itself
//! * `parts`: which nodes hang together
//! * `facets`: which sides of simplices are the boundary, and of which name
//! * [`rectangle`], [`mod@file`]: the two ways to a mesh; rectangles know no space
//! * [`sizes`], [`bisection`]: the third, cells as large as a function of the place says

pub mod bisection;
pub mod facet;
mod facets;
pub mod file;
mod parts;
pub mod rectangle;
pub mod simplices;
pub mod sizes;

pub use bisection::{Bisection, Root};
pub use facet::BoundaryFacet;
pub use rectangle::{Diagonals, Rectangle};
pub use simplices::Mesh;
pub use sizes::{Place, Sizes, Zone};
