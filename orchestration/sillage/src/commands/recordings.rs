//! `replay` and `diff`.

use conform::replay;
use recording::Reader;
use run::folder::recorded::find;
use scene::Error;
use scene::error::exit_code;
use serde_json::json;

use crate::cli::recordings::{DiffArgs, ReplayArgs};
use crate::say;

/// Feed a recording to an engine and compare, or tell what is recorded.
pub fn replay(args: &ReplayArgs) -> Result<i32, Error> {
    let path = find(&args.recording)?;
    let mut reader = Reader::open(&path)?;
    let Some(seat) = args.seat else {
        return tell(&mut reader, args.json);
    };
    let report = replay::replay(&mut reader, seat.role(), args.engine.as_deref())?;
    let within = report.within(args.tolerance);
    let warning = reader.ending().warning();
    if args.json {
        let fields: serde_json::Map<String, serde_json::Value> = report
            .fields
            .iter()
            .map(|(name, row)| (name.clone(), row.to_json(args.tolerance)))
            .collect();
        let document = json!({
            "ok": within,
            "tolerance": args.tolerance,
            "seat": seat.role().seat(),
            "steps": report.steps,
            "answers": report.answers,
            "recorded": report.recorded,
            "replayed": report.replayed,
            "stopped": report.stopped,
            "not_compared": report.left_out,
            "complete": warning.is_none(),
            "fields": fields,
        });
        say!("{document:#}")?;
    } else {
        if let Some(commit) = &reader.begin().commit {
            say!("recorded by the programs of commit {commit}")?;
        }
        say!("{}", replay::text(&report, args.tolerance))?;
    }
    if let Some(warning) = warning {
        run::tell!("sillage: warning: {}: {warning}", path.display());
    }
    Ok(verdict(within))
}

/// What is recorded.
fn tell(reader: &mut Reader, as_json: bool) -> Result<i32, Error> {
    let summary = recording::summary(reader)?;
    if as_json {
        let document = json!({
            "ok": true,
            "begin": reader.begin(),
            "complete": reader.ending().warning().is_none(),
            "summary": summary.lines().collect::<Vec<_>>(),
        });
        say!("{document:#}")?;
    } else {
        say!("{summary}")?;
    }
    Ok(exit_code::OK)
}

/// Compare two recordings or run folders.
pub fn diff(args: &DiffArgs) -> Result<i32, Error> {
    let comparison = show::diff::compare(&args.first, &args.second, args.tolerance)?;
    if args.json {
        say!("{:#}", comparison.document())?;
    } else {
        for table in comparison.tables() {
            say!("{table}")?;
        }
    }
    Ok(verdict(comparison.within()))
}

fn verdict(within: bool) -> i32 {
    match within {
        true => exit_code::OK,
        false => exit_code::DIFFERENT,
    }
}
