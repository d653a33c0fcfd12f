//! `sillage-coupler`: couples a fluid engine and a particle engine over the scene given.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use coupler::error::CouplerError;
use coupler::record::Target;
use recording::Compression;

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
    /// Record every field and message of the run into this file (MCAP)
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Compression of the recording: zstd or none
    #[arg(long, value_name = "NAME", default_value = "zstd", value_parser = compression)]
    record_compression: Compression,
}

fn compression(name: &str) -> Result<Compression, String> {
    match name {
        "zstd" => Ok(Compression::Zstd),
        "none" => Ok(Compression::None),
        _ => Err("allowed: zstd, none".to_owned()),
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = protocol::process::enter("coupler")
        .map_err(CouplerError::from)
        .and_then(|runspace| {
            let (scene, grains) = coupler::input::read(&arguments.scene)?;
            let record = arguments.record.map(|path| Target {
                path,
                compression: arguments.record_compression,
            });
            coupler::run::run::<2, 3>(scene, &grains, &runspace, record.as_ref())
        });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            match error {
                // As somebody wished.
                CouplerError::Interrupted { .. } => tracing::info!("{error}"),
                _ => tracing::error!("coupler: {error}"),
            }
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(1))
        }
    }
}
