//! `report` and `view`.

use run::interrupt::Interrupts;
use scene::Error;
use scene::error::exit_code;
use serde_json::json;
use show::page::{self, View};

use crate::cli::pages::{ReportArgs, ViewArgs};
use crate::say;

/// Write the page of a run or a study.
pub fn report(args: &ReportArgs) -> Result<i32, Error> {
    let written = page::write(&args.folder, args.out.as_deref(), args.states as usize)?;
    let file = written.file.display();
    if args.json {
        let document = json!({ "ok": true, "file": written.file, "bytes": written.bytes, "states": written.states });
        say!("{document:#}")?;
    } else {
        let megabytes = written.bytes as f64 / 1e6;
        say!("{file}: {} states, {megabytes:.1} MB", written.states)?;
    }
    Ok(exit_code::OK)
}

/// Serve the page until Ctrl-C.
pub fn view(args: &ViewArgs) -> Result<i32, Error> {
    let interrupts = Interrupts::count()?;
    let mut view = View::open(&args.folder, args.port)?;
    let address = view.address();
    if args.json {
        say!("{:#}", json!({ "ok": true, "address": address }))?;
    } else {
        say!("{address}   (Ctrl-C ends)")?;
    }
    view.serve(&interrupts)?;
    Ok(exit_code::OK)
}
