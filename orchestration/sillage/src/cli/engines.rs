//! Arguments of the commands that test an engine.

use std::path::PathBuf;

use clap::Args;
use conform::checks::deaths::State;

use super::seat::Seat;

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
    #[arg(long, value_parser = state)]
    pub state: State,
}

fn state(text: &str) -> Result<State, String> {
    let known = State::ALL.into_iter().find(|state| state.name() == text);
    known.ok_or_else(|| format!("there is no state {text}"))
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if f64::is_finite(value) && value > 0.0 => Ok(value),
        _ => Err("must be a positive number of seconds".to_owned()),
    }
}
