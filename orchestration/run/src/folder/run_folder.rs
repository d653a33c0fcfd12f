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
//! | `checkpoints/` | what a run that is resumed goes on from |
//! | `failed-step.mcap` | the step that ended the run, from the last checkpoint |
//! | `logs/` | what the processes said |
//! | `.lock` | held by the run that writes here |
//! | `.reserve` | room for the last `run.json`, while the run goes on |
//! | `.previous/`, `not-started/` | an earlier run until this one has started; what one left that did not |

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Instant;

use protocol::field::{Field, Support};
use protocol::message::{Diagnostic, Hello, ToOrchestrator};
use protocol::monitor::Event;
use protocol::monitor::columns::Kind;
use protocol::scene::Geometry;
use scene::{Error, Scene, plan};

use super::checkpoint::{self, Checkpoint};
use super::outputs::{Outputs, Resumption};
use super::previous::Previous;
use super::steps::{Steps, Summary};
use crate::disk::Disk;
use crate::failed_step;
use crate::file::{self, seconds_since_1970};
use crate::progress;
use crate::tell;
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
    keeping: Keeping,
    /// Who took part.
    pub engines: Vec<Hello>,
    /// Totals the coupler sent at the end.
    pub totals: Vec<Diagnostic>,
    /// Why the recording ended before the run, when it did.
    pub recording_ended: Option<String>,
}

/// What is kept of the run.
struct Keeping {
    /// How many checkpoints stay.
    count: u32,
    begun: Instant,
    /// Wall time of the run before this process \[s\].
    wall_before: f64,
    /// States that are on the disk for good.
    synced: usize,
    /// Where the run was resumed.
    resumed: Vec<Resumption>,
    /// Step of the last checkpoint.
    last: Option<u64>,
    /// Why there is none of a later step.
    trouble: Option<String>,
}

