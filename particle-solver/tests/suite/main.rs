//! What the contact engine promises, in one binary.

mod balls;
mod bench_balls;
mod bench_box;
mod collapse;
mod drag;
mod motion;
mod neighbours;
mod packing;
mod pathology;
mod replay;
mod repose;
mod small_steps;
mod thrown_away;
mod unit_costs;
