//! `steps.csv`, a row a step, and what is summed up from it.

use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::PathBuf;

use protocol::message::Diagnostic;
use protocol::monitor::columns::{self, Kind};
use scene::Error;
use serde::{Deserialize, Serialize};

use crate::disk::Disk;

/// The table of the steps.
pub struct Steps {
    path: PathBuf,
    kind: Kind,
    file: File,
    table: Table,
}

/// What is in it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Table {
    /// Bytes of whole rows.
    length: u64,
    columns: Vec<String>,
    /// Sums and extremes so far.
    pub summary: Summary,
}

/// Sums and extremes over the steps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Steps accepted.
    pub steps: u64,
    /// Time reached \[s\].
    pub time: f64,
    /// Sums: wall and CPU seconds, passes, sub-steps.
    pub sums: BTreeMap<String, f64>,
    /// Largest defects, residuals and penetrations; smallest porosity.
    pub worst: BTreeMap<String, f64>,
    /// Parts that some steps may do without.
    pub left_out: Vec<LeftOut>,
}

/// A part that was not there in some steps.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOut {
    /// What.
    pub part: String,
    /// Steps without it.
    pub steps_without: u64,
    /// The first step with it; none: no step needed it.
    pub first_step_with: Option<u64>,
}

/// Columns that are 0 in a step that did without a part.
const PARTS: [(&str, &str); 3] = [
    (columns::CONVECTION, "convection"),
    (columns::CONTACT_CANDIDATES, "contacts"),
    (columns::CONTACT_WALL_LOOKS, "walls"),
];

/// Counters whose sum over the steps says something, beside the columns of cost.
const SUMMED: [&str; 5] = [
    columns::PASSES,
    columns::SUB_STEPS,
    columns::CONTACT_SEARCHES,
    columns::CONTACT_SWEEPS,
    columns::CONTACT_WALL_LOOKS,
];

impl Steps {
    /// An empty table; the first row names the columns, and their units go to a file beside it.
    pub fn create(path: PathBuf, kind: Kind) -> Result<Self, Error> {
        let file = File::create(&path).map_err(Error::file("cannot write", &path))?;
        Ok(Steps {
            path,
            kind,
            file,
            table: Table::default(),
        })
    }

    /// The table up to where it was kept; rows after that are cut off.
    pub fn resume(path: PathBuf, kind: Kind, table: Table) -> Result<Self, Error> {
        let file = File::options().write(true).open(&path);
        let file = file.map_err(Error::file("cannot write", &path))?;
        let length = file
            .metadata()
            .map_err(Error::file("cannot read", &path))?
            .len();
        if length < table.length {
            return Err(Error::Usage(format!(
                "{} has {length} bytes, at the checkpoint it had {}: it has been cut since",
                path.display(),
                table.length
            )));
        }
        file.set_len(table.length)
            .map_err(Error::file("cannot cut", &path))?;
        Ok(Steps {
            path,
            kind,
            file,
            table,
        })
    }

    /// What is in it.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Wait until its rows are on the disk.
    pub fn sync(&self) -> Result<(), Error> {
        let synced = self.file.sync_all();
        synced.map_err(Error::file("cannot bring to the disk", &self.path))
    }

    /// Add a row. A step that lacks a column leaves it empty; one that the first step lacked is
    /// only summed up.
    pub fn add(&mut self, values: &[Diagnostic], disk: &Disk) -> Result<(), Error> {
        let mut text = String::new();
        if self.table.columns.is_empty() {
            self.table.columns = values.iter().map(|value| value.name.clone()).collect();
            text = self.table.columns.join(",") + "\n";
            self.write_units(disk)?;
        }
        let row: Vec<String> = self
            .table
            .columns
            .iter()
            .map(|name| {
                let found = values.iter().find(|value| value.name == *name);
                found.map_or(String::new(), |found| number(name, found.value))
            })
            .collect();
        text += &(row.join(",") + "\n");
        // In one piece: whoever looks at a running computation sees whole rows.
        disk.attempt(|| {
            self.require_place()?;
            let written = self.file.write_all_at(text.as_bytes(), self.table.length);
            written.map_err(|error| {
                // Half a row must not stay.
                let _ = self.file.set_len(self.table.length);
                Error::file("cannot write", &self.path)(error)
            })
        })?;
        self.table.length += text.len() as u64;
        self.table.summary.add(values);
        Ok(())
    }
}

impl Steps {
    /// Is the table still where it was made? What is written to a file that was removed is lost without a word.
    fn require_place(&self) -> Result<(), Error> {
        let refuse = Error::file("cannot write", &self.path);
        let same = std::fs::symlink_metadata(&self.path)
            .and_then(|there| Ok(there.ino() == self.file.metadata()?.ino()));
        match same {
            Ok(true) => Ok(()),
            Ok(false) => Err(refuse(std::io::Error::other("another file has its place"))),
            Err(error) => Err(refuse(error)),
        }
    }

    /// `steps.units.csv`: column and unit; "–" where there is none, nothing where only the engine knows.
    fn write_units(&self, disk: &Disk) -> Result<(), Error> {
        let unit = |name: &String| {
            let unit = columns::unit(name, self.kind).unwrap_or_default();
            format!("{name},{unit}\n")
        };
        let rows: String = self.table.columns.iter().map(unit).collect();
        let units = self.path.with_extension("units.csv");
        disk.write(&units, format!("column,unit\n{rows}"))
    }
}

/// Counters without, all else with exponent; both read back to the same bits.
fn number(name: &str, value: f64) -> String {
    match columns::is_count(name) {
        true => format!("{value}"),
        false => format!("{value:e}"),
    }
}

impl Summary {
    fn add(&mut self, values: &[Diagnostic]) {
        self.steps += 1;
        for Diagnostic { name, value } in values {
            if let Some((_, part)) = PARTS.iter().find(|(column, _)| column == name) {
                self.note(part, *value != 0.0);
            }
            let kept = |table: &mut BTreeMap<String, f64>, pick: fn(f64, f64) -> f64| {
                let entry = table.entry(name.clone()).or_insert(*value);
                *entry = pick(*entry, *value);
            };
            match name.as_str() {
                columns::TIME => self.time = *value,
                name if SUMMED.contains(&name) || columns::is_cost(name) => {
                    *self.sums.entry(name.to_owned()).or_default() += value
                }
                columns::CONTACT_RESIDUAL | columns::CONTACT_SINKING | columns::PENETRATION_MAX => {
                    kept(&mut self.worst, larger)
                }
                columns::POROSITY_MIN => kept(&mut self.worst, f64::min),
                name if name.ends_with(columns::DEFECT) => kept(&mut self.worst, larger),
                _ => {}
            }
        }
    }
}

impl Summary {
    /// Was a part there in this step?
    fn note(&mut self, part: &str, there: bool) {
        let step = self.steps;
        let place = self.left_out.iter().position(|known| known.part == part);
        let place = place.unwrap_or_else(|| {
            self.left_out.push(LeftOut {
                part: part.to_owned(),
                steps_without: 0,
                first_step_with: None,
            });
            self.left_out.len() - 1
        });
        let known = &mut self.left_out[place];
        match there {
            true => _ = known.first_step_with.get_or_insert(step),
            false => known.steps_without += 1,
        }
    }
}

/// The one with the larger absolute value.
fn larger(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}