impl Keeping {
    fn new(count: u32) -> Keeping {
        Keeping {
            count,
            begun: Instant::now(),
            wall_before: 0.0,
            synced: 0,
            resumed: Vec::new(),
            last: None,
            trouble: None,
        }
    }
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
        let steps = Steps::create(path.join("steps.csv"), kind(scene))?;
        Ok(RunFolder::with(path, scene, steps))
    }

    /// The folder of a run that goes on from a checkpoint: what was put out after it is cut off.
    pub fn resume(path: &Path, scene: &Scene, checkpoint: &Checkpoint) -> Result<RunFolder, Error> {
        let Checkpoint {
            step,
            time,
            outputs,
            ..
        } = checkpoint;
        // Later checkpoints first: they say what is about to be cut off.
        checkpoint::forget_after(path, *step)?;
        let table = outputs.steps.clone();
        let steps = Steps::resume(path.join("steps.csv"), kind(scene), table)?;
        let mut folder = RunFolder::with(path, scene, steps);
        folder.fluid_series = Series::resume(path.join("fluid.pvd"), outputs.fluid.clone())?;
        folder.grain_series = Series::resume(path.join("grains.pvd"), outputs.grains.clone())?;
        folder.snapshots = outputs.states;
        folder.states_to = outputs.states_to;
        folder.keeping.wall_before = outputs.wall;
        folder.keeping.synced = outputs.states;
        folder.keeping.last = Some(*step);
        folder.keeping.resumed.clone_from(&outputs.resumed);
        folder.keeping.resumed.push(Resumption {
            step: *step,
            time: *time,
            written: seconds_since_1970(),
        });
        folder.forget_states()?;
        Ok(folder)
    }

    fn with(path: &Path, scene: &Scene, steps: Steps) -> RunFolder {
        RunFolder {
            path: path.to_path_buf(),
            dimension: scene.dimension(),
            disks: kind(scene) == Kind::Disks,
            fields: scene.output.fields.clone(),
            steps,
            fluid_series: Series::new(path.join("fluid.pvd")),
            grain_series: Series::new(path.join("grains.pvd")),
            started: false,
            mesh: None,
            grain_radius: Vec::new(),
            snapshots: 0,
            states_to: None,
            previous: None,
            keeping: Keeping::new(scene.checkpoint.keep),
            engines: Vec::new(),
            totals: Vec::new(),
            recording_ended: None,
        }
    }

    /// States that are in no list go, and what a step that failed left.
    fn forget_states(&self) -> Result<(), Error> {
        let _ = std::fs::remove_file(self.path.join(failed_step::FILE));
        let listed = self.fluid_series.entries().iter();
        let listed: BTreeSet<&str> = listed
            .chain(self.grain_series.entries())
            .map(|(_, name)| name.as_str())
            .collect();
        let entries = std::fs::read_dir(self.path.join("vtu"))
            .into_iter()
            .flatten();
        for entry in entries.flatten() {
            let name = format!("vtu/{}", entry.file_name().to_string_lossy());
            if !listed.contains(name.as_str()) {
                let path = entry.path();
                std::fs::remove_file(&path).map_err(Error::file("cannot remove", &path))?;
            }
        }
        Ok(())
    }

    /// Complete the checkpoint of a step, once all that was put out before is on the disk. `pictures`: what
    /// draws needs to go on.
    pub fn keep(
        &mut self,
        (step, time): (u64, f64),
        pictures: String,
        disk: &Disk,
    ) -> Result<(), Error> {
        if !checkpoint::is_drafted(&self.path, step) {
            self.keeping.trouble = Some(format!("the draft of step {step} is gone"));
            return Ok(());
        }
        let outputs = Outputs {
            steps: self.steps.table().clone(),
            fluid: self.fluid_series.entries().clone(),
            grains: self.grain_series.entries().clone(),
            states: self.snapshots,
            states_to: self.states_to,
            pictures,
            resumed: self.keeping.resumed.clone(),
            wall: self.wall(),
        };
        let mut broken = None;
        disk.attempt(|| match self.complete((step, time), &outputs) {
            // A disk that is full is waited for, as for all that is put out; nothing else may end the run.
            Err(Error::File { source, .. }) if source.kind() == ErrorKind::StorageFull => {
                Err(Error::file("cannot write", &self.path)(source))
            }
            Err(error) => {
                broken = Some(error.to_string());
                Ok(())
            }
            Ok(()) => Ok(()),
        })?;
        if let Some(why) = broken {
            let why = format!("step {step} could not be kept: {why}");
            tell!("no checkpoint: {why}");
            self.keeping.trouble = Some(why);
            return Ok(());
        }
        self.keeping.synced = self.snapshots;
        (self.keeping.last, self.keeping.trouble) = (Some(step), None);
        Ok(())
    }

    fn complete(&self, moment: (u64, f64), outputs: &Outputs) -> Result<(), Error> {
        self.steps.sync()?;
        self.fluid_series.sync(self.keeping.synced)?;
        self.grain_series.sync(self.keeping.synced)?;
        let count = self.keeping.count;
        checkpoint::complete(&self.path, moment, &self.engines, outputs, count)
    }

    /// Wall time of the run so far \[s\], that before it was resumed included.
    pub fn wall(&self) -> f64 {
        self.keeping.wall_before + self.keeping.begun.elapsed().as_secs_f64()
    }

    /// Where the run was resumed.
    pub fn resumed(&self) -> &[Resumption] {
        &self.keeping.resumed
    }

    /// Step of the last checkpoint, and why there is none of a later one.
    pub fn kept(&self) -> (Option<u64>, Option<&str>) {
        (self.keeping.last, self.keeping.trouble.as_deref())
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was summed up from the steps.
    pub fn summary(&self) -> &Summary {
        &self.steps.table().summary
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
            ToOrchestrator::Mesh { .. } => {
                self.mesh = Mesh::from_fields(self.dimension, &event.fields);
                Ok(())
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
            ToOrchestrator::NoCheckpoint(why) => {
                self.keeping.trouble = Some(why.clone());
                Ok(())
            }
            // Kept with what draws says of itself, by `keep`.
            ToOrchestrator::Checkpoint { .. } => Ok(()),
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

fn kind(scene: &Scene) -> Kind {
    match (scene.dimension(), scene.coupler.geometry) {
        (2, Geometry::Disk) => Kind::Disks,
        (2, Geometry::Sphere { .. }) => Kind::Slab,
        _ => Kind::Space,
    }
}

fn values(fields: &[(Field, Vec<f64>)], wanted: Field) -> Option<&[f64]> {
    fields
        .iter()
        .find(|(field, _)| *field == wanted)
        .map(|(_, values)| values.as_slice())
}
