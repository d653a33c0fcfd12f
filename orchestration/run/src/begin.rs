//! Where a run begins, and what the coupler is told of its checkpoints.

use std::ffi::OsString;
use std::path::{Path, absolute};

use protocol::checkpoints;
use scene::Scene;

/// Where a run begins.
#[derive(Debug, Clone, Copy)]
pub enum From<'a> {
    /// At its start.
    Start,
    /// At the checkpoint in this folder, as the run that it was made of.
    Checkpoint(&'a Path),
    /// The same as a run of its own, whose recording begins there.
    CheckpointAnew(&'a Path),
}

/// Arguments of the coupler.
pub fn arguments(scene: &Scene, folder: &Path, from: From<'_>) -> Vec<OsString> {
    let whole = |path: &Path| absolute(path).unwrap_or(path.to_path_buf()).into();
    let mut arguments: Vec<OsString> = Vec::new();
    let mut add = |name: &str, value: OsString| arguments.extend([name.into(), value]);
    let rule = &scene.checkpoint;
    if rule.keep > 0 {
        add("--checkpoints", whole(&folder.join(checkpoints::FOLDER)));
        add("--checkpoint-wall", rule.every_wall.to_string().into());
        if let Some(steps) = rule.every_steps {
            add("--checkpoint-steps", steps.to_string().into());
        }
    }
    match from {
        From::Start => {}
        From::Checkpoint(path) => add("--resume", whole(path)),
        From::CheckpointAnew(path) => {
            add("--resume", whole(path));
            arguments.push("--record-anew".into());
        }
    }
    arguments
}
