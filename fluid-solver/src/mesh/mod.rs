//! Simplices, their nodes, and the facets of the boundary. Read in this order:
//!
//! * [`facet`], [`simplices`]: a facet of the boundary, and the mesh itself
//! * `facets`: which sides of simplices are the boundary, and of which name
//! * [`rectangle`], [`gmsh`]: the two ways to a mesh in the plane, the only places that know no space

pub mod facet;
mod facets;
pub mod gmsh;
pub mod rectangle;
pub mod simplices;

pub use facet::BoundaryFacet;
pub use rectangle::{Diagonals, Rectangle};
pub use simplices::Mesh;
