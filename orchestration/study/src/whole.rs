//! A study from its file to its tables, plots and page.
//!
//! ```text
//!   study.toml ─► points = axes × axes ─► runs, one after another, interleaved over the repeats
//!                                             │ points/NAME/REPEAT: a run folder, and point.json
//!                 table, plots ◄── medians ◄──┘ when it is over: it is not run again
//! ```

use std::path::{Path, PathBuf};

use serde_json::Value;

use run::batch::{self, Clock, Done};
use run::file;
use run::folder::claim::Claim;
use run::{Runner, Voice, launch};
use scene::Scene;
use scene::error::{Error, exit_code};
use show::picture::pictures;

use crate::keys::{self, StudyFile};
use crate::points::{self, Point};
use crate::program::Program;
use crate::results::{self, Cost, Row, Sample};
use crate::{analysis, measure, page, plot};

/// The folder of a study.
const STUDY: Claim = Claim {
    what: "study",
    mark: "study.json",
    parts: &["points"],
};

/// A study that was run, perhaps in part.
pub struct Outcome {
    /// Its folder.
    pub folder: PathBuf,
    /// The table as text.
    pub table: String,
    /// `study.json`.
    pub document: Value,
    /// Points whose runs failed.
    pub failed: usize,
    /// Was it interrupted?
    pub interrupted: bool,
}

/// Built-in studies: name and title of every file in `studies/`.
pub fn list() -> Result<Vec<(String, String)>, Error> {
    let folder = built_in().ok_or_else(|| {
        Error::Usage("there is no folder studies/ here or above the program".into())
    })?;
    let mut names: Vec<PathBuf> = std::fs::read_dir(&folder)
        .map_err(Error::file("cannot read", &folder))?
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    names.sort();
    names
        .iter()
        .map(|path| Ok((stem(path), keys::read(path)?.title)))
        .collect()
}

/// The folder `studies/`, here or above the program.
fn built_in() -> Option<PathBuf> {
    let here = PathBuf::from("studies");
    if here.is_dir() {
        return Some(here);
    }
    let program = std::env::current_exe().ok()?;
    program
        .ancestors()
        .map(|folder| folder.join("studies"))
        .find(|folder| folder.is_dir())
}

/// A file, or the name of a built-in study.
fn find(study: &Path) -> Result<PathBuf, Error> {
    if study.is_file() {
        return Ok(study.to_path_buf());
    }
    built_in()
        .map(|folder| folder.join(study).with_extension("toml"))
        .filter(|path| path.is_file())
        .ok_or_else(|| {
            Error::Usage(format!(
                "{}: neither a file nor a built-in study (see sillage study --list)",
                study.display()
            ))
        })
}

fn stem(path: &Path) -> String {
    path.file_stem()
        .map_or("study".into(), |stem| stem.to_string_lossy().into_owned())
}

/// Run what is not there yet, and write tables and plots of all that is.
pub fn study(path: &Path, out: Option<&Path>, threads: usize) -> Result<Outcome, Error> {
    let path = find(path)?;
    let study = keys::read(&path)?;
    let base = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let name = stem(&path);
    let folder = out.map_or_else(
        || Path::new("runs").join(format!("study-{name}")),
        Path::to_path_buf,
    );
    STUDY.check(&folder)?;
    std::fs::create_dir_all(&folder)
        .map_err(|error| Error::Usage(format!("cannot create {}: {error}", folder.display())))?;
    let given = study
        .reference
        .as_ref()
        .map(|reference| measure::truth(reference, &base));
    let given = given.transpose()?.flatten();
    let points = points::points(&study);
    let finer = match study.reference.as_ref().and_then(|r| r.finer.as_ref()) {
        Some(settings) => points::finer(&study, settings),
        None => Vec::new(),
    };
    let all: Vec<Point> = points.iter().chain(&finer).cloned().collect();
    // Every point is checked before the first one runs.
    let jobs = all
        .iter()
        .map(|point| Job::new(&study, &base, point, threads))
        .collect::<Result<Vec<_>, Error>>()?;

    let runner = Runner::new(Voice::Aloud, pictures)?;
    let mut samples: Vec<Vec<Sample>> = vec![Vec::new(); all.len()];
    let mut clock = Clock::new(points.len() * study.repeats + finer.len());
    let mut interrupted = false;
    // One repeat of all points, then the next: what else the machine does meets all alike.
    'runs: for repeat in 1..=study.repeats {
        // The finer runs are there for their values, which repeat; their times are not compared.
        let count = if repeat == 1 { all.len() } else { points.len() };
        for (index, point) in all.iter().enumerate().take(count) {
            let place = folder
                .join("points")
                .join(point.folder())
                .join(repeat.to_string());
            let mark = jobs[index].mark(point);
            let done = match batch::known(&place, &mark) {
                Some(done) => {
                    clock.skip();
                    done
                }
                None if runner.interrupts.so_far() > 0 => {
                    interrupted = true;
                    break 'runs;
                }
                None => {
                    let what = format!("{}, repeat {repeat}", point.names.join(", "));
                    run::tell!("{}: {what}", clock.line());
                    let done = match &jobs[index] {
                        Job::Scene(scene) => batch::one(scene, &place, &mark, &runner)?,
                        Job::Program(program) => program.run(&place, &runner.interrupts)?,
                    };
                    let Some(done) = done else {
                        interrupted = true;
                        break 'runs;
                    };
                    clock.ran();
                    done
                }
            };
            samples[index].push(sample(&place, &done, &study));
        }
    }
    let (samples, finest) = samples.split_at(points.len());
    let truth: Vec<Option<f64>> = match finer.is_empty() {
        true => vec![given; points.len() / study.axis[0].points.len()],
        false => finest.iter().map(|samples| finest_value(samples)).collect(),
    };
    let rows = results::rows(&study, &points, samples, &truth);
    finish(&folder, &name, &study, &rows, interrupted)
}

