//! Where the grains are at t = 0.
//!
//! `table` is what comes out; `generate` goes through the populations; `file` reads one, `place` makes
//! one: `arrange` at random or as a sunflower, `lattice` in rows, with `neighbours` against overlap.

mod arrange;
mod file;
mod generate;
mod lattice;
mod neighbours;
mod place;
mod random;
mod table;

pub use file::of_run;
pub use generate::generate;
pub(crate) use neighbours::Neighbours;
pub use table::GrainTable;
