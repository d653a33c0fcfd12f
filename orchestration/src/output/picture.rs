//! Pictures: grains over the speed of the fluid, with axes, scale and colours explained.

pub mod axes;
pub mod canvas;
pub mod colour;
pub mod frame;
pub mod overview;
pub mod state;
pub mod view;
