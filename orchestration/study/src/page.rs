//! The page of a study: its table and its plots.

use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

use crate::keys::StudyFile;
use crate::plot;
use crate::results::{self, Row};
use run::progress::digits;
use scene::Error;
use show::page::{escape, shell};

/// The page.
pub fn page(
    folder: &Path,
    name: &str,
    study: &StudyFile,
    rows: &[Row],
    document: &Value,
) -> Result<String, Error> {
    let text = |value: &Value| escape(value.as_str().unwrap_or("unknown"));
    let done: usize = rows.iter().map(|row| row.runs).sum();
    let all = rows.len() * study.repeats;
    let (state, class) = if done == all {
        ("complete".to_string(), "")
    } else {
        (format!("{done} of {all} runs"), " runs")
    };
    let mut body = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        body,
        "<header class=\"top\"><div><h1>{}</h1><p class=\"muted\">Study {}, medians of {} run{}</p></div>\
         <p class=\"badge{class}\" role=\"status\">{state}</p></header>\n<main>\n",
        escape(&study.title),
        escape(name),
        study.repeats,
        if study.repeats == 1 { "" } else { "s" },
    );
    body += "<section class=\"card\"><h2>Results</h2><div class=\"wide\">";
    body += &table(study, rows);
    body += "</div>";
    if let Some(reference) = &study.reference {
        // Points may have references of their own; one number is told only when it is all there is.
        let first = rows.first().and_then(|row| row.reference);
        let truth = first
            .filter(|truth| rows.iter().all(|row| row.reference == Some(*truth)))
            .map_or(String::new(), |truth| {
                let number = format!("{} {}", digits(truth), escape(&study.measure.unit));
                format!("{}; ", number.trim_end())
            });
        let _ = write!(
            body,
            "<p class=\"muted\">Reference: {truth}{}. Errors are relative. ● marks the Pareto front: no other point is both cheaper in CPU time and closer.</p>",
            escape(&reference.source)
        );
    }
    body += "</section>\n";
    for (file, label) in plot::FILES {
        let path = folder.join(format!("{file}.svg"));
        if let Ok(svg) = std::fs::read_to_string(&path) {
            let _ = writeln!(
                body,
                "<section class=\"card\"><h2>{label}</h2><div class=\"plot\" role=\"img\" aria-label=\"{label}; its numbers are in the table\">{svg}</div></section>"
            );
        }
    }
    let machine = &document["machine"];
    let load: Vec<f64> = rows
        .iter()
        .map(|row| row.cost.load)
        .filter(|load| load.is_finite())
        .collect();
    let load = if load.is_empty() {
        "unknown".into()
    } else {
        let (low, high) = load
            .iter()
            .fold((f64::MAX, f64::MIN), |(a, b), l| (a.min(*l), b.max(*l)));
        format!("{low:.1} to {high:.1}")
    };
    let _ = writeln!(
        body,
        "<section class=\"card\"><h2>Made by</h2><table><tr><th scope=\"row\">sillage</th><td>{}, commit {}</td></tr>\
         <tr><th scope=\"row\">machine</th><td>{}, {} cores, {}</td></tr><tr><th scope=\"row\">load while running</th><td>{load}</td></tr></table></section>\n</main>",
        text(&document["versions"]["sillage"]),
        text(&document["versions"]["commit"]),
        text(&machine["cpu"]),
        machine["cores"],
        text(&machine["system"]),
    );
    Ok(shell(&study.title, &body, "", document))
}

fn table(study: &StudyFile, rows: &[Row]) -> String {
    let (heads, body) = results::cells(study, rows);
    let axes = study.axis.len();
    let class = |column: usize| {
        if column < axes {
            ""
        } else {
            " class=\"number\""
        }
    };
    let mut html = String::from("<table><tr>");
    for (column, head) in heads.iter().enumerate() {
        let _ = write!(
            html,
            "<th scope=\"col\"{}>{}</th>",
            class(column),
            escape(head)
        );
    }
    html += "</tr>";
    for (cells, row) in body.iter().zip(rows) {
        html += if row.front {
            "<tr class=\"front\">"
        } else {
            "<tr>"
        };
        for (column, cell) in cells.iter().enumerate() {
            let _ = write!(html, "<td{}>{}</td>", class(column), escape(cell));
        }
        html += "</tr>";
    }
    html + "</table>"
}
