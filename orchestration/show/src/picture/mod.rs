//! Pictures: grains over the speed of the fluid, with axes, scale and colours explained.
//!
//! `draws` follows a run and makes them: a frame a state, a contact sheet of those that the `album` kept at
//! the end. What a `state` looks like on its stage is told by `plane` and by `space`, which `depict` chooses
//! from. All draw on a `canvas` with `axes` and `colour`, several states as a `sheet`.

mod album;
pub mod axes;
pub mod canvas;
pub mod colour;
mod depict;
mod draws;
mod plane;
mod sheet;
mod space;
mod state;

pub use draws::pictures;
