//! Walls, one-sided: segments in the plane, triangles in space.
//!
//! Each is a [`facet`], flat, with sides; where facets end or meet there is a [`ridge`]: a corner, in
//! space an edge too. [`near`] finds which of them a grain may touch, [`grounds`]
//! at which speed it then rubs.

mod concave;
pub mod facet;
pub mod grounds;
pub mod near;
pub mod ridge;
