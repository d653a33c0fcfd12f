//! What the compiler does not see: who depends on whom, which file names which, and how large things are.

mod circles;
mod clocks;
mod graph;
mod sizes;
mod sources;
mod spellings;
mod unsafe_code;
