//! Pictures of space: grains as shaded spheres, and the speed of the fluid on an upright plane through the
//! middle of them, in a box that is seen in perspective from slightly above.
//!
//! A `camera` tells where points are seen, a `raster` which of them is the nearest; a `view` draws a state
//! with both, a `frame` and an `overview` put views with `axes` on paper.

mod axes;
mod camera;
pub mod frame;
pub mod overview;
mod raster;
mod view;

use super::state;

type Stage = state::Stage<3, 4>;
type State = state::State<3, 4>;
