//! The coupler's part of a checkpoint: the state between two steps, bit by bit.
//!
//! ```text
//!   "SILLCPL\0"  version u8  scene, clock, state, totals, messages recorded (bincode)
//! ```
//!
//! What the engines are in is theirs: `Save` and `Restore`. A run that is resumed configures its engines as at
//! its start, has the mesh follow where it was, takes out the grains that have left since, and gives each its file.

use std::path::Path;

use protocol::checkpoints;
use protocol::codec;
use protocol::engine::MeshDescription;
use protocol::message::Diagnostic;
use protocol::scene::{CouplerScene, Limits, MeshSource};
use serde::{Deserialize, Serialize};
use space::{Dim, Dimension};

use crate::clock::Memory;
use crate::error::CouplerError;
use crate::follow::Asked;
use crate::simulation::Simulation;
use crate::state::State;

const MAGIC: &[u8] = b"SILLCPL\0";
const VERSION: u8 = 3;

/// What the coupler is in between two steps.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Kept<const D: usize> {
    /// The scene, less what a resumed run may change, as JSON.
    scene: String,
    /// Of the mesh, where there is a fluid.
    mesh: Option<u32>,
    /// What that was asked for, where it follows.
    asked: Option<Asked>,
    /// The clock.
    pub clock: Memory,
    /// The accepted state.
    state: State<D>,
    /// Sums and worst values so far.
    pub totals: Vec<Diagnostic>,
    /// Messages of the links that are in the recording; none where nothing is recorded any more.
    pub recorded: Option<u64>,
}

impl<const D: usize> Kept<D>
where
    Dim<D>: Dimension<D>,
{
    /// Of a simulation between two steps.
    pub fn of<const N: usize>(
        simulation: &Simulation<D, N>,
        clock: Memory,
        totals: &[Diagnostic],
        recorded: Option<u64>,
    ) -> Kept<D> {
        let fluid = simulation.system.fluid();
        Kept {
            scene: lasting(&simulation.scene),
            mesh: fluid.map(|seat| checksum(&seat.description)),
            asked: simulation.asked(),
            clock,
            state: simulation.state.clone(),
            totals: totals.to_vec(),
            recorded,
        }
    }

    /// Write to a folder.
    pub fn write(&self, folder: &Path) -> Result<(), CouplerError> {
        let path = folder.join(checkpoints::COUPLER);
        let mut bytes = [MAGIC, &[VERSION]].concat();
        let content = codec::encode_file(self);
        bytes.extend(content.map_err(|error| unusable(&path, error.to_string()))?);
        std::fs::write(&path, bytes)
            .map_err(|error| unusable(&path, format!("cannot be written: {error}")))
    }

    /// Read from a folder what belongs to this scene.
    pub fn read(folder: &Path, scene: &CouplerScene) -> Result<Kept<D>, CouplerError> {
        let path = folder.join(checkpoints::COUPLER);
        let bytes = std::fs::read(&path)
            .map_err(|error| unusable(&path, format!("cannot be read: {error}")))?;
        let kept = decode::<D>(&bytes).map_err(|why| unusable(&path, why))?;
        match kept.scene == lasting(scene) {
            true => Ok(kept),
            false => Err(unusable(
                &path,
                "it is of another scene: scene.json has changed since; what may change is set with \
                 `sillage resume --set`"
                    .to_owned(),
            )),
        }
    }

    /// Bring a simulation that begins to where this was kept, with the engines' files beside it.
    pub fn restore<const N: usize>(
        self,
        folder: &Path,
        simulation: &mut Simulation<D, N>,
    ) -> Result<(), CouplerError> {
        let path = folder.join(checkpoints::COUPLER);
        if let Some(asked) = &self.asked {
            simulation.follow_again(asked)?;
        }
        let mesh = simulation.system.fluid();
        let mesh = mesh.map(|seat| checksum(&seat.description));
        let fits = self
            .check(simulation)
            .and_then(|()| match mesh == self.mesh {
                true => Ok(()),
                false => Err("it is of another mesh: the mesh file has changed since".to_owned()),
            });
        fits.map_err(|why| unusable(&path, why))?;
        simulation.take_out(&self.gone(simulation.state.grains.count()))?;
        for partner in simulation.system.partners() {
            let seat = partner.hello().role.seat();
            partner.restore(&folder.join(seat))?;
        }
        simulation.state = self.state;
        Ok(())
    }

    /// Grains that have left, of so many.
    fn gone(&self, count: usize) -> Vec<usize> {
        let mut left = self.state.grains.id.iter().peekable();
        let is_gone = |grain: &usize| left.next_if(|&&id| id == *grain as u64).is_none();
        (0..count).filter(is_gone).collect()
    }

    /// Does it fit the grains and the nodes that there are?
    fn check<const N: usize>(&self, simulation: &Simulation<D, N>) -> Result<(), String> {
        let (grains, first) = (&self.state.grains, &simulation.state.grains);
        let ascending = grains.id.is_sorted_by(|a, b| a < b);
        let known = grains
            .id
            .last()
            .is_none_or(|&last| last < first.count() as u64);
        if !ascending || !known || !grains.is_consistent() {
            return Err("its grains are not among those of the scene".to_owned());
        }
        for (own, &id) in grains.id.iter().enumerate() {
            let id = id as usize;
            let numbers = |all: &[&Vec<f64>; 3], at: usize| all.map(|values| values[at]);
            let told = numbers(&[&first.radius, &first.mass, &first.volume], id);
            let kept = numbers(&[&grains.radius, &grains.mass, &grains.volume], own);
            if told != kept || first.fixed[id] != grains.fixed[own] {
                return Err(format!(
                    "grain {id} is another one: the grains have changed since"
                ));
            }
        }
        let (flow, begun) = (&self.state.flow, &simulation.state);
        let nodes = [
            flow.velocity.len(),
            flow.pressure_gradient.len(),
            self.state.porosity.len(),
        ];
        let expected = [
            begun.flow.velocity.len(),
            begun.flow.pressure_gradient.len(),
            begun.porosity.len(),
        ];
        // A field that nobody reads is not there.
        let fits = |(kept, expected): (&usize, &usize)| *kept == 0 || kept == expected;
        match nodes.iter().zip(&expected).all(fits) {
            true => Ok(()),
            false => Err(format!("{nodes:?} nodes; this mesh has {expected:?}")),
        }
    }
}

