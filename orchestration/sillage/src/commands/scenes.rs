//! `check`, `plan`, `run`, `resume` and `doctor`.

use std::path::{Path, PathBuf};

use run::folder::claim::{Claim, is_not_of_scene};
use run::folder::document;
use run::{Outcome, Runner, Voice, fresh_folder, launch, tell, unfinished};
use scene::document::Document;
use scene::error::exit_code;
use scene::mesh_survey::MeshSurvey;
use scene::problem::Problems;
use scene::{Error, Scene, kept, plan};
use serde_json::json;
use show::picture::pictures;

use super::examine;
use crate::cli::scenes::{CheckArgs, DoctorArgs, PlanArgs, ResumeArgs, RunArgs};
use crate::say;

/// What a plan writes.
const PLAN: Claim = Claim {
    what: "plan",
    mark: "scene.json",
    parts: &[],
};

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
    let scene = runnable(path, &args.settings, 1)?;
    for warning in &scene.warnings {
        tell!("{}: warning: {warning}", path.display());
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
    let survey = MeshSurvey::of(&document)?;
    if survey.is_none() {
        tell!("{}: the scene has no mesh file", path.display());
    }
    Ok(survey)
}

/// A scene whose engines are there; one that is not is a problem of its key.
fn runnable(path: &Path, settings: &[String], threads: usize) -> Result<Scene, Error> {
    let scene = scene::load(path, settings, threads)?;
    let missing = launch::missing_programs(&scene);
    if missing.is_empty() {
        return Ok(scene);
    }
    let document = Document::load(path, settings)?;
    let problem =
        |(seat, why): (&str, String)| document.problem(&format!("engines.{seat}.command"), why);
    Err(Error::Scene(Problems(
        missing.into_iter().map(problem).collect(),
    )))
}

/// Print what a scene needs.
pub fn plan(args: &PlanArgs) -> Result<i32, Error> {
    let given = &args.scene;
    let scene = scene::load(&given.scene, &given.settings, given.threads())?;
    let plan = plan::plan(&scene);
    if let Some(folder) = &args.out {
        PLAN.check(folder)?;
        is_not_of_scene(folder, &scene.folder)?;
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
    let mut scene = runnable(&given.scene, &given.settings, given.threads())?;
    for warning in &scene.warnings {
        tell!("{}: warning: {warning}", given.scene.display());
    }
    if let Some(file) = &args.record {
        scene.record_into(file)?;
    }
    let path = match &args.out {
        Some(path) if args.replace => path.clone(),
        Some(path) => may_be_replaced(path)?,
        None => fresh_folder(&scene.name)?,
    };
    let outcome = Runner::new(Voice::Aloud, pictures)?.run(&scene, &path)?;
    tell_ending(&outcome, args.json)
}

/// A folder without a run that could be resumed: days of computing are not replaced by the way.
fn may_be_replaced(path: &Path) -> Result<PathBuf, Error> {
    let place = path.display();
    match unfinished(path) {
        None => Ok(path.to_path_buf()),
        Some(step) => Err(Error::Usage(format!(
            "--out {place}: holds a run that has not reached its end: `sillage resume {place}` goes on with \
             it from step {step}; --replace begins anew in its place"
        ))),
    }
}

/// Go on with a run.
pub fn resume(args: &ResumeArgs) -> Result<i32, Error> {
    let path = &args.folder;
    let document = document::read(path)?;
    let mut scene = kept::read(path, &document["scene"])?;
    kept::set(&mut scene, &args.settings)?;
    if let Some(threads) = args.threads {
        let parts = &mut scene.coupler;
        parts
            .fluid
            .iter_mut()
            .for_each(|fluid| fluid.threads = threads.get());
        let grains = parts.particles.iter_mut();
        grains.for_each(|grains| grains.threads = threads.get());
    }
    launch::require_programs(&scene)?;
    match Runner::new(Voice::Aloud, pictures)?.resume(&scene, path, args.from)? {
        Some(outcome) => tell_ending(&outcome, args.json),
        None => {
            let time = &document["time_reached"];
            match args.json {
                true => say!("{document:#}")?,
                false => say!(
                    "{}: has reached its end, t = {time} s; with a later one it goes on: --set run.end_time=…",
                    path.display()
                )?,
            }
            Ok(exit_code::OK)
        }
    }
}

/// What came of a run.
fn tell_ending(outcome: &Outcome, json: bool) -> Result<i32, Error> {
    let (ending, folder) = (&outcome.ending, outcome.folder.display());
    let said = match json {
        true => say!("{:#}", outcome.document),
        false => {
            let steps = &outcome.document["steps"];
            say!("{folder}: {steps} steps in {:.1} s", ending.wall)
        }
    };
    if let Some(why) = &ending.why {
        tell!("sillage: {why}");
    }
    if let Some(way_on) = &outcome.way_on {
        tell!("{way_on}");
    }
    // How the run ended counts more than a stdout that is full as well.
    match ending.code {
        exit_code::OK => said.map(|()| exit_code::OK),
        code => Ok(code),
    }
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
