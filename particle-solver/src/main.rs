//! The particle engine as a process: speaks the protocol with the coupler, leaves when the run is over.

use std::process::ExitCode;

fn main() -> ExitCode {
    particle_solver::serve::run()
}
