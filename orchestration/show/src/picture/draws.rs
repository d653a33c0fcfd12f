//! The pictures of a run while it goes on: a frame a state, a contact sheet at the end.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use protocol::field::Field;
use protocol::message::ToOrchestrator;
use protocol::monitor::Event;
use protocol::scene::{Wall, fixed};
use run::disk::Disk;
use run::folder::draw::Draw;
use run::vtu::mesh::Mesh;
use run::vtu::read as vtu;
use run::vtu::write::Entries;
use scene::{Error, Scene};
use serde::{Deserialize, Serialize};

use super::album::{Album, Shown};
use super::axes::round_up;
use super::depict::Depict;
use super::state::{Stage, State};
use crate::simplices::{Point, Simplices, chunks};

/// What draws a scene into its run folder.
pub fn pictures(scene: &Scene, folder: &Path) -> Box<dyn Draw> {
    match scene.dimension() {
        3 => Box::new(Drawing::<3, 4>::new(scene, folder)),
        _ => Box::new(Drawing::<2, 3>::new(scene, folder)),
    }
}

/// A wall by its corners; none of another dimension.
fn facet<const D: usize>(wall: &Wall) -> Option<[Point<D>; D]> {
    let corners = wall.corners.iter().map(|corner| fixed(corner).ok());
    let corners: Vec<Point<D>> = corners.collect::<Option<_>>()?;
    corners.try_into().ok()
}

struct Drawing<const D: usize, const N: usize> {
    folder: PathBuf,
    wanted: bool,
    name: String,
    walls: Vec<[Point<D>; D]>,
    grain_fixed: Vec<bool>,
    stage: Option<Stage<D, N>>,
    album: Album<D, N>,
    /// Speed of the deepest colour \[m/s\].
    speed_max: f64,
    frames: usize,
    /// The mesh since it followed the grains for the last time; none: that of the stage.
    mesh: Option<Arc<Simplices<D, N>>>,
    /// Did it before this run was resumed?
    moves: bool,
    /// Of a run that goes on, until it does.
    kept: Option<Kept>,
}

impl<const D: usize, const N: usize> Draw for Drawing<D, N>
where
    Stage<D, N>: Depict<D, N>,
{
    fn take(&mut self, event: &Event, disk: &Disk) -> Result<(), Error> {
        if !self.wanted {
            return Ok(());
        }
        match &event.message {
            ToOrchestrator::Started { .. } => return self.set_stage(&event.fields),
            ToOrchestrator::Mesh { .. } => {
                let mesh = Mesh::from_fields(D, &event.fields);
                self.mesh = mesh.and_then(Simplices::of).map(Arc::new);
            }
            ToOrchestrator::Snapshot { time, .. } => {
                let mesh = self.mesh.clone();
                let state = State {
                    mesh,
                    ..state(*time, &event.fields)
                };
                return self.frame(state, disk);
            }
            _ => {}
        }
        Ok(())
    }

    fn keep(&self) -> String {
        let moved = self.mesh.is_some() || self.moves;
        let stage = self.stage.as_ref().filter(|_| moved);
        let kept = Kept {
            speed_max: self.speed_max,
            frames: self.frames,
            outlines: stage.map(|stage| {
                stage
                    .outlines
                    .iter()
                    .map(|ends| ends.map(Vec::from))
                    .collect()
            }),
            window: self
                .stage
                .as_ref()
                .map(|stage| (stage.window.0.into(), stage.window.1.into())),
            shown: self.album.shown(),
        };
        serde_json::to_string(&kept).unwrap_or_default()
    }

    fn resume(&mut self, kept: &str) -> Result<(), Error> {
        let kept: Kept = serde_json::from_str(kept).map_err(|error| Error::Picture {
            path: self.folder.join("frames"),
            why: format!("what was kept of them cannot be read: {error}"),
        })?;
        (self.speed_max, self.frames) = (kept.speed_max, kept.frames);
        self.kept = Some(kept);
        self.forget_frames()
    }

    fn finish(&mut self, disk: &Disk) -> Result<(), Error> {
        let Some(stage) = &self.stage else {
            return Ok(());
        };
        match stage.overview(&self.album.states()) {
            Some(picture) => {
                let path = self.folder.join("overview.png");
                disk.write(&path, picture.png(&path)?)
            }
            None => Ok(()),
        }
    }
}

