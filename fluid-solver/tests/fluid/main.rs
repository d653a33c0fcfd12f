//! What the fluid engine promises, with the tables that show it.

mod balance;
mod benchmarks;
mod manufactured;
mod porous;
mod refusals;
mod support;
