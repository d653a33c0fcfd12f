//! `sillage conform`: does a command speak the protocol? Each check starts a fresh process of it in
//! a run of its own and plays the coupler, well or badly.
//!
//! | file | what |
//! | --- | --- |
//! | `case` | what the engine is configured with and the inputs it is given |
//! | `subject`, `bench` | a process of the command; the coupler's end of its link |
//! | `exchange` | hello, shapes, finiteness, finish |
//! | `states` | what a second `Advance`, a commit and a checkpoint do to the bits |
//! | `order`, `refusals` | messages and fields that must be refused |
//! | `deaths` | the coupler ends in each state of the engine |

mod bench;
pub mod case;
pub mod deaths;
mod exchange;
mod order;
mod refusals;
mod report;
mod states;
mod subject;

use std::time::Instant;

use protocol::messages::Role;

use crate::cli::{BenchArgs, ConformArgs, ConformCouplerArgs};
use crate::error::Error;
use crate::say;
use case::Case;
pub use report::{Outcome, Report, Row};

/// Why a check did not pass.
#[derive(Debug, Clone, PartialEq)]
pub enum Trouble {
    /// The engine breaks the contract; how.
    Broken(String),
    /// The check does not apply; why.
    Skipped(String),
}

impl From<String> for Trouble {
    fn from(why: String) -> Trouble {
        Trouble::Broken(why)
    }
}

/// Checks that must have passed for a check to say anything.
type Needs = &'static [&'static str];
const NOTHING: Needs = &[];
const HELLO: Needs = &["hello"];
const READY: Needs = &["hello", "ready"];
const ANSWERS: Needs = &["hello", "ready", "advance"];
/// Two processes given the same must answer the same.
const REPEATABLE: Needs = &["hello", "ready", "advance", "fresh-process"];

/// A check of the suite.
struct Check {
    name: &'static str,
    /// What must be true.
    claim: &'static str,
    needs: Needs,
    /// Only for this role.
    only: Option<Role>,
    run: fn(&Case) -> Result<(), Trouble>,
}

impl Check {
    const fn new(
        name: &'static str,
        claim: &'static str,
        needs: Needs,
        run: fn(&Case) -> Result<(), Trouble>,
    ) -> Check {
        let only = None;
        Check {
            name,
            claim,
            needs,
            only,
            run,
        }
    }

    const fn only(self, role: Role) -> Check {
        Check {
            only: Some(role),
            ..self
        }
    }
}

fn suite() -> impl Iterator<Item = &'static Check> {
    exchange::CHECKS
        .iter()
        .chain(states::CHECKS)
        .chain(order::CHECKS)
        .chain(refusals::CHECKS)
        .chain(deaths::CHECKS)
}

/// `sillage conform`: rows on stdout as they are known, unless one document is asked for.
pub fn command(args: &ConformArgs) -> Result<Report, Error> {
    let case = case(&args.bench, args.command.clone())?;
    run(&case, &args.checks, |row| {
        if !args.json {
            say!("{row}");
        }
    })
}

/// `sillage conform-coupler`.
pub fn die_as_coupler(args: &ConformCouplerArgs) -> Result<(), Error> {
    deaths::play_coupler(&case(&args.bench, Vec::new())?, args.state)
}

fn case(bench: &BenchArgs, command: Vec<String>) -> Result<Case, Error> {
    let (scene, settings) = (bench.scene.clone(), bench.settings.clone());
    Case::new(bench.seat.role(), command, scene, settings, bench.limit)
}

/// Run the suite, or the checks named in `wanted`; `shown` sees each row when it is known.
pub fn run(case: &Case, wanted: &[String], mut shown: impl FnMut(&Row)) -> Result<Report, Error> {
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
    drop(subject::Subject::start(&case.command, &[])?);
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
        shown(&row);
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
