//! The run folder.
//!
//! | file | what |
//! | --- | --- |
//! | `run.json` | scene, versions, machine, cost by phase, worst invariants, exit |
//! | `scene.toml`, `scene.json`, `grains.csv` | the scene as written, as resolved, and its grains |
//! | `steps.csv`, `steps.units.csv` | a row a step; the unit of each column |
//! | `fluid.pvd`, `grains.pvd`, `vtu/` | states for ParaView |
//! | `frames/`, `overview.png` | pictures |
//! | `exchange.mcap` | all that the processes exchanged, when it is recorded |
//! | `logs/` | what the processes said |
//! | `.lock` | held by the run that writes here |
//! | `.reserve` | room for the last `run.json`, while the run goes on |
//! | `.previous/`, `not-started/` | an earlier run until this one has started; what one left that did not |

use std::path::{Path, PathBuf};

use protocol::field::{Field, Support};
use protocol::message::{Diagnostic, Hello, ToOrchestrator};
use protocol::monitor::Event;
use protocol::scene::Geometry;
use scene::{Error, Scene, plan};

use super::previous::Previous;
use super::steps::{Steps, Summary};
use crate::disk::Disk;
use crate::file;
use crate::progress;
use crate::vtu::mesh::Mesh;
use crate::vtu::write::{self, Series, Style};

/// Writes the run folder while a run goes on.
pub struct RunFolder {
    path: PathBuf,
    dimension: usize,
    disks: bool,
    fields: Option<Vec<String>>,
    steps: Steps,
    fluid_series: Series,
    grain_series: Series,
    started: bool,
    mesh: Option<Mesh>,
    grain_radius: Vec<f64>,
    snapshots: usize,
    /// Time of the last state that is written as a whole \[s\].
    states_to: Option<f64>,
    previous: Option<Previous>,
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
        file::write(&path.join("scene.toml"), &scene.text)?;
        Ok(RunFolder {
            path: path.to_path_buf(),
            dimension: scene.dimension(),
            disks: scene.coupler.geometry == Geometry::Disk,
            fields: scene.output.fields.clone(),
            steps: Steps::create(
                path.join("steps.csv"),
                scene.coupler.geometry == Geometry::Disk,
            )?,
            fluid_series: Series::new(path.join("fluid.pvd")),
            grain_series: Series::new(path.join("grains.pvd")),
            started: false,
            mesh: None,
            grain_radius: Vec::new(),
            snapshots: 0,
            states_to: None,
            previous: None,
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
    pub fn summary(&self) -> &Summary {
        &self.steps.summary
    }

    /// An earlier run in the same folder goes as soon as this one has started.
    pub fn replaces(&mut self, previous: Option<Previous>) {
        self.previous = previous;
    }

    /// The earlier run, when this one has not started.
    pub fn not_replaced(&mut self) -> Option<Previous> {
        self.previous.take()
    }

    /// Take over one message of the coupler.
    pub fn take(&mut self, event: &Event, disk: &Disk) -> Result<(), Error> {
        match &event.message {
            ToOrchestrator::Started { engines, .. } => {
                self.engines = engines.clone();
                let radius = values(&event.fields, Field::GrainRadius);
                self.grain_radius = radius.unwrap_or_default().to_vec();
                self.mesh = Mesh::from_fields(self.dimension, &event.fields);
                self.started = true;
                self.previous.take().map_or(Ok(()), Previous::discard)
            }
            ToOrchestrator::Step(values) => self.steps.add(values, disk),
            ToOrchestrator::Snapshot { time, .. } => self.snapshot(*time, &event.fields, disk),
            ToOrchestrator::Finished(totals) | ToOrchestrator::Stopped { totals, .. } => {
                self.totals = totals.clone();
                Ok(())
            }
            ToOrchestrator::RecordingEnded(why) => {
                self.recording_ended = Some(why.clone());
                Ok(())
            }
        }
    }

    fn snapshot(
        &mut self,
        time: f64,
        fields: &[(Field, Vec<f64>)],
        disk: &Disk,
    ) -> Result<(), Error> {
        if !self.started {
            return Ok(());
        }
        let number = self.snapshots;
        self.snapshots += 1;
        let names = self.fields.as_deref();
        let asked = |field: Field| names.map(|names| names.iter().any(|name| name == field.name()));
        let wanted = |field: &Field| asked(*field).unwrap_or(true);
        let of = |support: Support| -> Vec<(Field, &[f64])> {
            fields
                .iter()
                .filter(|(field, _)| field.support() == support && wanted(field))
                .map(|(field, values)| (*field, values.as_slice()))
                .collect()
        };
        let style = Style {
            dimension: self.dimension,
            disks: self.disks,
            time,
        };
        if let Some(mesh) = &self.mesh {
            let content = write::fluid(mesh, &style, &of(Support::Node));
            self.fluid_series
                .add(time, &format!("vtu/fluid_{number:04}.vtu"), &content, disk)?;
        }
        if let Some(position) = values(fields, Field::GrainPosition) {
            let radius = values(fields, Field::GrainRadius).unwrap_or(&self.grain_radius);
            let mut columns: Vec<(Field, &[f64])> = vec![(Field::GrainRadius, radius)];
            let own = |field: &Field| matches!(field, Field::GrainPosition | Field::GrainRadius);
            let others = of(Support::Grain).into_iter();
            columns.extend(others.filter(|(field, _)| !own(field)));
            // Where nobody leaves they are numbers in a row, for who asks.
            let told = values(fields, Field::GrainId).is_some();
            let in_a_row = || (0..radius.len()).map(|id| id as f64).collect();
            let id: Option<Vec<f64>> =
                (!told && asked(Field::GrainId) == Some(true)).then(in_a_row);
            columns.extend(id.as_deref().map(|id| (Field::GrainId, id)));
            let content = write::grains(&style, position, &columns);
            self.grain_series
                .add(time, &format!("vtu/grains_{number:04}.vtu"), &content, disk)?;
        }
        self.states_to = Some(time);
        Ok(())
    }

    /// Up to where it is complete.
    pub fn reached(&self) -> String {
        let Summary { steps, time, .. } = self.summary();
        let states = self.states_to.map_or("no state".to_owned(), |time| {
            format!("states to t = {} s", progress::digits(time))
        });
        let time = progress::digits(*time);
        format!("step {steps}, t = {time} s, {states}")
    }
}

fn values(fields: &[(Field, Vec<f64>)], wanted: Field) -> Option<&[f64]> {
    fields
        .iter()
        .find(|(field, _)| *field == wanted)
        .map(|(_, values)| values.as_slice())
}
