//! What a study found: a row a point, as JSON, CSV and text.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde::Serialize;
use serde_json::{Value, json};

use crate::analysis;
use crate::keys::{Measure, StudyFile};
use crate::points::Point;
use run::file;
use run::progress::digits;
use scene::Error;
use show::page::STUDY_FILE;

/// One run of a point, or why there is none.
#[derive(Debug, Clone, PartialEq)]
pub enum Sample {
    /// It ended well.
    Run {
        /// The measure.
        value: f64,
        /// What else was measured, or why it was not.
        also: Vec<Result<f64, String>>,
        /// What it cost.
        cost: Cost,
    },
    /// It ended early, or its measure cannot be had.
    Failed(String),
}

/// What a run cost.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Cost {
    /// CPU time of each process \[s\].
    pub cpu: BTreeMap<String, f64>,
    /// CPU time of all \[s\].
    pub cpu_total: f64,
    /// Wall time, start of processes included \[s\].
    pub wall: f64,
    /// Largest resident memory of each process \[bytes\].
    pub memory_peak: BTreeMap<String, f64>,
    /// Steps accepted.
    pub steps: f64,
    /// Passes of all steps.
    pub passes: f64,
    /// Load of the machine (runnable processes, one minute) when the run ended.
    pub load: f64,
}

/// A point with its samples.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Names along the axes.
    pub names: Vec<String>,
    /// Size along the first axis.
    pub size: Option<f64>,
    /// Median of the measure; NaN when it failed.
    pub value: f64,
    /// What it should be.
    pub reference: Option<f64>,
    /// Relative error.
    pub error: Option<f64>,
    /// What else was measured, in the order of the study: medians …
    pub also: Vec<f64>,
    /// … and their errors, where a reference is known.
    pub also_errors: Vec<Option<f64>>,
    /// Why one of these is not known, though the point ran.
    pub also_unknown: Vec<Option<String>>,
    /// Observed order from the point before it on the first axis.
    pub order: Option<f64>,
    /// Is no other point of the same problem both cheaper and better?
    pub front: bool,
    /// Medians over the repeats.
    pub cost: Cost,
    /// Runs that ended well.
    pub runs: usize,
    /// Why there is no value.
    pub failed: Option<String>,
}

/// All rows of a study.
pub fn rows(
    study: &StudyFile,
    points: &[Point],
    samples: &[Vec<Sample>],
    truth: &[Option<f64>],
) -> Vec<Row> {
    let mut rows: Vec<Row> = points
        .iter()
        .zip(samples)
        .enumerate()
        .map(|(index, (point, samples))| {
            let series = index / study.axis[0].points.len();
            row(study, point, samples, truth.get(series).copied().flatten())
        })
        .collect();
    hold_against(study, &mut rows);
    // Points of the first axis follow each other, once for each choice on the others.
    let first = &study.axis[0];
    let chosen = rows.chunks_mut(first.points.len());
    for series in chosen.filter(|_| first.orders) {
        let errors: Vec<f64> = series.iter().map(|r| r.error.unwrap_or(f64::NAN)).collect();
        let sizes: Vec<f64> = series.iter().map(|r| r.size.unwrap_or(f64::NAN)).collect();
        let orders = analysis::orders(&sizes, &errors);
        series
            .iter_mut()
            .zip(orders)
            .for_each(|(row, order)| row.order = order);
    }
    for group in comparable(study) {
        let of = |index: &usize| {
            let row: &Row = &rows[*index];
            (row.cost.cpu_total, row.error.unwrap_or(f64::NAN))
        };
        let front = analysis::pareto(&group.iter().map(of).collect::<Vec<_>>());
        for (index, front) in group.into_iter().zip(front) {
            rows[index].front = front;
        }
    }
    rows
}

/// Rows that solve the same problem: all where the first axis refines it, else those with the same
/// choice on it.
pub fn comparable(study: &StudyFile) -> Vec<Vec<usize>> {
    let rows: usize = study.axis.iter().map(|axis| axis.points.len()).product();
    let first = &study.axis[0];
    if first.orders {
        return vec![(0..rows).collect()];
    }
    let choices = first.points.len();
    (0..choices)
        .map(|choice| (choice..rows).step_by(choices).collect())
        .collect()
}

/// Errors of what is held against another point.
fn hold_against(study: &StudyFile, rows: &mut [Row]) {
    for (index, also) in study.also.iter().enumerate() {
        let Some(against) = &also.against else {
            continue;
        };
        let on = |axis: &crate::keys::Axis| axis.points.iter().any(|p| p.name == *against);
        let Some(axis) = study.axis.iter().position(on) else {
            continue;
        };
        let errors: Vec<Option<f64>> = rows
            .iter()
            .map(|row| {
                let mut names = row.names.clone();
                names[axis].clone_from(against);
                let truth = rows.iter().find(|other| other.names == names)?.also[index];
                let itself = row.names == names;
                let error = Some(analysis::error(row.also[index], truth));
                error.filter(|error| error.is_finite() && !itself)
            })
            .collect();
        for (row, error) in rows.iter_mut().zip(errors) {
            row.also_errors[index] = error;
        }
    }
}

