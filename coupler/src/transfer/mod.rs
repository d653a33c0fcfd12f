//! Grains ↔ mesh. Read in this order:
//!
//! * [`mesh`]: the mesh as the fluid engine tells it
//! * [`quantity`]: what is deposited and sampled, a number or a vector
//! * [`bins`], [`locate`]: the simplex around a point and its shape functions
//! * [`kernel`]: the smoothing of what is deposited, L²K
//! * [`deposit`]: deposit and sample, (T1) and (T2)

pub mod bins;
pub mod deposit;
pub mod kernel;
pub mod locate;
pub mod mesh;
pub mod quantity;

pub use deposit::{Placement, Transfer};
pub use mesh::Mesh;
