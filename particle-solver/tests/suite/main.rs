//! What the contact engine promises, in one binary.

mod balls;
mod bench_box;
mod drag;
mod motion;
mod neighbours;
mod packing;
mod pathology;
mod replay;
mod thrown_away;
