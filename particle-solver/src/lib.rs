//! Grains that touch: Moreau–Jean non-smooth contact dynamics of disks between wall segments.
//!
//! One sub-step of length δt, from the accepted state:
//!
//! ```text
//!   (m + γδt) v_free = m vⁿ + δt (m g + q)                        free velocity        delassus
//!   v = v_free + A⁻¹ Hᵀ R,   A = m + γδt                          contact operator     delassus
//!   0 ≤ R_n  ⊥  gap + δt u_n ≥ 0,   |R_t| ≤ μ R_n                 law of a contact     law
//!   xⁿ⁺¹ = xⁿ + δt v                                              motion               step
//! ```
//!
//! | file | what |
//! | --- | --- |
//! | `grains`, `walls` | what there is |
//! | `detect`, `neighbours`, `contact` | who may touch: cell lists, what is kept of them, candidates of a sub-step |
//! | `delassus`, `law` | the operator, and the law of one contact |
//! | `nlgs`, `accelerate`, `solve` | Gauss–Seidel sweeps, faster iterations, and who is used when |
//! | `sub_steps`, `sub_step`, `correct` | how many, one of them, what is done about overlaps |
//! | `setup`, `candidate` | what a scene tells, what an advance is asked and answers |
//! | `step`, `touched` | one `advance`; who touches and who hangs on a wall |
//! | `state` | checkpoint files |
//! | `serve` | the only file that knows the protocol |

pub mod accelerate;
pub mod candidate;
pub mod contact;
pub mod correct;
pub mod delassus;
pub mod detect;
pub mod error;
pub mod grains;
pub mod law;
pub mod neighbours;
pub mod nlgs;
pub mod serve;
pub mod setup;
pub mod solve;
pub mod state;
pub mod step;
pub mod sub_step;
pub mod sub_steps;
pub mod touched;
pub mod vector;
pub mod walls;

pub use candidate::{ActiveContact, Candidate, Forces, Label, Report, Request};
pub use error::Error;
pub use grains::{Grains, State};
pub use setup::Setup;
pub use step::ContactEngine;
pub use walls::Segment;
