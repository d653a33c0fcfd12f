//! Where each coupling scheme is stable.
//!
//! ```text
//!   maps = pairs of axes ─► cells × schemes ─► small scenes, run as real processes, some at a time
//!                                                  │ cells/MAP/X_Y/SCHEME: a run folder, point.json
//!         table, CSV, JSON, heat maps ◄── verdicts ◄──┘ when it is over: it is not run again
//! ```

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use protocol::scene::Geometry;
use run::batch::{self, Clock};
use run::folder::claim::Claim;
use run::progress::Gauge;
use run::{Runner, Voice};
use scene::document::Document;
use scene::{Error, Scene};
use serde_json::{Value, json};
use show::picture::pictures;
use show::table::Table;

use crate::dimension::Dimension;
use crate::heat;
use crate::maps::{self, Map};
use crate::results::{self, Cell, MapResult};
use crate::scenes::Case;
use crate::schemes::{DEFAULT, SCHEMES};
use crate::verdict::{self, Finding};

/// The folder of the maps.
const STABILITY: Claim = Claim {
    what: "maps",
    mark: "stability.json",
    parts: &["cells"],
};

/// One scheme at one point of a map.
#[derive(Debug, Clone, Copy)]
struct Job {
    map: usize,
    across: usize,
    up: usize,
    scheme: usize,
}

/// What was found.
pub struct Outcome {
    /// `stability.json`.
    pub document: Value,
    /// The maps as text.
    pub text: String,
    /// Cells and schemes that were to run.
    pub cells: usize,
    /// Cells in which the default scheme fails.
    pub failed: usize,
    /// Was it interrupted?
    pub interrupted: bool,
}

/// Run what is not there yet of these maps into a folder, `workers` at a time; `quick` takes a few
/// points of each axis.
pub fn stability(
    maps: &[Map],
    quick: bool,
    folder: &Path,
    workers: usize,
) -> Result<Outcome, Error> {
    STABILITY.check(folder)?;
    std::fs::create_dir_all(folder)
        .map_err(|error| Error::Usage(format!("cannot create {}: {error}", folder.display())))?;
    let jobs = jobs(maps, quick);
    let (findings, interrupted) = run_all(maps, &jobs, folder, workers)?;
    let results = collect(maps, &jobs, findings, quick);
    let document = results::document(&results, quick, !interrupted);
    results::write(folder, &document, &results)?;
    heat::write(folder, &results)?;
    Ok(Outcome {
        document,
        text: results::text(&results),
        cells: jobs.len(),
        failed: results::failed(&results),
        interrupted,
    })
}

/// The maps of these names; all of them for none.
pub fn chosen(dimension: Dimension, names: &[String]) -> Result<Vec<Map>, Error> {
    let mut maps = maps::all(dimension);
    let known: Vec<&str> = maps.iter().map(|map| map.name).collect();
    if let Some(unknown) = names.iter().find(|name| !known.contains(&name.as_str())) {
        let meant = scene::read::nearest(unknown, &known)
            .map_or(String::new(), |name| format!("; did you mean {name}?"));
        return Err(Error::Usage(format!(
            "--axes {unknown}: no such pair{meant} (pairs: {})",
            known.join(", ")
        )));
    }
    if !names.is_empty() {
        maps.retain(|map| names.iter().any(|name| name == map.name));
    }
    Ok(maps)
}

/// The maps and what is run at their points, as JSON.
pub fn list(maps: &[Map]) -> Value {
    let entry = |map: &Map| {
        json!({
            "name": map.name,
            "title": map.title,
            "dimension": map.dimension.axes(),
            "across": { "name": map.across.name, "values": map.across.labels },
            "up": { "name": map.up.name, "values": map.up.labels },
        })
    };
    json!(maps.iter().map(entry).collect::<Vec<_>>())
}

/// Every cell; `--quick` takes the default at a few places of each axis, the others at the corners.
fn jobs(maps: &[Map], quick: bool) -> Vec<Job> {
    let mut jobs = Vec::new();
    for (number, map) in maps.iter().enumerate() {
        for up in map.up.places(quick) {
            for across in map.across.places(quick) {
                let corner = map.across.is_end(across) && map.up.is_end(up);
                for (scheme, (name, _)) in SCHEMES.iter().enumerate() {
                    let default = *name == DEFAULT;
                    if default || map.coupled && (!quick || corner) {
                        jobs.push(Job {
                            map: number,
                            across,
                            up,
                            scheme,
                        });
                    }
                }
            }
        }
    }
    jobs
}

