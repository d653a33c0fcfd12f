//! `sillage`: the command line. Commands live in the library; here they are called.

use std::io::IsTerminal;

use clap::Parser;
use orchestration::cli::{CheckArgs, Cli, Command, ConformArgs, DoctorArgs, PlanArgs, RunArgs};
use orchestration::conform;
use orchestration::error::Error;
use orchestration::{
    diff, doctor, plan, record, replay, report as pages, run, say, scene, stability, study, view,
};
use serde_json::json;

fn main() {
    tracing_subscriber::fmt()
        .with_env_filter(
            tracing_subscriber::EnvFilter::try_from_env("SILLAGE_LOG")
                .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("warn")),
        )
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none())
        .init();
    let (wants_json, outcome) = match Cli::parse().command {
        Command::Check(args) => (args.json, check(&args)),
        Command::Plan(args) => (args.json, show_plan(&args)),
        Command::Run(args) => (args.json, run_scene(&args)),
        Command::Replay(args) => (args.json, replay::command(&args)),
        Command::Diff(args) => (args.json, diff::command(&args)),
        Command::Study(args) => (args.json, study::command(&args)),
        Command::Stability(args) => (args.json, stability::command(&args)),
        Command::View(args) => (args.json, view::command(&args)),
        Command::Report(args) => (args.json, pages::command(&args)),
        Command::Doctor(args) => (args.json, examine(&args)),
        Command::Conform(args) => (args.json, conform_command(&args)),
        Command::ConformCoupler(args) => (false, conform::die_as_coupler(&args)),
    };
    if let Err(error) = outcome {
        // A comparison has told its result already.
        if !matches!(error, Error::Different) {
            report(&error, wants_json);
        }
        std::process::exit(error.exit_code());
    }
}

/// An error on stderr, and as JSON on stdout when asked for.
fn report(error: &Error, wants_json: bool) {
    eprintln!("sillage: {error}");
    if wants_json {
        let mut document =
            json!({ "ok": false, "code": error.exit_code(), "error": error.to_string() });
        if let Error::Scene(problems) = error {
            document["problems"] = json!(problems.0);
        }
        say!("{document:#}");
    }
}

fn check(args: &CheckArgs) -> Result<(), Error> {
    let Some(path) = &args.scene else {
        say!("{:#}", scene::schema::scene_schema());
        return Ok(());
    };
    let scene = scene::load(path, &args.settings, 1)?;
    for warning in &scene.warnings {
        eprintln!("{}: warning: {warning}", path.display());
    }
    let grains = scene.grains.len();
    if args.json {
        let document = json!({ "ok": true, "scene": scene.name, "grains": grains, "warnings": scene.warnings });
        say!("{document:#}");
    } else {
        let plural = if grains == 1 { "" } else { "s" };
        say!("{}: ok, {grains} grain{plural}", path.display());
    }
    Ok(())
}

fn show_plan(args: &PlanArgs) -> Result<(), Error> {
    let scene = scene::load(
        &args.scene.scene,
        &args.scene.settings,
        args.scene.threads(),
    )?;
    let plan = plan::plan(&scene);
    if let Some(folder) = &args.out {
        plan::write_inputs(&scene, folder)?;
    }
    if args.json {
        say!("{:#}", json!(plan));
    } else {
        say!("{plan}");
    }
    Ok(())
}

fn run_scene(args: &RunArgs) -> Result<(), Error> {
    let mut scene = scene::load(
        &args.scene.scene,
        &args.scene.settings,
        args.scene.threads(),
    )?;
    for warning in &scene.warnings {
        eprintln!("{}: warning: {warning}", args.scene.scene.display());
    }
    if let Some(file) = &args.record {
        record::request(&mut scene, file)?;
    }
    let outcome = run::run(&scene, args.out.as_deref())?;
    let (ending, folder) = (&outcome.ending, outcome.folder.display());
    if args.json {
        say!("{:#}", outcome.document);
    } else {
        let steps = &outcome.document["steps"];
        say!("{folder}: {steps} steps in {:.1} s", ending.wall);
    }
    match &ending.why {
        None => Ok(()),
        Some(why) => {
            // The document is on stdout already; main adds none.
            eprintln!("sillage: {why}");
            std::process::exit(ending.code);
        }
    }
}

fn examine(args: &DoctorArgs) -> Result<(), Error> {
    let findings = doctor::examine(args.clean)?;
    if args.json {
        say!("{:#}", json!(findings));
    } else {
        say!("{findings}");
    }
    Ok(())
}

fn conform_command(args: &ConformArgs) -> Result<(), Error> {
    let report = conform::command(args)?;
    if args.json {
        say!("{:#}", report.document());
    } else {
        say!("{}", report.summary());
    }
    match report.exit_code() {
        0 => Ok(()),
        code => std::process::exit(code),
    }
}
