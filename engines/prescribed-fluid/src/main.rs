//! A fluid engine that solves nothing: velocity and pressure are formulas in x, y, z and t.

mod formula;
mod lattice;
mod serve;

use std::process::ExitCode;

fn main() -> ExitCode {
    serve::run()
}