/// Run what is not there yet, `workers` at a time; a finding a job, none where interrupted.
fn run_all(
    maps: &[Map],
    jobs: &[Job],
    folder: &Path,
    workers: usize,
) -> Result<(Vec<Option<Finding>>, bool), Error> {
    let runner = Runner::new(Voice::Quiet, pictures)?;
    let next = AtomicUsize::new(0);
    let clock = Mutex::new((Clock::new(jobs.len()), Gauge::default()));
    let findings: Vec<Mutex<Option<Finding>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let work = || -> Result<(), Error> {
        while runner.interrupts.so_far() == 0 {
            let index = next.fetch_add(1, Ordering::SeqCst);
            let Some(job) = jobs.get(index) else { break };
            let (finding, fresh) = one(maps, job, folder, &runner)?;
            *findings[index].lock().expect("no worker panics") = finding;
            let (clock, gauge) = &mut *clock.lock().expect("no worker panics");
            if fresh {
                clock.ran()
            } else {
                clock.skip()
            }
            gauge.show(&clock.line());
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        let ends = threads
            .into_iter()
            .map(|thread| thread.join().expect("no worker panics"));
        ends.collect::<Result<Vec<()>, Error>>()
    })?;
    clock.into_inner().expect("no worker panics").1.finish();
    let findings = findings
        .into_iter()
        .map(|own| own.into_inner().expect("no worker panics"));
    Ok((findings.collect(), runner.interrupts.so_far() > 0))
}

/// The finding of a job, and whether it had to be run.
fn one(
    maps: &[Map],
    job: &Job,
    folder: &Path,
    runner: &Runner,
) -> Result<(Option<Finding>, bool), Error> {
    let map = &maps[job.map];
    let case = map.case(job.across, job.up);
    let settings = settings(map, job.scheme);
    let scene = match load(map, &case, &settings) {
        Ok(scene) => scene,
        Err(Error::Scene(problems)) => {
            return Ok((Some(Finding::refused(problems.to_string())), false));
        }
        Err(error) => return Err(error),
    };
    let place = place(folder, map, job);
    let mark = batch::mark(&scene, &settings);
    let (done, fresh) = match batch::known(&place, &mark) {
        Some(done) => (Some(done), false),
        None => (batch::one(&scene, &place, &mark, runner)?, true),
    };
    let Some(done) = done else {
        return Ok((None, fresh));
    };
    let steps = Table::read(&place.join("steps.csv"))?;
    Ok((Some(verdict::judge(&case, &done, &steps)), fresh))
}

fn settings(map: &Map, scheme: usize) -> Vec<String> {
    let mut settings = vec![
        "output.frames=false".to_string(),
        "output.fields=[]".to_string(),
        format!(
            "limits.step={:e}",
            verdict::seconds(SCHEMES[scheme].0 == DEFAULT)
        ),
    ];
    if map.coupled {
        settings.push(format!("coupling.scheme={}", SCHEMES[scheme].1));
        if SCHEMES[scheme].0 != DEFAULT {
            // What the default asks of contacts for its own tolerance: only schemes are compared.
            settings.push("contact.tolerance=1e-6".to_string());
        }
    }
    settings
}

fn load(map: &Map, case: &Case, settings: &[String]) -> Result<Scene, Error> {
    let name = PathBuf::from(map.name).with_extension("toml");
    let document = Document::parse(&name, case.text.clone(), settings)?;
    let mut scene = scene::from_document(&document, 1)?;
    if let Some(depth) = case.thin_slab {
        scene.coupler.geometry = Geometry::Sphere { depth };
    }
    Ok(scene)
}

fn place(folder: &Path, map: &Map, job: &Job) -> PathBuf {
    let (across, up) = (&map.across.labels[job.across], &map.up.labels[job.up]);
    folder
        .join("cells")
        .join(map.name)
        .join(batch::folder_name(&format!("{across}_{up}")))
        .join(SCHEMES[job.scheme].0)
}

fn collect(
    maps: &[Map],
    jobs: &[Job],
    findings: Vec<Option<Finding>>,
    quick: bool,
) -> Vec<MapResult> {
    let mut results: Vec<MapResult> = maps.iter().map(|map| MapResult::new(map, quick)).collect();
    for (job, finding) in jobs.iter().zip(findings) {
        let Some(finding) = finding else { continue };
        let map = &maps[job.map];
        let case = map.case(job.across, job.up);
        results[job.map].cells.push(Cell {
            across: job.across,
            up: job.up,
            scheme: SCHEMES[job.scheme].0,
            limit: case.limit.value,
            steps_asked: case.steps,
            finding,
        });
    }
    results
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_quick_cell_is_refused() {
        println!("| map | dimension | cells | most grains |");
        let dimensions = [Dimension::Plane, Dimension::Space];
        for map in dimensions.into_iter().flat_map(maps::all) {
            let (mut cells, mut most) = (0, 0);
            for job in jobs(std::slice::from_ref(&map), true) {
                let case = map.case(job.across, job.up);
                let scene = load(&map, &case, &settings(&map, job.scheme));
                let scene = scene.unwrap_or_else(|error| panic!("{}: {error}", map.name));
                (cells, most) = (cells + 1, most.max(scene.grains.len()));
            }
            println!(
                "| {} | {} | {cells} | {most} |",
                map.name,
                map.dimension.axes()
            );
        }
    }
}
