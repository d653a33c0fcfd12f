//! Pictures of the plane: a frame and a contact sheet, through a `view` of a window.

mod axes;
pub mod frame;
pub mod overview;
mod view;

use super::state;

type Stage = state::Stage<2, 3>;
type State = state::State<2, 3>;
