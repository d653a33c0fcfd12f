//! The run folder.
//!
//! | file | what |
//! | --- | --- |
//! | `run.json` | scene, versions, machine, cost by phase, worst invariants, exit |
//! | `scene.toml`, `scene.json`, `grains.csv` | the scene as written, as resolved, and its grains |
//! | `steps.csv` | a row a step |
//! | `fluid.pvd`, `grains.pvd`, `vtu/` | states for ParaView |
//! | `frames/`, `overview.png` | pictures |
//! | `exchange.mcap` | all that the processes exchanged, when it is recorded |
//! | `logs/` | what the processes said |

pub mod machine;
pub mod mesh;
pub mod picture;
pub mod report;
pub mod steps;
pub mod vtu;
pub mod writer;

use std::path::{Path, PathBuf};

use protocol::field::{Field, Support};
use protocol::messages::{Diagnostic, Hello, ToOrchestrator};
use protocol::monitor::Event;

use crate::error::Error;
use crate::plan;
use crate::scene::Scene;
use mesh::Mesh;
use picture::axes::round_up;
use picture::overview::{Album, overview};
use picture::state::{Stage, State};
use steps::Steps;
use vtu::Series;

/// Writes the run folder while a run goes on.
pub struct RunFolder {
    path: PathBuf,
    fields: Option<Vec<String>>,
    frames: bool,
    walls: Vec<[[f64; 2]; 2]>,
    name: String,
    grain_fixed: Vec<bool>,
    steps: Steps,
    fluid_series: Series,
    grain_series: Series,
    stage: Option<Stage>,
    album: Album,
    speed_max: f64,
    snapshots: usize,
    /// Who took part.
    pub engines: Vec<Hello>,
    /// Totals the coupler sent at the end.
    pub totals: Vec<Diagnostic>,
    /// Why the recording ended before the run, when it did.
    pub recording_ended: Option<String>,
}

impl RunFolder {
    /// Make the folder of a run and write what is known before it starts.
    pub fn create(path: &Path, scene: &Scene) -> Result<RunFolder, Error> {
        plan::write_inputs(scene, path)?;
        for folder in ["logs", "vtu", "frames"] {
            let folder = path.join(folder);
            std::fs::create_dir_all(&folder).map_err(Error::file("cannot create", &folder))?;
        }
        vtu::write(&path.join("scene.toml"), &scene.text)?;
        let walls = scene
            .coupler
            .particles
            .iter()
            .flat_map(|particles| &particles.walls);
        Ok(RunFolder {
            path: path.to_path_buf(),
            fields: scene.output.fields.clone(),
            frames: scene.output.frames,
            walls: walls.map(|wall| [wall.a, wall.b]).collect(),
            name: scene.name.clone(),
            grain_fixed: scene.grains.fixed.clone(),
            steps: Steps::create(path.join("steps.csv"))?,
            fluid_series: Series::new(path.join("fluid.pvd")),
            grain_series: Series::new(path.join("grains.pvd")),
            stage: None,
            album: Album::default(),
            speed_max: 0.0,
            snapshots: 0,
            engines: Vec::new(),
            totals: Vec::new(),
            recording_ended: None,
        })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was summed up from the steps.
    pub fn summary(&self) -> &steps::Summary {
        &self.steps.summary
    }

    /// Take over one message of the coupler.
    pub fn take(&mut self, event: Event) -> Result<(), Error> {
        match event.message {
            ToOrchestrator::Started { engines, .. } => {
                self.engines = engines;
                self.set_stage(&event.fields);
                Ok(())
            }
            ToOrchestrator::Step(values) => self.steps.add(&values),
            ToOrchestrator::Snapshot { time, .. } => self.snapshot(time, &event.fields),
            ToOrchestrator::Finished(totals) | ToOrchestrator::Stopped { totals, .. } => {
                self.totals = totals;
                Ok(())
            }
            ToOrchestrator::RecordingEnded(why) => {
                self.recording_ended = Some(why);
                Ok(())
            }
        }
    }

    fn set_stage(&mut self, fields: &[(Field, Vec<f64>)]) {
        let radius = values(fields, Field::GrainRadius)
            .unwrap_or_default()
            .to_vec();
        let mesh = Mesh::from_fields(fields);
        self.stage = Some(Stage::new(
            &self.name,
            mesh,
            &self.walls,
            radius,
            self.grain_fixed.clone(),
        ));
    }

    fn snapshot(&mut self, time: f64, fields: &[(Field, Vec<f64>)]) -> Result<(), Error> {
        let Some(stage) = &mut self.stage else {
            return Ok(());
        };
        let number = self.snapshots;
        self.snapshots += 1;
        let wanted = |field: &Field| match &self.fields {
            Some(names) => names.iter().any(|name| name == field.name()),
            None => true,
        };
        let of = |support: Support| -> Vec<(Field, &[f64])> {
            fields
                .iter()
                .filter(|(field, _)| field.support() == support && wanted(field))
                .map(|(field, values)| (*field, values.as_slice()))
                .collect()
        };
        if let Some(mesh) = &stage.mesh {
            let content = vtu::fluid(mesh, &of(Support::Node));
            self.fluid_series
                .add(time, &format!("vtu/fluid_{number:04}.vtu"), &content)?;
        }
        if let Some(position) = values(fields, Field::GrainPosition) {
            let mut columns: Vec<(Field, &[f64])> = vec![(Field::GrainRadius, &stage.grain_radius)];
            columns.extend(
                of(Support::Grain)
                    .into_iter()
                    .filter(|(field, _)| *field != Field::GrainPosition),
            );
            let content = vtu::grains(position, &columns);
            self.grain_series
                .add(time, &format!("vtu/grains_{number:04}.vtu"), &content)?;
        }
        if self.frames {
            let state = state(time, fields);
            stage.widen(&state);
            // The scale only grows, in round steps, so that successive pictures can be compared.
            self.speed_max = self.speed_max.max(round_up(state.speed_max()));
            let picture = picture::frame::frame(stage, &state, self.speed_max);
            picture.save(&self.path.join(format!("frames/{number:04}.png")))?;
            self.album.add(state);
        }
        Ok(())
    }

    /// Draw the contact sheet.
    pub fn finish(&mut self) -> Result<(), Error> {
        let Some(stage) = &self.stage else {
            return Ok(());
        };
        match overview(stage, &self.album.states()) {
            Some(picture) => picture.save(&self.path.join("overview.png")),
            None => Ok(()),
        }
    }
}

fn values(fields: &[(Field, Vec<f64>)], wanted: Field) -> Option<&[f64]> {
    fields
        .iter()
        .find(|(field, _)| *field == wanted)
        .map(|(_, values)| values.as_slice())
}

/// What pictures need of a snapshot.
fn state(time: f64, fields: &[(Field, Vec<f64>)]) -> State {
    let pairs = |wanted: Field| -> Vec<[f32; 2]> {
        let values = values(fields, wanted).unwrap_or_default();
        values
            .chunks_exact(2)
            .map(|pair| [pair[0] as f32, pair[1] as f32])
            .collect()
    };
    let speeds = pairs(Field::GrainVelocity)
        .iter()
        .map(|v| v[0].hypot(v[1]))
        .collect();
    State {
        time,
        fluid_velocity: pairs(Field::InterstitialVelocity),
        grain_position: pairs(Field::GrainPosition),
        grain_speed: speeds,
    }
}
