//! What the fluid engine promises, with the tables that show it.

mod balance;
mod benchmarks;
mod costs;
mod creeping;
mod held;
mod manufactured;
mod porous;
mod refusals;
mod space;
mod support;
mod symmetry;