/// What a point runs.
enum Job {
    Scene(Box<Scene>),
    Program(Program),
}

impl Job {
    fn new(study: &StudyFile, base: &Path, point: &Point, threads: usize) -> Result<Job, Error> {
        if let Some(program) = &study.program {
            return Program::new(program, &point.settings).map(Job::Program);
        }
        let path = base.join(study.scene.as_deref().unwrap_or(Path::new("")));
        let scene = scene::load(&path, &point.settings, threads)?;
        launch::require_programs(&scene)?;
        Ok(Job::Scene(Box::new(scene)))
    }

    fn mark(&self, point: &Point) -> Value {
        match self {
            Job::Scene(scene) => batch::mark(scene, &point.settings),
            Job::Program(program) => program.mark(),
        }
    }
}

/// The median of the finer runs, if there is one.
fn finest_value(samples: &[Sample]) -> Option<f64> {
    let values: Vec<f64> = samples
        .iter()
        .filter_map(|sample| match sample {
            Sample::Run { value, .. } => Some(*value),
            Sample::Failed(_) => None,
        })
        .collect();
    Some(analysis::median(&values)).filter(|value| value.is_finite())
}

fn finish(
    folder: &Path,
    name: &str,
    study: &StudyFile,
    rows: &[Row],
    interrupted: bool,
) -> Result<Outcome, Error> {
    let complete = rows.iter().all(|row| row.runs >= study.repeats);
    let document = results::document(name, study, rows, complete);
    results::write(folder, &document, study, rows)?;
    plot::write(folder, study, rows)?;
    let page = page::page(folder, name, study, rows, &document)?;
    file::write(&folder.join("report.html"), page)?;
    for (also, unknown) in study.also.iter().zip(results::unknown(study, rows)) {
        if let Some((points, why)) = unknown {
            let name = &also.measure.name;
            run::tell!("sillage: warning: {name}: not known of {points} points: {why}");
        }
    }
    Ok(Outcome {
        folder: folder.to_path_buf(),
        table: results::text(study, rows),
        document,
        failed: rows.iter().filter(|row| row.failed.is_some()).count(),
        interrupted,
    })
}

fn sample(place: &Path, done: &Done, study: &StudyFile) -> Sample {
    let Done { point, document } = done;
    if point["exit"] != exit_code::OK {
        let why = point["why"].as_str().unwrap_or("ended early");
        return Sample::Failed(format!("exit code {}: {why}", point["exit"]));
    }
    let number = |of: &keys::Measure| {
        let value = measure::measure(of, place, document);
        value.map_err(|error| error.to_string())
    };
    let value = match number(&study.measure) {
        Ok(value) => value,
        Err(why) => return Sample::Failed(why),
    };
    let also = study
        .also
        .iter()
        .map(|also| number(&also.measure))
        .collect();
    let cost = &document["cost"];
    let table = |name: &str| -> std::collections::BTreeMap<String, f64> {
        let entries = cost[name].as_object().into_iter().flatten();
        entries
            .filter_map(|(seat, value)| Some((seat.clone(), value.as_f64()?)))
            .collect()
    };
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let cpu = table("cpu_process");
    Sample::Run {
        value,
        also,
        cost: Cost {
            cpu_total: cpu.values().sum(),
            cpu,
            wall: number(&cost["wall_total"]),
            memory_peak: table("memory_peak"),
            steps: number(&document["steps"]),
            passes: number(&cost["passes"]),
            load: number(&point["load"]),
        },
    }
}
