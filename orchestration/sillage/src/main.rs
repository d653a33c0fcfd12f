//! `sillage`: the command line. What commands do is in the crates beside this one; here they are
//! called, and here the process ends.

mod cli;
mod commands;
mod say;

use clap::Parser;
use cli::command::{Cli, Command};
use commands::{engines, pages, recordings, scenes, sweeps};
use scene::Error;
use serde_json::json;

fn main() {
    protocol::process::log_through(run::tell::told, "warn");
    let (wants_json, outcome) = match Cli::parse().command {
        Command::Check(args) => (args.json, scenes::check(&args)),
        Command::Plan(args) => (args.json, scenes::plan(&args)),
        Command::Run(args) => (args.json, scenes::run(&args)),
        Command::Resume(args) => (args.json, scenes::resume(&args)),
        Command::Replay(args) => (args.json, recordings::replay(&args)),
        Command::Diff(args) => (args.json, recordings::diff(&args)),
        Command::Study(args) => (args.json, sweeps::study(&args)),
        Command::Stability(args) => (args.json, sweeps::stability(&args)),
        Command::View(args) => (args.json, pages::view(&args)),
        Command::Report(args) => (args.json, pages::report(&args)),
        Command::Doctor(args) => (args.json, scenes::doctor(&args)),
        Command::Conform(args) => (args.json, engines::conform(&args)),
        Command::ConformCoupler(args) => (false, engines::die_as_coupler(&args)),
    };
    let code = outcome.unwrap_or_else(|error| {
        tell(&error, wants_json);
        error.exit_code()
    });
    run::tell::finish();
    std::process::exit(code);
}

/// An error on stderr, and as JSON on stdout when asked for.
fn tell(error: &Error, wants_json: bool) {
    run::tell!("sillage: {error}");
    if wants_json {
        let mut document =
            json!({ "ok": false, "code": error.exit_code(), "error": error.to_string() });
        if let Error::Scene(problems) = error {
            document["problems"] = json!(problems.0);
        }
        // A stdout that cannot be written to may be the error that is told.
        let _ = say!("{document:#}");
    }
}
