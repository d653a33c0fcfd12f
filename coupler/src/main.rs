//! `sillage-coupler`: couples a fluid engine and a particle engine over the scene given.

use std::num::NonZeroU64;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use coupler::checkpoints::Rule;
use coupler::error::CouplerError;
use coupler::record::Target;
use coupler::run::Files;
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
    /// Keep the state of the run in this folder, so that it can be resumed
    #[arg(long, value_name = "DIR")]
    checkpoints: Option<PathBuf>,
    /// Steps between two checkpoints (default: only the wall clock counts)
    #[arg(long, value_name = "N", requires = "checkpoints")]
    checkpoint_steps: Option<NonZeroU64>,
    /// Wall time between two checkpoints (s)
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0)]
    checkpoint_wall: f64,
    /// Go on from the checkpoint in this folder
    #[arg(long, value_name = "DIR")]
    resume: Option<PathBuf>,
    /// With --resume, record from the checkpoint on, and not what came before
    #[arg(long, requires = "resume")]
    record_anew: bool,
}

impl Arguments {
    fn files(self) -> Files {
        let compression = self.record_compression;
        let every_steps = self.checkpoint_steps.map(NonZeroU64::get);
        let every_wall = Duration::try_from_secs_f64(self.checkpoint_wall);
        Files {
            record: self.record.map(|path| Target { path, compression }),
            checkpoints: self.checkpoints.map(|folder| Rule {
                folder,
                every_steps,
                every_wall: every_wall.unwrap_or(Duration::MAX),
            }),
            resume: self.resume,
            record_anew: self.record_anew,
        }
    }
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
            let files = arguments.files();
            match scene.dimension {
                2 => coupler::run::run::<2, 3>(scene, &grains, &runspace, &files),
                _ => coupler::run::run::<3, 4>(scene, &grains, &runspace, &files),
            }
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
