//! Tables of numbers in CSV: what a run wrote in `steps.csv`, and reference data.

use std::path::Path;

use scene::Error;

/// Columns of numbers with names; an empty cell is NaN.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Names, from the first row.
    pub columns: Vec<String>,
    /// One list of numbers a row, as long as `columns`.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// Read a file; a last row that is still being written is left out.
    pub fn read(path: &Path) -> Result<Table, Error> {
        let text = std::fs::read_to_string(path).map_err(Error::file("cannot read", path))?;
        Table::parse(&text).map_err(|why| Error::Usage(format!("{}: {why}", path.display())))
    }

    /// The same from text. Cells that are no numbers are NaN, so that names may stand beside them.
    pub fn parse(text: &str) -> Result<Table, String> {
        let whole = match text.rfind('\n') {
            Some(end) => &text[..end],
            None => text,
        };
        let mut lines = whole.lines().filter(|line| !line.trim().is_empty());
        let columns: Vec<String> = match lines.next() {
            Some(first) => first.split(',').map(|name| name.trim().into()).collect(),
            None => return Ok(Table::default()),
        };
        let mut rows = Vec::new();
        for (index, line) in lines.enumerate() {
            let row: Vec<f64> = line
                .split(',')
                .map(|cell| cell.trim().parse().unwrap_or(f64::NAN))
                .collect();
            if row.len() != columns.len() {
                return Err(format!(
                    "row {} has {} cells, the first row names {}",
                    index + 2,
                    row.len(),
                    columns.len()
                ));
            }
            rows.push(row);
        }
        Ok(Table { columns, rows })
    }

    /// Place of a column.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// The numbers of a column.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let place = self.place(name)?;
        Some(self.rows.iter().map(|row| row[place]).collect())
    }

    /// The value of `name` where `along` is `at`, by linear interpolation; none outside.
    pub fn at(&self, along: &str, at: f64, name: &str) -> Option<f64> {
        let (x, y) = (self.column(along)?, self.column(name)?);
        let slack = 1e-9 * at.abs();
        let mut before: Option<(f64, f64)> = None;
        for (x, y) in x.into_iter().zip(y) {
            if (x - at).abs() <= slack {
                return Some(y);
            }
            if let Some((x0, y0)) = before
                && x0 < at
                && at < x
            {
                return Some(y0 + (at - x0) / (x - x0) * (y - y0));
            }
            before = Some((x, y));
        }
        None
    }

    /// At most `most` rows, evenly taken, the last one among them.
    pub fn thinned(&self, most: usize) -> Table {
        let rows = spread(self.rows.len(), most)
            .into_iter()
            .map(|index| self.rows[index].clone())
            .collect();
        Table {
            columns: self.columns.clone(),
            rows,
        }
    }
}

/// At most `most` of `count` places, evenly taken, the first and the last among them.
pub fn spread(count: usize, most: usize) -> Vec<usize> {
    if count <= most.max(1) {
        return (0..count).collect();
    }
    if most <= 1 {
        return vec![count - 1];
    }
    (0..most)
        .map(|place| (place * (count - 1) + (most - 1) / 2) / (most - 1))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_and_interpolated() {
        let table = Table::parse("time,v\n0,1\n1,3\n2,\n3,9\n4,").expect("a table");
        assert_eq!(table.rows.len(), 4, "the row without an end is left out");
        assert_eq!(table.at("time", 0.5, "v"), Some(2.0));
        assert_eq!(table.at("time", 3.0, "v"), Some(9.0));
        assert_eq!(table.at("time", 5.0, "v"), None);
        assert!(table.at("time", 2.0, "v").is_some_and(f64::is_nan));
        assert_eq!(table.column("w"), None);
        assert_eq!(table.thinned(2).rows.len(), 2);
    }

    #[test]
    fn a_row_of_another_length_is_refused() {
        let why = Table::parse("a,b\n1,2\n3\n").expect_err("refused");
        assert!(why.contains("row 3 has 1 cells"), "{why}");
    }

    #[test]
    fn places_are_taken_evenly_with_both_ends() {
        assert_eq!(spread(5, 10), [0, 1, 2, 3, 4]);
        assert_eq!(spread(9, 3), [0, 4, 8]);
        assert_eq!(spread(4, 1), [3]);
        assert_eq!(spread(0, 3), [] as [usize; 0]);
        let many = spread(1000, 37);
        assert_eq!((many.len(), many[0], many[36]), (37, 0, 999));
    }
}
