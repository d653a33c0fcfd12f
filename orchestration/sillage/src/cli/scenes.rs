//! Arguments of the commands that take a scene, and of `doctor`.

use std::path::PathBuf;

use clap::Args;

/// A scene with settings.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Scene file (TOML)
    pub scene: PathBuf,
    /// Set a key of the scene, e.g. --set run.end_time=0.5 (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
    /// Threads each engine may use (default: all cores); the built-in particle engine uses one
    #[arg(long, value_name = "N", value_parser = super::threads::parse)]
    pub threads: Option<std::num::NonZeroUsize>,
}

impl SceneArgs {
    /// Threads each engine may use; engines take turns, so each may have all cores.
    pub fn threads(&self) -> usize {
        self.threads
            .or_else(|| std::thread::available_parallelism().ok())
            .map_or(1, std::num::NonZeroUsize::get)
    }
}

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Run folder; an earlier run in it is replaced (default: runs/SCENE-TIME)
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Also replace an earlier run that has not reached its end and could be resumed
    #[arg(long, requires = "out")]
    pub replace: bool,
    /// Record all that the processes exchange (default FILE: that of the scene, or exchange.mcap)
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub record: Option<String>,
    /// One JSON document on stdout at the end
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `resume`.
#[derive(Debug, Args)]
pub struct ResumeArgs {
    /// Run folder
    pub folder: PathBuf,
    /// Set a key that may change on the way: run.end_time, checkpoint.*, limits.* (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
    /// Go on from the checkpoint of this step, not from the newest
    #[arg(long, value_name = "STEP")]
    pub from: Option<u64>,
    /// Threads each engine may use (default: as before)
    #[arg(long, value_name = "N", value_parser = super::threads::parse)]
    pub threads: Option<std::num::NonZeroUsize>,
    /// One JSON document on stdout at the end
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Scene file (TOML)
    #[arg(required_unless_present = "schema")]
    pub scene: Option<PathBuf>,
    /// Set a key of the scene, e.g. --set run.end_time=0.5 (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
    /// Also print what is in its mesh file: groups, sizes, qualities, and what has no condition
    #[arg(long)]
    pub mesh: bool,
    /// Print the JSON Schema of scenes, for editors
    #[arg(long, conflicts_with = "scene")]
    pub schema: bool,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Also write scene.json and grains.csv, what sillage-coupler takes, into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `doctor`.
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Remove what dead runs left in shared memory
    #[arg(long)]
    pub clean: bool,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}