/// What pictures need to go on. The states of the contact sheet are read back from the files for ParaView.
#[derive(Serialize, Deserialize)]
struct Kept {
    speed_max: f64,
    frames: usize,
    window: Option<(Vec<f64>, Vec<f64>)>,
    /// Those of the first mesh, where it has followed the grains since.
    outlines: Option<Vec<[Vec<f64>; 2]>>,
    shown: Shown,
}

/// A point that was kept.
fn point<const D: usize>(numbers: &[f64]) -> Option<Point<D>> {
    numbers.try_into().ok()
}

impl<const D: usize, const N: usize> Drawing<D, N>
where
    Stage<D, N>: Depict<D, N>,
{
    fn new(scene: &Scene, folder: &Path) -> Self {
        let walls = scene.coupler.particles.iter();
        let walls = walls.flat_map(|particles| &particles.walls);
        Drawing {
            folder: folder.to_path_buf(),
            wanted: scene.output.frames && scene.dimension() == D,
            name: scene.name.clone(),
            walls: walls.filter_map(facet).collect(),
            grain_fixed: scene.grains.fixed.clone(),
            stage: None,
            album: Album::default(),
            speed_max: 0.0,
            frames: 0,
            mesh: None,
            moves: false,
            kept: None,
        }
    }

    /// Frames that were drawn after the checkpoint go.
    fn forget_frames(&self) -> Result<(), Error> {
        let entries = std::fs::read_dir(self.folder.join("frames"))
            .into_iter()
            .flatten();
        for entry in entries.flatten() {
            let (name, path) = (entry.file_name(), entry.path());
            let number = name.to_str().and_then(|name| name.strip_suffix(".png"));
            let number = number.and_then(|digits| digits.parse::<usize>().ok());
            if number.is_some_and(|number| number >= self.frames) {
                std::fs::remove_file(&path).map_err(Error::file("cannot remove", &path))?;
            }
        }
        Ok(())
    }

    fn set_stage(&mut self, fields: &[(Field, Vec<f64>)]) -> Result<(), Error> {
        let mesh = Mesh::from_fields(D, fields);
        let nodes = mesh.as_ref().map_or(0, |mesh| mesh.node_count);
        let mut stage = Stage::new(
            &self.name,
            mesh.and_then(Simplices::of),
            &self.walls,
            values(fields, Field::GrainRadius).to_vec(),
            self.grain_fixed.clone(),
        );
        stage.outlines = Stage::outlines(stage.mesh.as_ref(), &self.walls);
        if let Some(kept) = self.kept.take() {
            let Kept {
                window,
                shown,
                outlines,
                ..
            } = kept;
            if let Some((low, high)) = window
                && let (Some(low), Some(high)) = (point(&low), point(&high))
            {
                stage.window = (low, high);
            }
            self.moves = outlines.is_some();
            if let Some(outlines) = outlines {
                let ends = |[a, b]: &[Vec<f64>; 2]| Some([point(a)?, point(b)?]);
                stage.outlines = outlines.iter().filter_map(ends).collect();
            }
            let nodes = (!self.moves).then_some(nodes);
            let lists = ["fluid.pvd", "grains.pvd"].map(|list| vtu::list(&self.folder.join(list)));
            let [fluid, grains] = lists;
            let lists = [fluid?, grains?];
            let state = |number| kept_state(&self.folder, &lists, nodes, number);
            self.album = Album::again(shown, state)?;
        }
        self.stage = Some(stage);
        Ok(())
    }

    fn frame(&mut self, state: State<D, N>, disk: &Disk) -> Result<(), Error> {
        let Some(stage) = &mut self.stage else {
            return Ok(());
        };
        stage.widen(&state);
        // The scale only grows, in round steps, so that successive pictures can be compared.
        self.speed_max = self.speed_max.max(round_up(state.speed_max()));
        let picture = stage.frame(&state, self.speed_max);
        let number = self.frames;
        let path = self.folder.join(format!("frames/{number:04}.png"));
        disk.write(&path, picture.png(&path)?)?;
        self.frames += 1;
        self.album.add(state);
        Ok(())
    }
}

