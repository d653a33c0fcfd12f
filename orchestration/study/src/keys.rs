//! Every key of a study, as it stands in the file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use scene::Error;

/// A study: one scene, axes along which it is varied, what is measured, and what is true.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// What the study shows, in a line.
    pub title: String,
    /// Scene file, relative to the study …
    pub scene: Option<PathBuf>,
    /// … or a program beside `sillage` that prints one JSON object; settings are its arguments.
    pub program: Option<String>,
    /// Settings of all points, KEY=VALUE as for `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Runs of each point; times are medians over them.
    #[serde(default = "once")]
    pub repeats: usize,
    /// What is varied; observed orders are taken along the first.
    pub axis: Vec<Axis>,
    /// What is measured: the first is plotted, all stand in the tables.
    pub measure: Measure,
    /// What else is measured.
    #[serde(default)]
    pub also: Vec<Also>,
    /// What is true; without it values are shown and no errors.
    pub reference: Option<Reference>,
}

/// One axis.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Its name in tables and plots.
    pub name: String,
    /// Has the error an order in its size? false: sizes are for the plot alone.
    #[serde(default = "yes")]
    pub orders: bool,
    /// Its points.
    pub points: Vec<AxisPoint>,
}

/// A point of an axis.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisPoint {
    /// Its name in tables, plots and folders.
    pub name: String,
    /// Its size, for orders and plots: cell size, step, tolerance, …
    pub size: Option<f64>,
    /// Settings, KEY=VALUE as for `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Another reference for this point.
    pub reference: Option<f64>,
}

/// A number taken from a run.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Its name in tables and plots.
    pub name: String,
    /// Its unit, after `factor`.
    #[serde(default)]
    pub unit: String,
    /// Column of steps.csv …
    pub column: Option<String>,
    /// … at this time (s), …
    pub time: Option<f64>,
    /// … its mean between two times (s), …
    pub mean: Option<[f64; 2]>,
    /// … its slope between two times (s), …
    pub slope: Option<[f64; 2]>,
    /// … its largest value between two times (s), …
    pub largest: Option<[f64; 2]>,
    /// … how far it rises above an earlier value between two times (s); none of these: the value of
    /// the last step.
    pub rise: Option<[f64; 2]>,
    /// Or a number of run.json, e.g. "/cost/wall_exchange" …
    pub json: Option<String>,
    /// … over another one, e.g. "/cost/passes".
    pub per: Option<String>,
    /// The number is multiplied by this.
    #[serde(default = "one")]
    pub factor: f64,
    /// Then this is added.
    #[serde(default)]
    pub offset: f64,
}

/// Another number taken from a run.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Also {
    /// The number.
    pub measure: Measure,
    /// What it would be without error …
    pub reference: Option<f64>,
    /// … or the point that it is held against: its name on an axis, with the same names on the others.
    /// Without either the value stands in the tables, not its error.
    pub against: Option<String>,
}

/// What the measure would be without error.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Where it comes from.
    pub source: String,
    /// The number …
    pub value: Option<f64>,
    /// … or a CSV file, relative to the study …
    pub file: Option<PathBuf>,
    /// … with the column …
    pub column: Option<String>,
    /// … of the row where these columns have these values (numbers between rows interpolated
    /// when one column is named) …
    #[serde(default)]
    pub at: BTreeMap<String, f64>,
    /// … times this; or a finer run, with these settings.
    #[serde(default = "one")]
    pub factor: f64,
    /// Settings of the finer run.
    pub finer: Option<Vec<String>>,
}

fn once() -> usize {
    1
}
fn yes() -> bool {
    true
}
fn one() -> f64 {
    1.0
}

/// Read and check a study.
pub fn read(path: &Path) -> Result<StudyFile, Error> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| Error::Usage(format!("cannot read study {}: {error}", path.display())))?;
    let study: StudyFile = toml::from_str(&text)
        .map_err(|error| Error::Usage(format!("{}: {error}", path.display())))?;
    check(&study).map_err(|why| Error::Usage(format!("{}: {why}", path.display())))?;
    Ok(study)
}

fn check(study: &StudyFile) -> Result<(), String> {
    if study.scene.is_some() == study.program.is_some() {
        return Err("needs either scene or program".into());
    }
    if study.axis.is_empty() {
        return Err("no [[axis]]: a study varies something".into());
    }
    if !(1..=99).contains(&study.repeats) {
        return Err(format!("repeats = {}: must be 1 to 99", study.repeats));
    }
    for axis in &study.axis {
        if axis.points.is_empty() {
            return Err(format!("axis {}: has no points", axis.name));
        }
        for (index, point) in axis.points.iter().enumerate() {
            let place = format!("axis {}, point {}", axis.name, point.name);
            if axis.points[..index].iter().any(|p| p.name == point.name) {
                return Err(format!("{place}: named twice"));
            }
            if point
                .size
                .is_some_and(|size| !(size > 0.0 && size.is_finite()))
            {
                return Err(format!("{place}: size must be positive"));
            }
        }
    }
    for also in &study.also {
        check_measure(&also.measure)?;
        check_against(study, also)?;
    }
    check_measure(&study.measure)?;
    check_reference(study.reference.as_ref())
}

fn check_against(study: &StudyFile, also: &Also) -> Result<(), String> {
    let Some(against) = &also.against else {
        return Ok(());
    };
    let place = format!("also, {}", also.measure.name);
    if also.reference.is_some() {
        return Err(format!("{place}: takes reference or against, not both"));
    }
    let points = study.axis.iter().flat_map(|axis| &axis.points);
    let names: Vec<&str> = points.map(|point| point.name.as_str()).collect();
    match names.iter().filter(|name| *name == against).count() {
        1 => Ok(()),
        0 => Err(format!(
            "{place}: against = {against:?} is no point (points: {})",
            names.join(", ")
        )),
        _ => Err(format!(
            "{place}: against = {against:?} stands on several axes"
        )),
    }
}

fn check_measure(measure: &Measure) -> Result<(), String> {
    let Measure {
        column,
        json,
        time,
        mean,
        slope,
        largest,
        rise,
        per,
        ..
    } = measure;
    if column.is_some() == json.is_some() {
        return Err("measure: needs either column (of steps.csv) or json (of run.json)".into());
    }
    let ways = [
        time.is_some(),
        mean.is_some(),
        slope.is_some(),
        largest.is_some(),
        rise.is_some(),
    ];
    let ways = ways.iter().filter(|&&way| way).count();
    if ways > 1 || (ways == 1 && json.is_some()) || (per.is_some() && json.is_none()) {
        return Err(
            "measure: column takes at most one of time, mean, slope, largest and rise; json takes per"
                .into(),
        );
    }
    for window in [mean, slope, largest, rise].into_iter().flatten() {
        if window[0].partial_cmp(&window[1]) != Some(std::cmp::Ordering::Less) {
            return Err(format!("measure: {window:?} must be [from, to] in s"));
        }
    }
    Ok(())
}

fn check_reference(reference: Option<&Reference>) -> Result<(), String> {
    if let Some(reference) = reference {
        let ways = [
            reference.value.is_some(),
            reference.file.is_some(),
            reference.finer.is_some(),
        ];
        if ways.iter().filter(|&&way| way).count() != 1 {
            return Err("reference: needs one of value, file and finer".into());
        }
        if reference.file.is_some() && (reference.column.is_none() || reference.at.is_empty()) {
            return Err("reference: file needs column and at = { COLUMN = VALUE }".into());
        }
    }
    Ok(())
}
