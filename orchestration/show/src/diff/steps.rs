//! Differences of two `steps.csv`, column by column; wall and CPU times are left out.

use std::collections::BTreeMap;
use std::path::Path;

use protocol::monitor::columns;
use recording::Key;
use recording::compare::Difference;

use scene::Error;
use serde_json::{Value, json};

/// Differences of two tables of steps.
#[derive(Debug, Clone, Default)]
pub struct Columns {
    /// Rows of both.
    pub rows: [usize; 2],
    /// By name of the column.
    pub columns: BTreeMap<String, Difference>,
    /// Columns that only one of them has.
    pub only_in_one: Vec<String>,
}

impl Columns {
    /// As many rows, the same columns, all within the tolerance?
    pub fn within(&self, tolerance: f64) -> bool {
        self.rows[0] == self.rows[1]
            && self.only_in_one.is_empty()
            && self.columns.values().all(|row| row.within(tolerance))
    }

    /// A row a column that differs, and how many do not.
    pub fn text(&self, tolerance: f64) -> String {
        let [one, other] = self.rows;
        let mut text = if one == other {
            format!("{one} steps in both\n")
        } else {
            format!(
                "{one} and {other} steps: OUTSIDE; the first {} are compared\n",
                one.min(other)
            )
        };
        let differing = self.columns.iter().filter(|(_, row)| row.unequal > 0);
        let width = self.columns.keys().map(String::len).max().unwrap_or(0);
        for (name, row) in differing.clone() {
            let place = row.place.map_or(String::new(), |place| {
                format!(
                    "  step {}: {:e} and {:e}",
                    place.step, place.first, place.second
                )
            });
            let verdict = if row.within(tolerance) {
                ""
            } else {
                "  OUTSIDE"
            };
            text += &format!(
                "{name:width$}  max {:.3e}  rms {:.3e}  of largest {:.3e}{place}{verdict}\n",
                row.max,
                row.rms,
                row.relative()
            );
        }
        let same = self.columns.len() - differing.count();
        text += &format!("{same} columns are equal to the bit\n");
        for name in &self.only_in_one {
            text += &format!("{name}: only in one of them, OUTSIDE\n");
        }
        text
    }

    /// As JSON.
    pub fn to_json(&self, tolerance: f64) -> Value {
        let columns: serde_json::Map<String, Value> = self
            .columns
            .iter()
            .map(|(name, row)| (name.clone(), row.to_json(tolerance)))
            .collect();
        json!({ "rows": self.rows, "columns": columns, "only_in_one": self.only_in_one })
    }
}

/// Compare the steps of two run folders.
pub fn diff(first: &Path, second: &Path) -> Result<Columns, Error> {
    let (first, second) = (Table::read(first)?, Table::read(second)?);
    let mut columns = Columns {
        rows: [first.rows, second.rows],
        ..Columns::default()
    };
    for (name, one) in &first.columns {
        match second.columns.get(name) {
            None => columns.only_in_one.push(name.clone()),
            Some(other) => {
                let row = columns.columns.entry(name.clone()).or_default();
                for (step, (a, b)) in one.iter().zip(other).enumerate() {
                    let key = Key {
                        step: step as u64 + 1,
                        ..Key::default()
                    };
                    // One number each: lengths cannot differ.
                    let _ = row.add(key, 1, &[*a], &[*b]);
                }
            }
        }
    }
    let absent = second
        .columns
        .keys()
        .filter(|name| !first.columns.contains_key(*name));
    columns.only_in_one.extend(absent.cloned());
    Ok(columns)
}

struct Table {
    rows: usize,
    columns: BTreeMap<String, Vec<f64>>,
}

impl Table {
    /// A cell that is empty is not a number, and equal to another empty one.
    fn read(folder: &Path) -> Result<Table, Error> {
        let path = folder.join("steps.csv");
        let text = std::fs::read_to_string(&path)
            .map_err(|error| Error::Usage(format!("cannot read {}: {error}", path.display())))?;
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let mut table = Table {
            rows: 0,
            columns: BTreeMap::new(),
        };
        for (number, line) in lines.enumerate() {
            table.rows += 1;
            let cells: Vec<&str> = line.split(',').collect();
            let refuse =
                |why: String| Error::Usage(format!("{}:{}: {why}", path.display(), number + 2));
            if cells.len() != names.len() {
                let why = format!("{} cells, {} columns are named", cells.len(), names.len());
                return Err(refuse(why));
            }
            let compared = names.iter().zip(cells);
            for (name, cell) in compared.filter(|(name, _)| !columns::is_cost(name)) {
                let value = match cell {
                    "" => f64::NAN,
                    cell => cell
                        .parse()
                        .map_err(|_| refuse(format!("{name} is `{cell}`, not a number")))?,
                };
                table
                    .columns
                    .entry((*name).to_string())
                    .or_default()
                    .push(value);
            }
        }
        Ok(table)
    }
}