/// A state as it was put out, on so many nodes: the first points of its file; none: on a mesh of its own. What that
/// lacks is not drawn.
fn kept_state<const D: usize, const N: usize>(
    folder: &Path,
    [fluid, grains]: &[Entries; 2],
    nodes: Option<usize>,
    number: usize,
) -> Result<State<D, N>, Error> {
    let read = |list: &Entries| -> Result<Option<(f64, vtu::State)>, Error> {
        let Some((time, file)) = list.get(number) else {
            return Ok(None);
        };
        Ok(Some((*time, vtu::State::read(&folder.join(file))?)))
    };
    let single = |vector: Point<D>| vector.map(|component| component as f32);
    let mut state = State::default();
    if let Some((time, fluid)) = read(fluid)? {
        state.time = time;
        let mesh = match nodes {
            Some(_) => None,
            None => Simplices::of_state(&fluid)?,
        };
        let own = mesh.as_ref().map(|mesh| mesh.node_count);
        state.mesh = mesh.map(Arc::new);
        let velocity = fluid.vectors::<D>(Field::InterstitialVelocity.name())?;
        let velocity = velocity.unwrap_or_default().into_iter();
        state.fluid_velocity = velocity
            .take(nodes.or(own).unwrap_or(0))
            .map(single)
            .collect();
    }
    if let Some((time, grains)) = read(grains)? {
        state.time = time;
        let position = grains.vectors::<D>("position")?.unwrap_or_default();
        state.grain_position = position.into_iter().map(single).collect();
        let velocity = grains.vectors::<D>(Field::GrainVelocity.name())?;
        let speeds = velocity.unwrap_or_default().into_iter().map(single);
        state.grain_speed = speeds.map(speed).collect();
        let id = grains.numbers(Field::GrainId.name())?.unwrap_or_default();
        state.grain_id = id.into_iter().map(|id| id as u32).collect();
    }
    Ok(state)
}

/// The values of a field; none of one that was not sent.
fn values(fields: &[(Field, Vec<f64>)], wanted: Field) -> &[f64] {
    let found = fields.iter().find(|(field, _)| *field == wanted);
    found.map_or(&[], |(_, values)| values.as_slice())
}

/// Length of a velocity, as exact as it is kept.
fn speed<const D: usize>(velocity: [f32; D]) -> f32 {
    velocity.into_iter().fold(0.0, f32::hypot)
}

/// What pictures need of a snapshot.
fn state<const D: usize, const N: usize>(time: f64, fields: &[(Field, Vec<f64>)]) -> State<D, N> {
    let vectors = |wanted: Field| -> Vec<[f32; D]> {
        let vectors = chunks::<f64, D>(values(fields, wanted)).into_iter();
        vectors.map(|v| v.map(|x| x as f32)).collect()
    };
    let speeds = vectors(Field::GrainVelocity).into_iter().map(speed);
    let id = values(fields, Field::GrainId).iter().map(|&id| id as u32);
    State {
        time,
        mesh: None,
        fluid_velocity: vectors(Field::InterstitialVelocity),
        grain_position: vectors(Field::GrainPosition),
        grain_speed: speeds.collect(),
        grain_id: id.collect(),
    }
}
