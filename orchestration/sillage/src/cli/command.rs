//! The command line: which commands there are.

use clap::{Parser, Subcommand};

use super::engines::{ConformArgs, ConformCouplerArgs};
use super::help::{CONFORM_HELP, EXAMPLES, EXIT_CODES};
use super::pages::{ReportArgs, StabilityArgs, StudyArgs, ViewArgs};
use super::recordings::{DiffArgs, ReplayArgs};
use super::scenes::{CheckArgs, DoctorArgs, PlanArgs, ResumeArgs, RunArgs};

/// Grains in a fluid, in the plane and in space: a finite-element fluid, non-smooth contacts, and the
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
        "Ctrl-C stops after the current step and keeps what was computed (sillage resume goes on); twice kills.\n\n{EXIT_CODES}"
    ))]
    Run(RunArgs),
    /// Go on with a run that was stopped, failed or killed, from its last checkpoint
    #[command(after_help = format!(
        "The run ends as it would have without an interruption, to the bit. What was put out after the \
         checkpoint is cut off and computed again. With a later --set run.end_time a run that has ended goes \
         on.\n\n{EXIT_CODES}"
    ))]
    Resume(ResumeArgs),
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
