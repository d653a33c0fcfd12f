//! Grains that touch: Moreau–Jean non-smooth contact dynamics of balls (in the plane: disks) between walls.
//!
//! One sub-step of length δt, from the accepted state:
//!
//! ```text
//!   (m + γδt) v_free = m vⁿ + δt (m g + q)                        free velocity        contact::loads
//!   v = v_free + A⁻¹ Hᵀ R,   A = m + γδt                          contact operator     contact
//!   0 ≤ R_n  ⊥  gap + δt u_n ≥ 0,   |R_t| ≤ μ R_n                 law of a contact     contact::law
//!   xⁿ⁺¹ = xⁿ + δt v                                              motion               step
//! ```
//!
//! Written once for `D` dimensions, with what differs between plane and space in `space::Dimension`.
//!
//! | file | what |
//! | --- | --- |
//! | `grains`, `walls` | what there is |
//! | `setup` | what a scene tells |
//! | `search` | who is near whom, and what is kept of it |
//! | `contact` | law of one contact, operator and residual of all, pairs of a sub-step |
//! | `solve` | Gauss–Seidel sweeps, faster iterations, and which is used when |
//! | `small` | many sub-steps with one sweep each, instead |
//! | `step` | how many sub-steps, one of them, what is done about overlaps; the engine |
//! | `checkpoint` | files of the accepted state |
//! | `serve` | the only file that knows the protocol |

pub mod checkpoint;
pub mod contact;
pub mod error;
pub mod grains;
pub mod search;
pub mod serve;
pub mod setup;
pub mod small;
pub mod solve;
pub mod step;
pub mod walls;

pub use error::Error;
pub use grains::{Grains, State};
pub use setup::Setup;
pub use step::candidate::{ActiveContact, Candidate, Report};
pub use step::engine::ContactEngine;
pub use step::request::{Forces, Label, Request};
pub use walls::facet::Facet;
