//! A fluid engine that solves nothing: velocity and pressure are formulas in x, y and t.

mod formula;
mod rectangle;
mod serve;

use std::process::ExitCode;

fn main() -> ExitCode {
    serve::run()
}