fn decode<const D: usize>(bytes: &[u8]) -> Result<Kept<D>, String> {
    let content = bytes.strip_prefix(MAGIC).and_then(<[u8]>::split_first);
    let (&version, content) = content.ok_or("not a state of the coupler")?;
    if version != VERSION {
        return Err(format!(
            "its format is version {version}, this coupler reads {VERSION}: take the sillage that wrote it"
        ));
    }
    codec::decode_file(content).map_err(|error| error.to_string())
}

/// The error of a file or a folder of a checkpoint.
pub fn unusable(path: &Path, why: String) -> CouplerError {
    CouplerError::Checkpoint {
        file: path.display().to_string(),
        why,
    }
}

/// The part of a scene that decides what was computed: neither how long it goes on, nor how long anybody is
/// waited for, nor on how many threads, nor where the mesh file lies (what is in it is looked at).
fn lasting(scene: &CouplerScene) -> String {
    let mut scene = scene.clone();
    scene.end_time = 0.0;
    scene.limits = Limits {
        connect: 0.0,
        configure: 0.0,
        step: 0.0,
    };
    if let Some(fluid) = &mut scene.fluid {
        fluid.threads = 0;
        if let MeshSource::File { path, .. } = &mut fluid.mesh {
            path.clear();
        }
    }
    if let Some(particles) = &mut scene.particles {
        particles.threads = 0;
    }
    serde_json::to_string(&scene).unwrap_or_default()
}

/// Of the nodes and simplices of a mesh.
fn checksum(mesh: &MeshDescription) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for number in &mesh.node_position {
        hasher.update(&number.to_le_bytes());
    }
    for node in &mesh.simplex_nodes {
        hasher.update(&node.to_le_bytes());
    }
    hasher.finalize()
}
