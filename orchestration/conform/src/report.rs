//! What `conform` found: a row a check, as a table or as JSON.

use std::fmt;

use serde_json::{Value, json};

use crate::case::Case;

/// How a check ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// The engine keeps this part of the contract.
    Passed,
    /// It does not; how.
    Failed(String),
    /// The check does not apply or cannot be made; why.
    Skipped(String),
}

/// A check and how it ended.
#[derive(Debug, Clone)]
pub struct Row {
    /// Name of the check.
    pub check: &'static str,
    /// What must be true.
    pub claim: &'static str,
    /// How it ended.
    pub outcome: Outcome,
    /// Wall time \[s\].
    pub seconds: f64,
}

/// All rows of a command.
#[derive(Debug, Clone)]
pub struct Report {
    /// Program and arguments.
    pub command: Vec<String>,
    /// The seat: "fluid" or "particles".
    pub seat: &'static str,
    /// A row a check.
    pub rows: Vec<Row>,
}

impl Report {
    /// Nothing was checked yet.
    pub fn new(case: &Case) -> Report {
        Report {
            command: case.command.clone(),
            seat: case.role.seat(),
            rows: Vec::new(),
        }
    }

    /// Names of the checks that failed.
    pub fn failed(&self) -> Vec<&'static str> {
        let failed = |row: &&Row| matches!(row.outcome, Outcome::Failed(_));
        self.rows
            .iter()
            .filter(failed)
            .map(|row| row.check)
            .collect()
    }

    /// Numbers of checks passed, failed and skipped.
    pub fn counts(&self) -> [usize; 3] {
        let mut counts = [0; 3];
        for row in &self.rows {
            counts[match row.outcome {
                Outcome::Passed => 0,
                Outcome::Failed(_) => 1,
                Outcome::Skipped(_) => 2,
            }] += 1;
        }
        counts
    }

    /// 0: nothing failed; 1: something did.
    pub fn exit_code(&self) -> i32 {
        i32::from(!self.failed().is_empty())
    }

    /// One line: how many of each.
    pub fn summary(&self) -> String {
        let [passed, failed, skipped] = self.counts();
        let verdict = if failed == 0 {
            "conforms"
        } else {
            "does not conform"
        };
        format!(
            "{} {verdict} as {}: {passed} passed, {failed} failed, {skipped} skipped",
            self.command.join(" "),
            self.seat
        )
    }

    /// The document of `--json`.
    pub fn document(&self) -> Value {
        let [passed, failed, skipped] = self.counts();
        let rows: Vec<Value> = self.rows.iter().map(Row::document).collect();
        json!({
            "ok": failed == 0, "code": self.exit_code(),
            "command": self.command, "as": self.seat,
            "passed": passed, "failed": failed, "skipped": skipped, "checks": rows,
        })
    }
}

impl Row {
    fn parts(&self) -> (&'static str, Option<&str>) {
        match &self.outcome {
            Outcome::Passed => ("passed", None),
            Outcome::Failed(why) => ("FAILED", Some(why)),
            Outcome::Skipped(why) => ("skipped", Some(why)),
        }
    }

    fn document(&self) -> Value {
        let (result, why) = self.parts();
        json!({
            "check": self.check, "claim": self.claim, "result": result.to_lowercase(),
            "why": why, "seconds": self.seconds,
        })
    }
}

impl fmt::Display for Row {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (result, why) = self.parts();
        let claim = self.claim;
        write!(out, "{:<24} {result:<8} ", self.check)?;
        match (&self.outcome, why) {
            // What it would have said does not matter then.
            (Outcome::Skipped(why), _) => write!(out, "{why}"),
            (_, Some(why)) => write!(out, "{claim}\n{:34}{why}", ""),
            (_, None) => write!(out, "{claim}"),
        }
    }
}
