//! Pictures: grains over the speed of the fluid, with axes, scale and colours explained.
//!
//! `draws` follows a run and makes them: a `frame` a state, an `overview` at the end. Both look
//! through a `view` of the plane at a `state`, and draw on a `canvas` with `axes` and `colour`.

pub mod axes;
pub mod canvas;
pub mod colour;
mod draws;
pub mod frame;
pub mod overview;
pub mod state;
pub mod view;

pub use draws::pictures;
