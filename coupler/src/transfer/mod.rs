//! Grains ↔ mesh. Read in this order:
//!
//! * [`mesh`]: the mesh as the fluid engine tells it
//! * [`quantity`]: what is deposited and sampled, a number or a vector
//! * [`bins`], [`locate`]: the simplex around a point and its shape functions
//! * [`bell`]: the kernel of a grain (T3), as points
//! * [`neighbours`], [`path`]: from the centre of a grain to its points, thrown back by walls
//! * [`placement`]: the nodes of each grain and their weights
//! * [`deposit`]: deposit and sample, (T1) and (T2)

pub mod bell;
pub mod bins;
pub mod deposit;
pub mod locate;
pub mod mesh;
pub mod neighbours;
pub mod path;
pub mod placement;
pub mod quantity;

pub use deposit::Transfer;
pub use mesh::Mesh;
pub use placement::Placement;