fn row(study: &StudyFile, point: &Point, samples: &[Sample], truth: Option<f64>) -> Row {
    let runs: Vec<(f64, &Cost)> = samples
        .iter()
        .filter_map(|sample| match sample {
            Sample::Run { value, cost, .. } => Some((*value, cost)),
            Sample::Failed(_) => None,
        })
        .collect();
    let failed = samples.iter().find_map(|sample| match sample {
        Sample::Failed(why) => Some(why.clone()),
        Sample::Run { .. } => None,
    });
    let value = analysis::median(&runs.iter().map(|(value, _)| *value).collect::<Vec<_>>());
    let reference = point.reference.or(truth);
    let also: Vec<f64> = (0..study.also.len())
        .map(|index| analysis::median(&known(samples, index)))
        .collect();
    let also_errors = also
        .iter()
        .zip(&study.also)
        .map(|(value, also)| Some(analysis::error(*value, also.reference?)))
        .map(|error| error.filter(|error| error.is_finite()))
        .collect();
    Row {
        names: point.names.clone(),
        size: point.size,
        value,
        reference,
        error: reference
            .map(|truth| analysis::error(value, truth))
            .filter(|error| error.is_finite()),
        also,
        also_errors,
        also_unknown: (0..study.also.len())
            .map(|index| why_unknown(samples, index))
            .collect(),
        order: None,
        front: false,
        cost: median_cost(&runs.iter().map(|(_, cost)| *cost).collect::<Vec<_>>()),
        runs: runs.len(),
        failed: failed.filter(|_| runs.is_empty()),
    }
}

/// Of the runs that know it: the further number at `index`.
fn known(samples: &[Sample], index: usize) -> Vec<f64> {
    let number = |sample: &Sample| match sample {
        Sample::Run { also, .. } => also[index].as_ref().ok().copied(),
        Sample::Failed(_) => None,
    };
    samples.iter().filter_map(number).collect()
}

/// Why the first run that does not know it does not.
fn why_unknown(samples: &[Sample], index: usize) -> Option<String> {
    samples.iter().find_map(|sample| match sample {
        Sample::Run { also, .. } => also[index].as_ref().err().cloned(),
        Sample::Failed(_) => None,
    })
}

/// The median of each cost on its own.
fn median_cost(costs: &[&Cost]) -> Cost {
    let over = |pick: &dyn Fn(&Cost) -> f64| {
        analysis::median(&costs.iter().map(|cost| pick(cost)).collect::<Vec<_>>())
    };
    let by_process = |pick: fn(&Cost) -> &BTreeMap<String, f64>| -> BTreeMap<String, f64> {
        let names = costs.first().into_iter().flat_map(|cost| pick(cost).keys());
        let median = |name: &String| {
            let of = |cost: &Cost| pick(cost).get(name).copied().unwrap_or(f64::NAN);
            (name.clone(), over(&of))
        };
        names.map(median).collect()
    };
    Cost {
        cpu: by_process(|cost| &cost.cpu),
        cpu_total: over(&|cost| cost.cpu_total),
        wall: over(&|cost| cost.wall),
        memory_peak: by_process(|cost| &cost.memory_peak),
        steps: over(&|cost| cost.steps),
        passes: over(&|cost| cost.passes),
        load: over(&|cost| cost.load),
    }
}

/// Of each number in `also`: how many points ran without it, and why the first one.
pub fn unknown(study: &StudyFile, rows: &[Row]) -> Vec<Option<(usize, String)>> {
    let of = |index: usize| {
        let whys = rows
            .iter()
            .filter_map(|row| row.also_unknown[index].as_ref());
        Some((whys.clone().count(), whys.clone().next()?.clone()))
    };
    (0..study.also.len()).map(of).collect()
}

/// Write `study.json` and `study.csv`.
pub fn write(
    folder: &Path,
    document: &Value,
    study: &StudyFile,
    rows: &[Row],
) -> Result<(), Error> {
    file::write(&folder.join(STUDY_FILE), format!("{document:#}\n"))?;
    file::write(&folder.join("study.csv"), csv(study, rows))
}

/// The document of a study.
pub fn document(name: &str, study: &StudyFile, rows: &[Row], complete: bool) -> Value {
    json!({
        "study": name,
        "title": study.title,
        "complete": complete,
        "axes": study.axis.iter().map(|axis| &axis.name).collect::<Vec<_>>(),
        "measure": { "name": study.measure.name, "unit": study.measure.unit },
        "also": study.also.iter().map(|also| {
            json!({
                "name": also.measure.name,
                "unit": also.measure.unit,
                "reference": also.reference,
                "against": also.against,
            })
        }).collect::<Vec<_>>(),
        "reference": study.reference.as_ref().map(|reference| &reference.source),
        "repeats": study.repeats,
        "points": rows,
        "machine": run::folder::machine::machine(),
        "versions": run::version::all(),
    })
}

