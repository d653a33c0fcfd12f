//! Who is near whom.
//!
//! Read in this order: the [`place`] of grains and walls, and the [`neighbours`]: what is kept of a
//! search with the cell grid of `space`.

pub mod neighbours;
pub mod place;
