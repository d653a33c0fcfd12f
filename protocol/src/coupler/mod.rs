//! The coupler's side of the protocol: one engine as a [`partner`]; what it says is looked at first.

mod check;
mod hello;
pub mod partner;
mod told;
