//! One scene: is it refused, or does it run, and does its ending mean what it says?

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use scene::document::Document;
use serde_json::Value as Json;
use toml::Value;

use crate::background::report;
use crate::schema;

/// A command says something new within this time on a machine of its own: it ends, or accepts a step. Otherwise it
/// hangs: it is interrupted, and soon killed.
const LONGEST: Duration = Duration::from_secs(20);
/// Of these times in all: steps that are halved again and again are many.
const TIMES: u32 = 10;
/// Coupling steps of a run.
const STEPS: f64 = 3.0;
/// Grains and cells beyond which three steps may honestly take long.
const GRAINS_MAX: u64 = 20_000;
const CELLS_MAX: f64 = 2e4;
/// Of the smallest adaptive steps in a run.
const SMALLEST_MAX: f64 = 30.0;
/// Of defects that no tolerance of a scene decides.
const DEFECT_MAX: f64 = 1e-6;

/// A scene to be tried in a folder of its own.
pub struct Trial {
    tree: Value,
}

/// How a scene ended.
pub enum Ending {
    /// `check` refused it, with these words.
    Refused(String),
    /// It is too much work for a test.
    Skipped,
    /// It ran to its end.
    Ran(Defects),
    /// It ran and ended early: exit code, and why.
    Early(i32, String),
    /// It panicked, hung, or said what is not so.
    Wrong(String),
}

/// Largest defects of a run.
#[derive(Clone, Copy, Default)]
pub struct Defects {
    /// Of volume.
    pub volume: f64,
    /// Of action and reaction.
    pub third_law: f64,
}

impl Trial {
    /// Of this scene.
    pub fn new(tree: Value) -> Trial {
        Trial { tree }
    }

    /// The scene as text.
    pub fn text(&self) -> String {
        text(&self.tree)
    }

    fn document(&self) -> Document {
        Document::parse(Path::new("scene.toml"), self.text(), &[]).expect("TOML")
    }

    /// Check it and run it; how it ended, and after how long at most \[s\].
    pub fn run(&self) -> (Ending, f64) {
        let folder = tempfile::tempdir().expect("a folder");
        let mut seconds = 0.0;
        let ending = self.run_in(folder.path(), &mut seconds);
        (ending.unwrap_or_else(Ending::Wrong), seconds)
    }

    fn run_in(&self, folder: &Path, seconds: &mut f64) -> Result<Ending, String> {
        let scene = folder.join("scene.toml");
        std::fs::write(&scene, self.text()).expect("written");
        let scene = scene.to_string_lossy().into_owned();
        let (code, said, words) = sillage(&["check", "--json", &scene], folder, seconds)?;
        let checked: Json = serde_json::from_str(&said).map_err(|error| error.to_string())?;
        schema::agree(&self.document(), &refused(&checked))?;
        match code {
            0 => {}
            2 => return Ok(Ending::Refused(words)),
            _ => return Err(format!("check: exit code {code}: {words}")),
        }
        let Some(short) = self.short(checked["grains"].as_u64().unwrap_or(0)) else {
            return Ok(Ending::Skipped);
        };
        std::fs::write(&scene, text(&short)).expect("written");
        let run = folder.join("run");
        let out = run.to_string_lossy().into_owned();
        let arguments = ["run", &scene, "--out", &out, "--threads", "1"];
        let (code, _, words) = sillage(&arguments, folder, seconds)?;
        let logs = logs(&run);
        if logs.contains("panicked") {
            return Err(format!("exit code {code}: {words}\n{logs}"));
        }
        match code {
            0 => Ok(Ending::Ran(self.balanced(&report(&run))?)),
            6..=8 => Ok(Ending::Early(code, words)),
            // What an engine of the scene's own takes, only it knows.
            2..=4 if self.tree.get("engines").is_some() => Ok(Ending::Early(code, words)),
            _ => Err(format!("run: exit code {code}: {words}")),
        }
    }

    /// The scene for a few steps; none where they may take long.
    fn short(&self, grains: u64) -> Option<Value> {
        let tree = &self.tree;
        let number = |value: Option<&Value>| {
            let value = value?;
            value.as_float().or(value.as_integer().map(|n| n as f64))
        };
        let of = |table: &str, key: &str| number(tree.get(table)?.get(key));
        let step = of("run", "coupling_step")?;
        let end = of("run", "end_time")?.min(STEPS * step);
        let adaptive = tree.get("coupling").and_then(|c| c.get("adaptive"));
        let smallest = number(adaptive.and_then(|a| a.get("step_min"))).unwrap_or(step);
        let rectangle = tree
            .get("fluid")
            .and_then(|fluid| fluid.get("domain")?.get("rectangle"));
        let cells = rectangle.and_then(|r| r.get("cells")?.as_array());
        let cells = cells.map_or(1.0, |cells| {
            cells.iter().filter_map(|c| number(Some(c))).product()
        });
        let works = grains <= GRAINS_MAX && cells <= CELLS_MAX && end / smallest <= SMALLEST_MAX;
        works.then(|| {
            let mut short = tree.clone();
            short["run"]["end_time"] = Value::Float(end);
            short
        })
    }

