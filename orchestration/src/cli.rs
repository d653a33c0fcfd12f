//! The command line.

mod pages;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use protocol::messages::Role;

pub use pages::{ReportArgs, StabilityArgs, StudyArgs, ViewArgs};

const EXIT_CODES: &str = "\
Exit codes:
  0 ok                     5 partner lost
  1 outside the tolerance (replay, diff), or a check failed (conform, stability)
  2 usage, scene or file   6 time limit
  3 handshake or version   7 not finite, or an invariant broken
  4 engine failed          8 not converged
  130 interrupted";

const EXAMPLES: &str = "\
Examples:
  sillage run scenes/cloud.toml
  sillage run scenes/cloud.toml --out runs/coarse --set fluid.domain.rectangle.cells=[40,120]
  sillage check scenes/cloud.toml
  sillage plan scenes/cloud.toml --out by-hand
  sillage run scenes/cloud.toml --record --out runs/cloud
  sillage replay runs/cloud/exchange.mcap --as fluid
  sillage diff runs/cloud runs/coarse
  sillage report runs/cloud
  sillage study one-grain
  sillage stability --quick
  sillage doctor --clean";

const CONFORM_HELP: &str = "\
Examples:
  sillage conform --as fluid -- target/release/sillage-fluid
  sillage conform --as particles --json -- python3 my_engine.py --option 1
  sillage conform --as particles --check same-request --check nan -- ./my-engine

Exit codes:
  0 nothing failed         2 usage or scene
  1 a check failed         4 the command cannot be started";

/// Grains in a fluid, in two dimensions: a finite-element fluid, non-smooth contacts, and the
/// coupling between them, each in its own process.
#[derive(Debug, Parser)]
#[command(name = "sillage", version, after_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"))]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// Commands of `sillage`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scene: progress on stderr, results in a run folder
    #[command(after_help = format!(
        "Ctrl-C stops after the current step and keeps what was computed; twice kills.\n\n{EXIT_CODES}"
    ))]
    Run(RunArgs),
    /// Validate a scene without running it
    Check(CheckArgs),
    /// Print which processes, terms and fields a scene needs, and what is left out
    Plan(PlanArgs),
    /// Feed a recording to one engine and compare its answers; without --as, tell what is recorded
    #[command(after_help = format!(
        "With our own engines and the build that recorded, the difference is exactly 0.\n\n{EXIT_CODES}"
    ))]
    Replay(ReplayArgs),
    /// Compare two recordings or run folders
    #[command(after_help = EXIT_CODES)]
    Diff(DiffArgs),
    /// Error against run time: run a scene many times, and write tables and plots
    Study(StudyArgs),
    /// Where each coupling scheme is stable: maps over stiff and extreme cases
    Stability(StabilityArgs),
    /// Show a run in the browser while it goes on, or after it
    View(ViewArgs),
    /// Write one HTML file of a run or a study; it opens without a network
    Report(ReportArgs),
    /// Look at shared memory, limits, versions and leftovers of dead runs
    Doctor(DoctorArgs),
    /// Test whether a command speaks the protocol in a seat: a table of checks
    #[command(after_help = CONFORM_HELP)]
    Conform(ConformArgs),
    /// The process that dies in the checks of `conform`
    #[command(hide = true)]
    ConformCoupler(ConformCouplerArgs),
}

/// A scene with settings.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Scene file (TOML)
    pub scene: PathBuf,
    /// Set a key of the scene, e.g. --set run.end_time=0.5 (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
    /// Threads each engine may use (default: all cores); the built-in particle engine uses one
    #[arg(long, value_name = "N")]
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
    /// Record all that the processes exchange (default FILE: that of the scene, or exchange.mcap)
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub record: Option<String>,
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

/// Arguments of `replay`.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// Recording (.mcap), or a run folder with one
    pub recording: PathBuf,
    /// Which engine is fed
    #[arg(long = "as", value_name = "SEAT", value_enum)]
    pub seat: Option<Seat>,
    /// Command of another engine than the built-in one, e.g. --engine "python3 my_engine.py"
    #[arg(long, value_name = "COMMAND", requires = "seat")]
    pub engine: Option<String>,
    /// Largest difference allowed, of the largest magnitude of each field
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = tolerance, requires = "seat")]
    pub tolerance: f64,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `diff`.
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// Recording (.mcap) or run folder
    pub first: PathBuf,
    /// Another one
    pub second: PathBuf,
    /// Largest difference allowed, of the largest magnitude of each field or column
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = tolerance)]
    pub tolerance: f64,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("must be a number, 0 or more, e.g. 1e-9".to_string()),
    }
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

/// A seat of the coupled system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Seat {
    /// The fluid engine's.
    Fluid,
    /// The particle engine's.
    Particles,
}

impl Seat {
    /// The role of who takes it.
    pub fn role(self) -> Role {
        match self {
            Seat::Fluid => Role::Fluid,
            Seat::Particles => Role::Particles,
        }
    }
}

/// What an engine under test is configured with.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// The seat that the command takes
    #[arg(long = "as", value_enum, value_name = "SEAT")]
    pub seat: Seat,
    /// Configure with this scene's part instead of the built-in one
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// Set a key of the scene (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
    /// Longest wait for anything but an end (s)
    #[arg(long, value_name = "SECONDS", default_value_t = 30.0, value_parser = positive)]
    pub limit: f64,
}

/// Arguments of `conform`.
#[derive(Debug, Args)]
pub struct ConformArgs {
    /// What it is configured with.
    #[command(flatten)]
    pub bench: BenchArgs,
    /// Only this check (repeatable)
    #[arg(long = "check", value_name = "NAME")]
    pub checks: Vec<String>,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// The engine's program and arguments
    #[arg(last = true, required = true, value_name = "COMMAND")]
    pub command: Vec<String>,
}

/// Arguments of `conform-coupler`.
#[derive(Debug, Args)]
pub struct ConformCouplerArgs {
    /// What the engine is configured with.
    #[command(flatten)]
    pub bench: BenchArgs,
    /// What to bring the engine into.
    #[arg(long, value_enum)]
    pub state: crate::conform::deaths::State,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if f64::is_finite(value) && value > 0.0 => Ok(value),
        _ => Err("must be a positive number of seconds".to_owned()),
    }
}
