//! `run.json`: what was run, by what, on what, at which cost, and how it ended.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use protocol::message::Hello;
use scene::error::{Error, exit_code};
use scene::kept::Kept;
use scene::{Scene, plan};
use serde_json::{Value, json};

use super::run_folder::RunFolder;
use super::steps::Summary;
use super::{machine, recorded};
use crate::file::{self, seconds_since_1970};
use crate::version;

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Ending {
    /// Exit code of the run.
    pub code: i32,
    /// Why, when it ended early.
    pub why: Option<String>,
    /// Wall time of the whole run, start of processes included \[s\].
    pub wall: f64,
    /// CPU time of each process \[s\].
    pub cpu: BTreeMap<String, f64>,
    /// Largest resident memory of each process \[bytes\].
    pub memory_peak: BTreeMap<String, u64>,
    /// Wall time of "start" (processes, until the coupling begins), "steps", and "end" (what is still written
    /// after it) \[s\].
    pub phases: BTreeMap<&'static str, f64>,
}

/// The document of a run that goes on (`ending` is none) or has ended.
pub fn document(scene: &Scene, folder: &RunFolder, ending: Option<&Ending>) -> Value {
    let summary = folder.summary();
    let totals: serde_json::Map<String, Value> = folder
        .totals
        .iter()
        .map(|total| (total.name.clone(), json!(total.value)))
        .collect();
    let why = folder.recording_ended.as_deref();
    let recording = scene
        .record
        .as_ref()
        .map(|record| recorded::report(record, &folder.totals, why));
    let mut described = json!(Kept::of(scene));
    described["resolved"] = json!(scene.coupler);
    described["grains"] = json!(scene.grains.len());
    let (kept, not_kept) = folder.kept();
    json!({
        "scene": described,
        "versions": version::all(),
        "machine": machine::machine(),
        "plan": plan::plan(scene),
        "engines": folder.engines.iter().map(engine).collect::<Vec<_>>(),
        "written": seconds_since_1970(),
        "steps": summary.steps,
        "time_reached": summary.time,
        "cost": cost(summary, ending),
        "worst": summary.worst,
        "left_out": summary.left_out,
        "totals": totals,
        "recording": recording,
        "resumed": folder.resumed(),
        "checkpoint": { "step": kept, "none_later": not_kept },
        "exit": ending.map(|ending| json!({
            "code": ending.code,
            "meaning": exit_code::meaning(ending.code),
            "why": ending.why,
        })),
    })
}

/// Seconds by phase: of the run as a whole, and of its steps by what was computed.
fn cost(summary: &Summary, ending: Option<&Ending>) -> Value {
    let mut cost = json!(summary.sums);
    if let Some(ending) = ending {
        cost["wall_total"] = json!(ending.wall);
        cost["cpu_process"] = json!(ending.cpu);
        cost["memory_peak"] = json!(ending.memory_peak);
        cost["wall_phases"] = json!(ending.phases);
    }
    cost
}

fn engine(hello: &Hello) -> Value {
    json!({
        "role": hello.role,
        "engine": hello.engine,
        "version": hello.version,
        "protocol": hello.protocol,
        "capabilities": hello.capabilities,
    })
}

/// Its text.
pub fn text(document: &Value) -> String {
    format!("{document:#}\n")
}

/// Where it stands in a folder.
pub fn place(folder: &Path) -> PathBuf {
    folder.join("run.json")
}

/// Read the `run.json` of a run folder.
pub fn read(folder: &Path) -> Result<Value, Error> {
    let path = place(folder);
    let unusable = |why: String| {
        let path = path.display();
        Error::Usage(format!("{path}: {why}: name the folder of a run"))
    };
    let text = std::fs::read_to_string(&path).map_err(|error| unusable(error.to_string()))?;
    serde_json::from_str(&text).map_err(|error| unusable(error.to_string()))
}

/// Write `run.json`.
pub fn write(folder: &Path, document: &Value) -> Result<(), Error> {
    file::write(&place(folder), text(document))
}
