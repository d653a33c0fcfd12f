//! `sillage-coupler`: couples a fluid engine and a particle engine over the scene given.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use protocol::runspace::RunSpace;

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
    tracing_subscriber::fmt().with_writer(std::io::stderr).init();
    let result = coupler::input::read(&arguments.scene).and_then(|(scene, grains)| {
        let runspace = RunSpace::from_environment()?;
        coupler::run::run(scene, &grains, &runspace)
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tracing::error!("{error}");
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(1))
        }
    }
}
