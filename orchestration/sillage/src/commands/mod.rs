//! What each command does and says. Their results are exit codes; errors are told by `main`.

pub mod engines;
mod examine;
pub mod pages;
pub mod recordings;
pub mod scenes;
pub mod sweeps;