    /// The defects of a run that says it is well; an error names one above its bound.
    fn balanced(&self, report: &Json) -> Result<Defects, String> {
        let worst = report["worst"]
            .as_object()
            .ok_or("no defects in run.json")?;
        let mut bounds = vec![
            ("volume_defect", DEFECT_MAX),
            ("third_law_defect", DEFECT_MAX),
        ];
        let scheme = &report["scene"]["resolved"]["scheme"]["iterated"]["tolerance"];
        bounds.extend(scheme.as_f64().map(|most| ("interaction_defect", most)));
        for (name, value) in worst {
            let value = value
                .as_f64()
                .ok_or(format!("exit code 0 with {name} = {value}"))?;
            let bound = bounds.iter().find(|(bounded, _)| bounded == name);
            if bound.is_some_and(|(_, most)| value.abs() > *most) {
                return Err(format!("exit code 0 with {name} = {value:e}"));
            }
        }
        let of = |name: &str| worst.get(name).and_then(Json::as_f64).unwrap_or(0.0);
        Ok(Defects {
            volume: of("volume_defect"),
            third_law: of("third_law_defect"),
        })
    }
}

fn text(tree: &Value) -> String {
    toml::to_string(tree).expect("TOML")
}

/// The keys that a check refused.
fn refused(checked: &Json) -> Vec<String> {
    let problems = checked["problems"].as_array().into_iter().flatten();
    let keys = problems.filter_map(|problem| problem["key"].as_str());
    keys.map(str::to_owned).collect()
}

/// Run a command: exit code, stdout, stderr; an error when it hangs, panics or has no exit code. `longest` is the
/// longest time without a step.
fn sillage(
    arguments: &[&str],
    folder: &Path,
    longest: &mut f64,
) -> Result<(i32, String, String), String> {
    let path = |name: &str| folder.join(name);
    let file = |name: &str| std::fs::File::create(path(name)).expect("a file");
    let (begun, patience) = (Instant::now(), LONGEST.mul_f64(crowd()));
    let mut child = Command::new(env!("CARGO_BIN_EXE_sillage"))
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(file("said"))
        .stderr(file("told"))
        .spawn()
        .expect("started");
    let mut interrupted = None;
    let table = path("run/steps.csv");
    let (mut length, mut since) = (0, begun);
    let status = loop {
        let longer = std::fs::metadata(&table).map_or(0, |about| about.len());
        if longer > length {
            *longest = longest.max(since.elapsed().as_secs_f64());
            (length, since) = (longer, Instant::now());
        }
        if let Some(status) = child.try_wait().expect("status") {
            break status;
        }
        let hangs = since.elapsed() > patience || begun.elapsed() > TIMES * patience;
        if hangs && interrupted.is_none() {
            kill(Pid::from_raw(child.id() as i32), Signal::SIGINT).expect("signalled");
            interrupted = Some(Instant::now());
        }
        if interrupted.is_some_and(|at| at.elapsed() > patience) {
            child.kill().expect("killed");
            child.wait().expect("reaped");
            return Err(format!("{} hangs, deaf to an interruption", arguments[0]));
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    *longest = longest.max(since.elapsed().as_secs_f64());
    let [said, told] = ["said", "told"].map(|name| std::fs::read_to_string(path(name)));
    let (said, told) = (said.unwrap_or_default(), told.unwrap_or_default());
    match status.code() {
        _ if interrupted.is_some() => Err(format!(
            "{} takes longer than {patience:?} for a step, or {TIMES} times as long in all: {told}",
            arguments[0]
        )),
        Some(code) if !told.contains("panicked") => Ok((code, said, told)),
        _ => Err(format!("{}: {status}: {told}", arguments[0])),
    }
}

/// How many times longer all takes, as others compute as well.
fn crowd() -> f64 {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let running = load
        .split(' ')
        .next()
        .and_then(|load| load.parse::<f64>().ok());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    (running.unwrap_or(0.0) / cores as f64).max(1.0)
}

/// What the processes of a run said.
fn logs(run: &Path) -> String {
    let entries = std::fs::read_dir(run.join("logs")).into_iter().flatten();
    let texts = entries
        .flatten()
        .map(|entry| std::fs::read_to_string(entry.path()));
    texts.map(Result::unwrap_or_default).collect()
}
