//! A particle engine on the contact solver of rapier, a game engine: soft contacts, tuned for grains.

mod contacts;
mod serve;
#[cfg(test)]
mod tests;
mod world;

use std::process::ExitCode;

fn main() -> ExitCode {
    serve::run()
}
