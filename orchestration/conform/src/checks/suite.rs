//! All checks, in the order in which they build on each other.

use std::time::Instant;

use scene::Error;

use super::{deaths, exchange, meshes, order, refusals, states};
use crate::case::Case;
use crate::check::{Check, Needs, Trouble};
use crate::report::{Outcome, Report, Row};
use crate::subject::Subject;

fn suite() -> impl Iterator<Item = &'static Check> {
    exchange::CHECKS
        .iter()
        .chain(states::CHECKS)
        .chain(meshes::CHECKS)
        .chain(order::CHECKS)
        .chain(refusals::CHECKS)
        .chain(deaths::CHECKS)
}

/// Run the suite, or the checks named in `wanted`; `shown` sees each row when it is known.
pub fn run(
    case: &Case,
    wanted: &[String],
    mut shown: impl FnMut(&Row) -> Result<(), Error>,
) -> Result<Report, Error> {
    if let Some(unknown) = wanted
        .iter()
        .find(|name| !suite().any(|check| check.name == **name))
    {
        let names: Vec<&str> = suite().map(|check| check.name).collect();
        return Err(Error::Usage(format!(
            "--check {unknown}: there is no such check; there are {}",
            names.join(", ")
        )));
    }
    // A command that cannot be started is no engine that failed.
    drop(Subject::start(&case.command, &[])?);
    let mut report = Report::new(case);
    for check in suite() {
        let asked = wanted.is_empty() || wanted.iter().any(|name| name == check.name);
        if !asked || check.only.is_some_and(|role| role != case.role) {
            continue;
        }
        let begin = Instant::now();
        let outcome = match missing(check.needs, &report) {
            Some(name) => Outcome::Skipped(format!("{name} did not pass")),
            None => match (check.run)(case) {
                Ok(()) => Outcome::Passed,
                Err(Trouble::Broken(why)) => Outcome::Failed(why),
                Err(Trouble::Skipped(why)) => Outcome::Skipped(why),
            },
        };
        let row = Row {
            check: check.name,
            claim: check.claim,
            outcome,
            seconds: begin.elapsed().as_secs_f64(),
        };
        shown(&row)?;
        report.rows.push(row);
    }
    Ok(report)
}

/// The check that a check builds on and that did not pass.
fn missing(needs: Needs, report: &Report) -> Option<&'static str> {
    let not_passed =
        |row: &&Row| needs.contains(&row.check) && !matches!(row.outcome, Outcome::Passed);
    report.rows.iter().find(not_passed).map(|row| row.check)
}
