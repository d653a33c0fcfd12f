//! Reference tables: numbers that this project did not choose (`reference/README.md`).

/// Rows of a reference table as text, without its header.
pub fn rows(name: &str) -> Vec<Vec<String>> {
    let path = format!("{}/reference/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    text.lines()
        .skip(1)
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect()
}

/// A number of a row.
pub fn number(row: &[String], column: usize) -> f64 {
    row[column]
        .trim()
        .parse()
        .unwrap_or_else(|error| panic!("column {column} of {row:?}: {error}"))
}
