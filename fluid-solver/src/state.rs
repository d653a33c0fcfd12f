//! Accepted states, and how they are kept.

use std::path::Path;

use serde::{Deserialize, Serialize};
use space::{Dim, Dimension, Vector};

use crate::diagnostics::content::{Content, MeshChange};
use crate::error::FluidError;
use crate::mesh::simplices::Mesh;

/// How a file of a state begins: whose it is, and the version of its layout.
const MAGIC: &[u8] = b"SILLFLD\0";
const VERSION: u8 = 2;

/// Superficial velocity with the porosity it belongs to: v = u_h/φ_h everywhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Flow<const D: usize> {
    /// Superficial velocity u \[m/s\].
    pub superficial_velocity: Vec<Vector<D>>,
    /// Porosity φ.
    pub porosity: Vec<f64>,
}

impl<const D: usize> Flow<D> {
    /// Is every velocity 0?
    pub fn is_at_rest(&self) -> bool {
        self.superficial_velocity
            .iter()
            .all(|u| *u == Vector::<D>::zeros())
    }

    /// v_α = u_α/φ_α \[m/s\].
    pub fn interstitial_velocity(&self) -> Vec<Vector<D>> {
        let pairs = self.superficial_velocity.iter().zip(&self.porosity);
        pairs
            .map(|(u, porosity)| u.map(|component| component / porosity))
            .collect()
    }
}

/// State at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State<const D: usize> {
    /// Time \[s\].
    pub time: f64,
    /// Initial state: only the superficial velocity is known, the first step brings the porosity.
    pub fresh: bool,
    /// Velocity and porosity now.
    pub now: Flow<D>,
    /// The same one step earlier, with the length of that step; BDF2 needs it.
    pub before: Option<(Flow<D>, f64)>,
    /// Pressure \[Pa\].
    pub pressure: Vec<f64>,
    /// Was a step no creeping flow? Then convection is there from that step on.
    pub convected: bool,
    /// What the mesh has done to it since the last step, where it is another one.
    pub mesh_change: Option<MeshChange<D>>,
}

impl<const D: usize> State<D> {
    /// At rest in clear fluid, moving with a uniform superficial velocity.
    pub fn uniform(node_count: usize, velocity: Vector<D>) -> State<D> {
        State {
            time: 0.0,
            fresh: true,
            now: Flow {
                superficial_velocity: vec![velocity; node_count],
                porosity: vec![1.0; node_count],
            },
            before: None,
            pressure: vec![0.0; node_count],
            convected: false,
            mesh_change: None,
        }
    }

    /// The flow now; an initial state takes this porosity.
    pub fn flow_with(&self, porosity: &[f64]) -> Flow<D> {
        let mut flow = self.now.clone();
        if self.fresh {
            flow.porosity.copy_from_slice(porosity);
        }
        flow
    }

    /// What the fluid holds on its mesh, at this density \[kg/m³\].
    pub fn content<const N: usize>(&self, mesh: &Mesh<D, N>, density: f64) -> Content<D>
    where
        Dim<D>: Dimension<D>,
    {
        let Flow {
            superficial_velocity,
            porosity,
        } = &self.now;
        Content::new(mesh, porosity, superficial_velocity, density)
    }

    /// The same on another mesh, whose nodes are at these nodes and shape functions of this one ((Z2) in
    /// `refined`).
    pub(crate) fn carried<const N: usize>(&self, spots: &[([u32; N], [f64; N])]) -> State<D> {
        let at = |values: &[f64]| -> Vec<f64> {
            let sum = |(nodes, weights): &([u32; N], [f64; N])| {
                let terms = nodes.iter().zip(weights);
                terms
                    .map(|(&node, weight)| values[node as usize] * weight)
                    .sum()
            };
            spots.iter().map(sum).collect()
        };
        let flow = |flow: &Flow<D>| -> Flow<D> {
            let velocity = flow.interstitial_velocity();
            let porosity = at(&flow.porosity);
            let moving = spots.iter().zip(&porosity).map(|((nodes, weights), phi)| {
                let terms = nodes.iter().zip(weights);
                let sum = |sum: Vector<D>, (&node, weight): (&u32, &f64)| {
                    sum + velocity[node as usize] * *weight
                };
                terms.fold(Vector::zeros(), sum) * *phi
            });
            Flow {
                superficial_velocity: moving.collect(),
                porosity,
            }
        };
        State {
            now: flow(&self.now),
            before: self.before.as_ref().map(|(before, dt)| (flow(before), *dt)),
            pressure: at(&self.pressure),
            ..*self
        }
    }

    /// Write to a file, bit for bit; it appears complete or not at all.
    pub fn save(&self, path: &Path) -> Result<(), FluidError> {
        let mut bytes = [MAGIC, &[VERSION]].concat();
        let state = bincode::serde::encode_to_vec(self, bincode::config::standard());
        bytes.extend(state.map_err(|error| unusable(path, error.to_string()))?);
        let mut draft = path.as_os_str().to_owned();
        draft.push(".part");
        std::fs::write(&draft, bytes)
            .and_then(|()| std::fs::rename(&draft, path))
            .map_err(|error| unusable(path, format!("cannot be written: {error}")))
    }

    /// Read from a file; it must belong to a mesh of `node_count` nodes.
    pub fn load(path: &Path, node_count: usize) -> Result<State<D>, FluidError> {
        let fail = |why: String| unusable(path, why);
        let bytes = std::fs::read(path).map_err(|e| fail(format!("cannot be read: {e}")))?;
        let bytes = bytes.strip_prefix(MAGIC);
        let (&version, bytes) = bytes
            .and_then(<[u8]>::split_first)
            .ok_or_else(|| fail("not a state of this engine".to_owned()))?;
        if version != VERSION {
            return Err(fail(format!(
                "its format is version {version}, this engine reads {VERSION}: take the sillage that wrote it"
            )));
        }
        let (state, used): (State<D>, usize) =
            bincode::serde::decode_from_slice(bytes, bincode::config::standard())
                .map_err(|error| fail(error.to_string()))?;
        if used != bytes.len() {
            return Err(fail(format!("{} bytes too many", bytes.len() - used)));
        }
        let flows = std::iter::once(&state.now).chain(state.before.as_ref().map(|(flow, _)| flow));
        let fits = flows.into_iter().all(|flow| {
            flow.superficial_velocity.len() == node_count && flow.porosity.len() == node_count
        });
        if !fits || state.pressure.len() != node_count {
            let held = state.pressure.len();
            return Err(fail(format!("{held} nodes; this mesh has {node_count}")));
        }
        Ok(state)
    }
}

fn unusable(path: &Path, why: String) -> FluidError {
    FluidError::Checkpoint {
        path: path.to_path_buf(),
        why,
    }
}
