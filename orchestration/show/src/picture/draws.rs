//! The pictures of a run while it goes on: a frame a state, a contact sheet at the end.

use std::path::{Path, PathBuf};

use protocol::field::Field;
use protocol::message::ToOrchestrator;
use protocol::monitor::Event;
use protocol::scene::{Wall, fixed};
use run::disk::Disk;
use run::folder::draw::Draw;
use run::vtu::mesh::Mesh;
use scene::{Error, Scene};

use super::axes::round_up;
use super::frame::frame;
use super::overview::{Album, overview};
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
}

impl Draw for Drawing {
    fn take(&mut self, event: &Event, disk: &Disk) -> Result<(), Error> {
        if !self.wanted {
            return Ok(());
        }
        match &event.message {
            ToOrchestrator::Started { .. } => self.set_stage(&event.fields),
            ToOrchestrator::Snapshot { time, .. } => {
                return self.frame(state(*time, &event.fields), disk);
            }
            _ => {}
        }
        Ok(())
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

impl Drawing {
    fn set_stage(&mut self, fields: &[(Field, Vec<f64>)]) {
        self.stage = Some(Stage::new(
            &self.name,
            Mesh::from_fields(2, fields).and_then(Triangles::of),
            &self.walls,
            values(fields, Field::GrainRadius).to_vec(),
            self.grain_fixed.clone(),
        ));
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
        fluid_velocity: pairs(Field::InterstitialVelocity),
        grain_position: pairs(Field::GrainPosition),
        grain_speed: speeds,
        grain_id: values(fields, Field::GrainId)
            .iter()
            .map(|&id| id as u32)
            .collect(),
    }
}
