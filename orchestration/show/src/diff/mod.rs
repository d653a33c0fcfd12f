//! What two runs or recordings differ in: `compare` does it, `steps` the tables of two folders.

mod compare;
mod steps;

pub use compare::{Comparison, compare};
