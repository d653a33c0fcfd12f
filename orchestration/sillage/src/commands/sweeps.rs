//! `study` and `stability`: many runs each.

use std::time::Instant;

use scene::Error;
use scene::error::exit_code;
use serde_json::json;

use crate::cli::pages::{StabilityArgs, StudyArgs};
use crate::say;

/// Run a study, or name the built-in ones.
pub fn study(args: &StudyArgs) -> Result<i32, Error> {
    let Some(path) = &args.study else {
        return list_studies(args.json);
    };
    let outcome = study::study(path, args.out.as_deref(), args.threads.get())?;
    if args.json {
        say!("{:#}", outcome.document)?;
    } else {
        let page = outcome.folder.join("report.html");
        say!("{}{}", outcome.table, page.display())?;
    }
    let failed = outcome.failed;
    Ok(ending(outcome.interrupted, || {
        let why = format!("the runs of {failed} points failed; the table says why");
        (failed > 0).then_some((exit_code::ENGINE, why))
    }))
}

fn list_studies(as_json: bool) -> Result<i32, Error> {
    let studies = study::list()?;
    if as_json {
        let list: Vec<_> = studies
            .iter()
            .map(|(name, title)| json!({ "name": name, "title": title }))
            .collect();
        say!("{:#}", json!(list))?;
    } else {
        for (name, title) in studies {
            say!("{name:<16} {title}")?;
        }
    }
    Ok(exit_code::OK)
}

/// Run the maps of the coupling schemes, or list them.
pub fn stability(args: &StabilityArgs) -> Result<i32, Error> {
    let maps = stability::chosen(args.dimension, &args.axes)?;
    if args.list {
        return list_maps(&maps, args.json);
    }
    let begun = Instant::now();
    let out = args.out();
    let outcome = stability::stability(&maps, args.quick, &out, args.jobs())?;
    if args.json {
        say!("{:#}", outcome.document)?;
    } else {
        let (seconds, folder) = (begun.elapsed().as_secs_f64(), out.display());
        say!("{}", outcome.text)?;
        say!("{} cells in {seconds:.0} s → {folder}", outcome.cells)?;
    }
    let failed = outcome.failed;
    Ok(ending(outcome.interrupted, || {
        let why = format!("the default scheme fails in {failed} cells; the table says how");
        (failed > 0).then_some((exit_code::DIFFERENT, why))
    }))
}

fn list_maps(maps: &[stability::maps::Map], as_json: bool) -> Result<i32, Error> {
    if as_json {
        say!("{:#}", stability::list(maps))?;
        return Ok(exit_code::OK);
    }
    for map in maps {
        let (across, up) = (map.across.name, map.up.name);
        say!("{:<19} {across} × {up}: {}", map.name, map.title)?;
    }
    Ok(exit_code::OK)
}

/// How many runs ended: their document is on stdout already, so why they ended early is said here.
fn ending(interrupted: bool, failure: impl FnOnce() -> Option<(i32, String)>) -> i32 {
    let kept = "interrupted: what was run is kept".to_string();
    let early = match interrupted {
        true => Some((exit_code::INTERRUPTED, kept)),
        false => failure(),
    };
    let Some((code, why)) = early else {
        return exit_code::OK;
    };
    run::tell!("sillage: {why}");
    code
}
