//! The volume-averaged equations, from their terms to the assembled system. Read in this order:
//!
//! * [`coefficients`]: what the equations are told
//! * [`element`], [`point`]: the values of a simplex, and what the terms share at a quadrature point
//! * [`momentum`], [`continuity`], [`stabilization`]: the terms, entry by entry
//! * [`open`]: the facets of open boundaries
//! * `held`: what is different where held grains drag unevenly
//! * `kernel`: all terms again, in sums that are quick to take, for several simplices at a time
//! * [`assembly`]: the system made of them
//! * [`coarse`]: what coarser meshes of the iterative solver lack
//! * [`drive`]: the mean of a flow through periodic sides, steered
//! * [`creeping`]: when convection may be left out
//! * [`manufactured`]: exact solutions for tests and studies

pub mod assembly;
pub mod coarse;
pub mod coefficients;
pub mod continuity;
pub mod creeping;
pub mod drive;
pub mod element;
mod held;
pub(crate) mod kernel;
pub mod manufactured;
pub mod momentum;
pub mod open;
pub mod point;
pub mod stabilization;

pub use coefficients::{BodyForce, Carrier, Coefficients, ViscousForm};
