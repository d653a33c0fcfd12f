//! Walls, one-sided: segments in the plane, triangles in space.
//!
//! Each is a [`facet`], flat, with sides; where facets end or meet there is a [`ridge`]: a corner, in
//! space an edge too. [`near`] finds which of them a grain may touch.

pub mod facet;
pub mod near;
pub mod ridge;
