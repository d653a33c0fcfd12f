//! `sillage-coupler`: couples a fluid engine and a particle engine over the scene given.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use coupler::error::CouplerError;

/// Couple a fluid engine and a particle engine: owns the clock, the scheme, the transfer and drag.
///
/// The engines and this process find each other by the environment that `sillage run` sets (see
/// protocol/README.md to start them by hand). Without an orchestrator one JSON object a step goes
/// to standard output.
#[derive(Parser)]
#[command(name = "sillage-coupler", version)]
struct Arguments {
    /// Resolved scene: DIR/scene.json as written by `sillage plan SCENE --out DIR`
    #[arg(long)]
    scene: PathBuf,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = protocol::process::enter("coupler")
        .map_err(CouplerError::from)
        .and_then(|runspace| {
            let (scene, grains) = coupler::input::read(&arguments.scene)?;
            coupler::run::run(scene, &grains, &runspace)
        });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tracing::error!("coupler: {error}");
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(1))
        }
    }
}
