//! Drag of the fluid on a grain. Read in this order:
//!
//! * [`laws`]: γ of every law, (D1)–(D6)
//! * [`slip`]: the slip speed that a law decides over a step, (D7)

pub mod laws;
pub mod slip;

pub use laws::{Fluid, POROSITY_RANGE, Shape, coefficient};
pub use slip::implicit_slip_speed;
