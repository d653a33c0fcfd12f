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

use super::axes::round_up;
use super::frame::frame;
use super::overview::{Album, Shown, overview};
use super::state::{Stage, State};
use crate::plane::{Point, Triangles};

/// A wall of the plane, where pictures are; none of another dimension.
fn segment(wall: &Wall) -> Option<[[f64; 2]; 2]> {
    match &wall.corners[..] {
        [a, b] => Some([fixed(a).ok()?, fixed(b).ok()?]),
        _ => None,
    }
}

/// What draws a scene into its run folder; there are pictures of the plane only.
pub fn pictures(scene: &Scene, folder: &Path) -> Box<dyn Draw> {
    let walls = scene
        .coupler
        .particles
        .iter()
        .flat_map(|particles| &particles.walls);
    Box::new(Drawing {
        folder: folder.to_path_buf(),
        wanted: scene.output.frames && scene.dimension() == 2,
        name: scene.name.clone(),
        walls: walls.filter_map(segment).collect(),
        grain_fixed: scene.grains.fixed.clone(),
        stage: None,
        album: Album::default(),
        speed_max: 0.0,
        frames: 0,
        mesh: None,
        moves: false,
        kept: None,
    })
}

struct Drawing {
    folder: PathBuf,
    wanted: bool,
    name: String,
    walls: Vec<[Point; 2]>,
    grain_fixed: Vec<bool>,
    stage: Option<Stage>,
    album: Album,
    /// Speed of the deepest colour \[m/s\].
    speed_max: f64,
    frames: usize,
    /// The mesh since it followed the grains for the last time; none: that of the stage.
    mesh: Option<Arc<Triangles>>,
    /// Did it before this run was resumed?
    moves: bool,
    /// Of a run that goes on, until it does.
    kept: Option<Kept>,
}

impl Draw for Drawing {
    fn take(&mut self, event: &Event, disk: &Disk) -> Result<(), Error> {
        if !self.wanted {
            return Ok(());
        }
        match &event.message {
            ToOrchestrator::Started { .. } => return self.set_stage(&event.fields),
            ToOrchestrator::Mesh { .. } => {
                let mesh = Mesh::from_fields(2, &event.fields);
                self.mesh = mesh.and_then(Triangles::of).map(Arc::new);
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
            outlines: stage.map(|stage| stage.outlines.clone()),
            window: self.stage.as_ref().map(|stage| stage.window),
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
        match overview(stage, &self.album.states()) {
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
    window: Option<([f64; 2], [f64; 2])>,
    /// Those of the first mesh, where it has followed the grains since.
    outlines: Option<Vec<[Point; 2]>>,
    shown: Shown,
}

impl Drawing {
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
        let mesh = Mesh::from_fields(2, fields);
        let nodes = mesh.as_ref().map_or(0, |mesh| mesh.node_count);
        let mut stage = Stage::new(
            &self.name,
            mesh.and_then(Triangles::of),
            &self.walls,
            values(fields, Field::GrainRadius).to_vec(),
            self.grain_fixed.clone(),
        );
        if let Some(kept) = self.kept.take() {
            let Kept {
                window,
                shown,
                outlines,
                ..
            } = kept;
            stage.window = window.unwrap_or(stage.window);
            self.moves = outlines.is_some();
            stage.outlines = outlines.unwrap_or(stage.outlines);
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

    fn frame(&mut self, state: State, disk: &Disk) -> Result<(), Error> {
        let Some(stage) = &mut self.stage else {
            return Ok(());
        };
        stage.widen(&state);
        // The scale only grows, in round steps, so that successive pictures can be compared.
        self.speed_max = self.speed_max.max(round_up(state.speed_max()));
        let picture = frame(stage, &state, self.speed_max);
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
fn kept_state(
    folder: &Path,
    [fluid, grains]: &[Entries; 2],
    nodes: Option<usize>,
    number: usize,
) -> Result<State, Error> {
    let read = |list: &Entries| -> Result<Option<(f64, vtu::State)>, Error> {
        let Some((time, file)) = list.get(number) else {
            return Ok(None);
        };
        Ok(Some((*time, vtu::State::read(&folder.join(file))?)))
    };
    let single = |pair: [f64; 2]| pair.map(|component| component as f32);
    let mut state = State::default();
    if let Some((time, fluid)) = read(fluid)? {
        state.time = time;
        let mesh = match nodes {
            Some(_) => None,
            None => Triangles::of_state(&fluid)?,
        };
        let own = mesh.as_ref().map(|mesh| mesh.node_count);
        state.mesh = mesh.map(Arc::new);
        let velocity = fluid.vectors::<2>(Field::InterstitialVelocity.name())?;
        let velocity = velocity.unwrap_or_default().into_iter();
        state.fluid_velocity = velocity
            .take(nodes.or(own).unwrap_or(0))
            .map(single)
            .collect();
    }
    if let Some((time, grains)) = read(grains)? {
        state.time = time;
        let position = grains.vectors::<2>("position")?.unwrap_or_default();
        state.grain_position = position.into_iter().map(single).collect();
        let velocity = grains.vectors::<2>(Field::GrainVelocity.name())?;
        let speeds = velocity.unwrap_or_default().into_iter().map(single);
        state.grain_speed = speeds.map(|v| v[0].hypot(v[1])).collect();
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

/// What pictures need of a snapshot.
fn state(time: f64, fields: &[(Field, Vec<f64>)]) -> State {
    let pairs = |wanted: Field| -> Vec<[f32; 2]> {
        let values = values(fields, wanted);
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
        mesh: None,
        fluid_velocity: pairs(Field::InterstitialVelocity),
        grain_position: pairs(Field::GrainPosition),
        grain_speed: speeds,
        grain_id: values(fields, Field::GrainId)
            .iter()
            .map(|&id| id as u32)
            .collect(),
    }
}