fn csv(study: &StudyFile, rows: &[Row]) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let some = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:e}"));
    let mut text: Vec<String> = study.axis.iter().map(|axis| quoted(&axis.name)).collect();
    text.push(
        "size,value,reference,error,order,front,cpu_fluid,cpu_particles,cpu_coupler,cpu_total,wall,\
         memory_fluid,memory_particles,memory_coupler,steps,passes,load,runs,failed"
            .into(),
    );
    for also in &study.also {
        text.push(quoted(&also.measure.name));
        if also.against.is_some() {
            text.push(quoted(&format!("{}, error", also.measure.name)));
        }
    }
    let mut text = text.join(",") + "\n";
    for row in rows {
        let cost = &row.cost;
        let of = |table: &BTreeMap<String, f64>, seat: &str| some(table.get(seat).copied());
        let known = |value: f64| some(value.is_finite().then_some(value));
        let mut cells: Vec<String> = row.names.iter().map(|name| quoted(name)).collect();
        cells.extend([
            some(row.size),
            known(row.value),
            some(row.reference),
            some(row.error),
            some(row.order),
            row.front.to_string(),
        ]);
        cells.extend(["fluid", "particles", "coupler"].map(|seat| of(&cost.cpu, seat)));
        cells.extend([known(cost.cpu_total), known(cost.wall)]);
        cells.extend(["fluid", "particles", "coupler"].map(|seat| of(&cost.memory_peak, seat)));
        cells.extend([known(cost.steps), known(cost.passes), known(cost.load)]);
        cells.push(row.runs.to_string());
        cells.push(row.failed.as_deref().map_or(String::new(), quoted));
        for ((value, error), also) in row.also.iter().zip(&row.also_errors).zip(&study.also) {
            cells.push(known(*value));
            if also.against.is_some() {
                cells.push(some(*error));
            }
        }
        text += &(cells.join(",") + "\n");
    }
    text
}

/// Heads and cells of the table that people read.
pub fn cells(study: &StudyFile, rows: &[Row]) -> (Vec<String>, Vec<Vec<String>>) {
    let mut heads: Vec<String> = study.axis.iter().map(|axis| axis.name.clone()).collect();
    let head = |measure: &Measure| match measure.unit.as_str() {
        "" => measure.name.clone(),
        unit => format!("{} [{unit}]", measure.name),
    };
    heads.push(head(&study.measure));
    heads.extend(["error", "order"].map(String::from));
    heads.extend(study.also.iter().map(|also| match &also.against {
        Some(against) => format!("{} (off {against})", head(&also.measure)),
        None => head(&also.measure),
    }));
    heads.extend(
        [
            "CPU [s]",
            "wall [s]",
            "memory",
            "steps",
            "passes/step",
            "front",
        ]
        .map(String::from),
    );
    let dash = || "–".to_string();
    let body = rows
        .iter()
        .map(|row| {
            let mut cells = row.names.clone();
            if let Some(why) = &row.failed {
                cells.push(format!(
                    "failed: {}",
                    why.lines().next().unwrap_or_default()
                ));
                cells.resize(heads.len(), dash());
                return cells;
            }
            if row.runs == 0 {
                cells.push("not run".into());
                cells.resize(heads.len(), dash());
                return cells;
            }
            let cost = &row.cost;
            let memory: f64 = cost.memory_peak.values().sum();
            cells.push(digits(row.value));
            cells.push(row.error.map_or_else(dash, |error| format!("{error:.2e}")));
            cells.push(row.order.map_or_else(dash, |order| format!("{order:.2}")));
            for ((value, error), also) in row.also.iter().zip(&row.also_errors).zip(&study.also) {
                cells.push(match (&also.against, error) {
                    (Some(_), Some(error)) => format!("{} ({error:.1e})", digits(*value)),
                    _ if value.is_finite() => digits(*value),
                    _ => dash(),
                });
            }
            cells.push(format!("{:.2}", cost.cpu_total));
            cells.push(format!("{:.2}", cost.wall));
            cells.push(format!("{:.0} MB", memory / 1e6));
            cells.push(format!("{}", cost.steps));
            cells.push(format!("{:.2}", cost.passes / cost.steps.max(1.0)));
            cells.push(if row.front {
                "●".into()
            } else {
                String::new()
            });
            cells
        })
        .collect();
    (heads, body)
}

/// The table as text, in columns.
pub fn text(study: &StudyFile, rows: &[Row]) -> String {
    let (heads, body) = cells(study, rows);
    let width = |column: usize| {
        let cells = body
            .iter()
            .map(|row| &row[column])
            .filter(|cell| !cell.starts_with("failed"));
        cells
            .chain([&heads[column]])
            .map(|cell| cell.chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths: Vec<usize> = (0..heads.len()).map(width).collect();
    let mut text = String::new();
    for row in std::iter::once(&heads).chain(&body) {
        let line: Vec<String> = row
            .iter()
            .zip(&widths)
            .map(|(cell, width)| format!("{cell:<width$}"))
            .collect();
        let _ = writeln!(text, "{}", line.join("  ").trim_end());
    }
    text
}
