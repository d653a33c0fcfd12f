//! The coupler: the clock, the staggered scheme, the transfer between grains and mesh, drag, budgets.
//!
//! It talks to a fluid engine and a particle engine through `protocol` and knows how neither solves.

pub mod anderson;
pub mod budget;
pub mod clock;
pub mod comparison;
pub mod coupling;
pub mod defect;
pub mod drag;
pub mod engines;
pub mod error;
pub mod input;
pub mod locate;
pub mod observe;
pub mod proximity;
pub mod record;
pub mod response;
pub mod run;
pub mod scheme;
pub mod transfer;
