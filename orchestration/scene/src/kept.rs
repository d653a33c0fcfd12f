//! A scene as a run folder keeps it: what a run that is resumed goes on with. What was computed once is not
//! read from the scene's own files again, which may have changed.

use std::path::{Path, PathBuf};

use protocol::scene::CouplerScene;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use toml::Value as Toml;

use crate::document::Document;
use crate::error::Error;
use crate::grains::{GrainTable, of_run};
use crate::keys::{Checkpoint, Engines, Output, Record};
use crate::resolve::GRAINS_FILE;
use crate::scene::Scene;

/// The part of a scene that is in no other file of the folder; it stands in `run.json`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Kept {
    name: String,
    folder: PathBuf,
    engines: Engines,
    output: Output,
    record: Option<Record>,
    checkpoint: Checkpoint,
    leave_out: bool,
}

impl Kept {
    /// Of a scene.
    pub fn of(scene: &Scene) -> Kept {
        Kept {
            name: scene.name.clone(),
            folder: std::path::absolute(&scene.folder).unwrap_or_else(|_| scene.folder.clone()),
            engines: scene.engines.clone(),
            output: scene.output.clone(),
            record: scene.record.clone(),
            checkpoint: scene.checkpoint.clone(),
            leave_out: scene.leave_out,
        }
    }
}

/// The scene of a run folder, whose `run.json` has this part of it.
pub fn read(folder: &Path, kept: &Value) -> Result<Scene, Error> {
    let refuse = |file: &Path, why: String| Error::Usage(format!("{}: {why}", file.display()));
    let kept: Kept = serde_json::from_value(kept.clone()).map_err(|error| {
        let why = format!("`scene` cannot be read, so that the run cannot be resumed: {error}");
        refuse(&folder.join("run.json"), why)
    })?;
    let text = |name: &str| {
        let path = folder.join(name);
        let read = std::fs::read_to_string(&path);
        read.map_err(|error| refuse(&path, format!("cannot be read: {error}")))
    };
    let coupler: CouplerScene = serde_json::from_str(&text("scene.json")?)
        .map_err(|error| refuse(&folder.join("scene.json"), error.to_string()))?;
    let grains = match &coupler.grains_file {
        None => GrainTable::default(),
        Some(_) => of_run(&folder.join(GRAINS_FILE), coupler.dimension).map_err(Error::Usage)?,
    };
    Ok(Scene {
        name: kept.name,
        folder: kept.folder,
        text: text("scene.toml")?,
        coupler,
        grains,
        engines: kept.engines,
        output: kept.output,
        record: kept.record,
        checkpoint: kept.checkpoint,
        leave_out: kept.leave_out,
        warnings: Vec::new(),
    })
}

/// Keys that a run may take on its way.
const MAY_CHANGE: &str = "run.end_time, checkpoint.every_steps, checkpoint.every_wall, checkpoint.keep, limits.connect, \
     limits.configure and limits.step";

/// Apply `--set KEY=VALUE` to a run that is resumed; keys that decide what was computed are refused.
pub fn set(scene: &mut Scene, settings: &[String]) -> Result<(), Error> {
    for setting in settings {
        let document = Document::parse(
            Path::new("--set"),
            String::new(),
            std::slice::from_ref(setting),
        )?;
        let key = setting.split('=').next().unwrap_or_default().trim();
        let value = document.value(key);
        let value = value.ok_or_else(|| Error::Usage(format!("--set {setting}: no value")))?;
        one(scene, key, value).map_err(|why| Error::Usage(format!("--set {setting}: {why}")))?;
    }
    Ok(())
}

fn one(scene: &mut Scene, key: &str, value: &Toml) -> Result<(), String> {
    let (limits, checkpoint) = (&mut scene.coupler.limits, &mut scene.checkpoint);
    let number = match key {
        "run.end_time" => &mut scene.coupler.end_time,
        "checkpoint.every_wall" => &mut checkpoint.every_wall,
        "limits.connect" => &mut limits.connect,
        "limits.configure" => &mut limits.configure,
        "limits.step" => &mut limits.step,
        "checkpoint.every_steps" | "checkpoint.keep" => return count(checkpoint, key, value),
        _ => {
            return Err(format!(
                "would change what was computed before; a run that is resumed takes {MAY_CHANGE}"
            ));
        }
    };
    let given = match value {
        Toml::Float(value) => *value,
        Toml::Integer(value) => *value as f64,
        _ => return Err("must be a number".to_owned()),
    };
    if !(given > 0.0 && given.is_finite()) {
        return Err("must be positive and finite (s)".to_owned());
    }
    *number = given;
    Ok(())
}

fn count(checkpoint: &mut Checkpoint, key: &str, value: &Toml) -> Result<(), String> {
    let given = value
        .as_integer()
        .and_then(|value| u32::try_from(value).ok());
    let given = given.ok_or("must be a whole number")?;
    if key == "checkpoint.keep" {
        checkpoint.keep = given;
        return Ok(());
    }
    let every = std::num::NonZeroU64::new(given.into());
    checkpoint.every_steps = Some(every.ok_or("must be at least 1")?);
    Ok(())
}
