//! `sillage report`: one HTML file of a run or a study that opens without a network.
//!
//! The page is `page.html`, `page.css` and `page.js`; what it shows is one JSON document inside
//! it. `sillage view` serves the same page, which then asks for the document and for each state.

pub mod encode;
pub mod series;
pub mod states;

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::cli::ReportArgs;
use crate::error::Error;
use crate::output::vtu;
use crate::say;
use crate::study::results;
use crate::table::Table;
use states::Reader;

/// Rows of `steps.csv` that the page draws at most.
const ROWS: usize = 1500;

/// A report that was written.
pub struct Written {
    /// The file.
    pub file: PathBuf,
    /// Its size \[bytes\].
    pub bytes: usize,
    /// States in its animation.
    pub states: usize,
}

/// `sillage report`.
pub fn command(args: &ReportArgs) -> Result<(), Error> {
    let written = write(&args.folder, args.out.as_deref(), args.states as usize)?;
    let file = written.file.display();
    if args.json {
        let document = json!({ "ok": true, "file": written.file, "bytes": written.bytes, "states": written.states });
        say!("{document:#}");
    } else {
        let megabytes = written.bytes as f64 / 1e6;
        say!("{file}: {} states, {megabytes:.1} MB", written.states);
    }
    Ok(())
}

/// Write the report of a run folder or of a study's folder; `most` bounds the states in it.
pub fn write(folder: &Path, out: Option<&Path>, most: usize) -> Result<Written, Error> {
    let file = out.map_or_else(|| folder.join("report.html"), Path::to_path_buf);
    if folder.join(results::FILE).is_file() {
        return copy_of_study(folder, file);
    }
    let document = document(folder, most)?;
    let states = document["frames"].as_array().map_or(0, Vec::len);
    let name = document["run"]["scene"]["name"].as_str().unwrap_or("run");
    let page = page(name, &document);
    let bytes = page.len();
    vtu::write(&file, page)?;
    Ok(Written {
        file,
        bytes,
        states,
    })
}

/// A study writes its page with its table, each time.
fn copy_of_study(folder: &Path, file: PathBuf) -> Result<Written, Error> {
    let own = folder.join("report.html");
    let page = std::fs::read_to_string(&own).map_err(Error::file("cannot read", &own))?;
    let bytes = page.len();
    if file != own {
        vtu::write(&file, page)?;
    }
    Ok(Written {
        file,
        bytes,
        states: 0,
    })
}

/// The page with its data inside.
pub fn page(title: &str, data: &Value) -> String {
    shell(
        title,
        include_str!("report/page.html"),
        include_str!("report/page.js"),
        data,
    )
}

/// Style, body, data and script in one file.
pub fn shell(title: &str, body: &str, script: &str, data: &Value) -> String {
    // In a script element only "</" and "<!" have a meaning, and JSON has both in strings alone.
    let data = data.to_string().replace('<', "\\u003c");
    let title = escape(title);
    let style = include_str!("report/page.css");
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title} – Sillage</title>\n\
         <style>\n{style}</style>\n</head>\n<body>\n{body}\
         <script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n{script}</script>\n</body>\n</html>\n"
    )
}

/// Text as HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// What a page shows of a run, states included.
fn document(folder: &Path, most: usize) -> Result<Value, Error> {
    let mut document = head(folder)?;
    let scene = document["run"]["scene"]["resolved"].clone();
    let mut reader = Reader::open(folder, &scene);
    let entries = reader.entries()?;
    let mut frames = Vec::new();
    for index in spread(entries.len(), most) {
        frames.push(reader.frame(&entries[index], &scene["particles"]["walls"])?);
    }
    document["stage"] = reader.stage;
    document["frames"] = json!(frames);
    Ok(document)
}

/// All but the states: run.json, the scene as written, and the steps.
pub fn head(folder: &Path) -> Result<Value, Error> {
    let path = folder.join("run.json");
    if !path.is_file() {
        return Err(Error::Usage(format!(
            "{} is the folder of no run and no study: it has no run.json and no {}",
            folder.display(),
            results::FILE
        )));
    }
    let text = std::fs::read_to_string(&path).map_err(Error::file("cannot read", &path))?;
    let run: Value = serde_json::from_str(&text)
        .map_err(|error| Error::Usage(format!("{}: {error}", path.display())))?;
    let steps = folder.join("steps.csv");
    let table = match steps.is_file() {
        true => Table::read(&steps)?,
        false => Table::default(),
    };
    let table = table.thinned(ROWS);
    let columns: serde_json::Map<String, Value> = table
        .columns
        .iter()
        .enumerate()
        .map(|(place, name)| {
            let column: Vec<f64> = table.rows.iter().map(|row| row[place]).collect();
            (name.clone(), json!(column))
        })
        .collect();
    let scene = std::fs::read_to_string(folder.join("scene.toml")).unwrap_or_default();
    Ok(json!({ "run": run, "steps": columns, "scene": scene, "live": false }))
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
    fn places_are_taken_evenly_with_both_ends() {
        assert_eq!(spread(5, 10), [0, 1, 2, 3, 4]);
        assert_eq!(spread(9, 3), [0, 4, 8]);
        assert_eq!(spread(4, 1), [3]);
        assert_eq!(spread(0, 3), [] as [usize; 0]);
        let many = spread(1000, 37);
        assert_eq!((many.len(), many[0], many[36]), (37, 0, 999));
    }

    #[test]
    fn data_cannot_end_its_script() {
        let page = shell("<a>", "", "", &json!({ "text": "</script><!--" }));
        assert_eq!(page.matches("</script>").count(), 2);
        assert!(page.contains("&lt;a&gt;"));
    }
}
