//! Contacts: their law, the operator that couples them, and who touches whom.
//!
//! Read in this order: [`law`] of one contact, [`impulses`] that are remembered by pair, [`loads`] on
//! the grains, the operator of all contacts ([`delassus`]), how far a solution is from the laws
//! ([`residual`]), the [`pairs`] that may touch.

pub mod delassus;
pub mod impulses;
pub mod law;
pub mod loads;
pub mod pairs;
pub mod residual;
