//! A particle engine on the contact solver of rapier, a game engine: soft contacts, tuned for grains.

mod bodies;
mod contacts;
mod model;
mod plane;
mod serve;
mod solid;
#[cfg(test)]
mod tests;

use std::process::ExitCode;

fn main() -> ExitCode {
    serve::run()
}
