//! `check`, `plan`, `run` and `doctor`.

use std::path::Path;

use run::{Runner, Voice, fresh_folder};
use scene::document::Document;
use scene::error::exit_code;
use scene::mesh_survey::MeshSurvey;
use scene::{Error, plan};
use serde_json::json;
use show::picture::pictures;

use super::examine;
use crate::cli::scenes::{CheckArgs, DoctorArgs, PlanArgs, RunArgs};
use crate::say;

/// Validate a scene, or print the schema of all.
pub fn check(args: &CheckArgs) -> Result<i32, Error> {
    let Some(path) = &args.scene else {
        say!("{:#}", scene::keys::scene_schema())?;
        return Ok(exit_code::OK);
    };
    let survey = match args.mesh {
        true => survey(path, &args.settings)?,
        false => None,
    };
    if let (Some(survey), false) = (&survey, args.json) {
        say!("{survey}")?;
    }
    let scene = scene::load(path, &args.settings, 1)?;
    for warning in &scene.warnings {
        eprintln!("{}: warning: {warning}", path.display());
    }
    let grains = scene.grains.len();
    if args.json {
        let mut document = json!({ "ok": true, "scene": scene.name, "grains": grains, "warnings": scene.warnings });
        if let Some(survey) = survey {
            document["mesh"] = json!(survey);
        }
        say!("{document:#}")?;
    } else {
        let plural = if grains == 1 { "" } else { "s" };
        say!("{}: ok, {grains} grain{plural}", path.display())?;
    }
    Ok(exit_code::OK)
}

/// What is in the mesh file of a scene.
fn survey(path: &Path, settings: &[String]) -> Result<Option<MeshSurvey>, Error> {
    let document = Document::load(path, settings)?;
    let survey = MeshSurvey::of(&scene::read::read(&document)?, &document.folder())?;
    if survey.is_none() {
        eprintln!("{}: the scene has no mesh file", path.display());
    }
    Ok(survey)
}

/// Print what a scene needs.
pub fn plan(args: &PlanArgs) -> Result<i32, Error> {
    let given = &args.scene;
    let scene = scene::load(&given.scene, &given.settings, given.threads())?;
    let plan = plan::plan(&scene);
    if let Some(folder) = &args.out {
        plan::write_inputs(&scene, folder)?;
    }
    match args.json {
        true => say!("{:#}", json!(plan))?,
        false => say!("{plan}")?,
    }
    Ok(exit_code::OK)
}

/// Run a scene; why it ended early is said here, since its document is on stdout already.
pub fn run(args: &RunArgs) -> Result<i32, Error> {
    let given = &args.scene;
    let mut scene = scene::load(&given.scene, &given.settings, given.threads())?;
    for warning in &scene.warnings {
        eprintln!("{}: warning: {warning}", given.scene.display());
    }
    if let Some(file) = &args.record {
        scene.record_into(file)?;
    }
    let path = match &args.out {
        Some(path) => path.clone(),
        None => fresh_folder(&scene.name)?,
    };
    let outcome = Runner::new(Voice::Aloud, pictures)?.run(&scene, &path)?;
    let (ending, folder) = (&outcome.ending, outcome.folder.display());
    if args.json {
        say!("{:#}", outcome.document)?;
    } else {
        let steps = &outcome.document["steps"];
        say!("{folder}: {steps} steps in {:.1} s", ending.wall)?;
    }
    if let Some(why) = &ending.why {
        eprintln!("sillage: {why}");
    }
    Ok(ending.code)
}

/// Look at the machine.
pub fn doctor(args: &DoctorArgs) -> Result<i32, Error> {
    let findings = examine::examine(args.clean)?;
    match args.json {
        true => say!("{:#}", json!(findings))?,
        false => say!("{findings}")?,
    }
    Ok(exit_code::OK)
}
