//! `conform`, and the process that dies in its checks.

use conform::case::Case;
use conform::checks;
use scene::Error;

use crate::cli::engines::{BenchArgs, ConformArgs, ConformCouplerArgs};
use crate::say;

/// Test a command: rows on stdout as they are known, unless one document is asked for.
pub fn conform(args: &ConformArgs) -> Result<i32, Error> {
    let case = case(&args.bench, args.command.clone())?;
    let report = checks::run(&case, &args.checks, |row| match args.json {
        true => Ok(()),
        false => say!("{row}"),
    })?;
    match args.json {
        true => say!("{:#}", report.document())?,
        false => say!("{}", report.summary())?,
    }
    Ok(report.exit_code())
}

/// The process that dies.
pub fn die_as_coupler(args: &ConformCouplerArgs) -> Result<i32, Error> {
    checks::deaths::play_coupler(&case(&args.bench, Vec::new())?, args.state)?;
    Ok(0)
}

fn case(bench: &BenchArgs, command: Vec<String>) -> Result<Case, Error> {
    let (scene, settings) = (bench.scene.clone(), bench.settings.clone());
    Case::new(bench.seat.role(), command, scene, settings, bench.limit)
}
