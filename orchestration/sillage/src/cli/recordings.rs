//! Arguments of the commands that take recordings.

use std::path::PathBuf;

use clap::Args;

use super::seat::Seat;

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
