//! Accepted states and the nodal fields that describe the solid.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::FluidError;
use crate::mesh::Mesh;

/// Superficial velocity with the porosity it belongs to: v = u_h/φ_h everywhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Flow {
    /// Superficial velocity u \[m/s\].
    pub superficial_velocity: Vec<[f64; 2]>,
    /// Porosity φ.
    pub porosity: Vec<f64>,
}

impl Flow {
    /// Is every velocity 0?
    pub fn is_at_rest(&self) -> bool {
        self.superficial_velocity.iter().all(|u| *u == [0.0; 2])
    }

    /// v_α = u_α/φ_α \[m/s\].
    pub fn interstitial_velocity(&self) -> Vec<[f64; 2]> {
        let pairs = self.superficial_velocity.iter().zip(&self.porosity);
        pairs
            .map(|(u, porosity)| [u[0] / porosity, u[1] / porosity])
            .collect()
    }
}

/// State at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time \[s\].
    pub time: f64,
    /// Initial state: only the superficial velocity is known, the first step brings the porosity.
    pub fresh: bool,
    /// Velocity and porosity now.
    pub now: Flow,
    /// The same one step earlier, with the length of that step; BDF2 needs it.
    pub before: Option<(Flow, f64)>,
    /// Pressure \[Pa\].
    pub pressure: Vec<f64>,
    /// Was a step no creeping flow? Then convection is there from that step on.
    pub convected: bool,
}

impl State {
    /// At rest in clear fluid, moving with a uniform superficial velocity.
    pub fn uniform(node_count: usize, velocity: [f64; 2]) -> State {
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
        }
    }

    /// The flow now; an initial state takes this porosity.
    pub fn flow_with(&self, porosity: &[f64]) -> Flow {
        let mut flow = self.now.clone();
        if self.fresh {
            flow.porosity.copy_from_slice(porosity);
        }
        flow
    }

    /// Write to a file, bit for bit.
    pub fn save(&self, path: &Path) -> Result<(), FluidError> {
        let fail = |why: String| FluidError::Checkpoint {
            path: path.to_path_buf(),
            why,
        };
        let bytes = bincode::serde::encode_to_vec(self, bincode::config::standard())
            .map_err(|error| fail(error.to_string()))?;
        std::fs::write(path, bytes).map_err(|error| fail(error.to_string()))
    }

    /// Read from a file; it must belong to a mesh of `node_count` nodes.
    pub fn load(path: &Path, node_count: usize) -> Result<State, FluidError> {
        let fail = |why: String| FluidError::Checkpoint {
            path: path.to_path_buf(),
            why,
        };
        let bytes = std::fs::read(path).map_err(|error| fail(error.to_string()))?;
        let (state, used): (State, usize) =
            bincode::serde::decode_from_slice(&bytes, bincode::config::standard())
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

/// Nodal fields of the solid's affine response; `None` is the default: porosity 1, all else 0.
#[derive(Debug, Clone, Copy, Default)]
pub struct SolidFields<'a> {
    /// φ
    pub porosity: Option<&'a [f64]>,
    /// β \[kg/(m³ s)\]
    pub drag: Option<&'a [f64]>,
    /// s \[N/m³\], interleaved
    pub drag_source: Option<&'a [f64]>,
    /// c
    pub entrained_fraction: Option<&'a [f64]>,
    /// j⁰ \[m/s\], interleaved
    pub solid_flux: Option<&'a [f64]>,
    /// κ \[m³ s/kg\]
    pub solid_mobility: Option<&'a [f64]>,
}

/// The same fields, complete, checked and owned.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// What enters the matrix.
    pub matrix: SolidMatrix,
    /// s \[N/m³\].
    pub drag_source: Vec<[f64; 2]>,
    /// j⁰ \[m/s\].
    pub solid_flux: Vec<[f64; 2]>,
}

/// The fields of the solid that enter the matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidMatrix {
    /// φ
    pub porosity: Vec<f64>,
    /// β \[kg/(m³ s)\]
    pub drag: Vec<f64>,
    /// c
    pub entrained_fraction: Vec<f64>,
    /// κ \[m³ s/kg\]
    pub solid_mobility: Vec<f64>,
}

impl Solid {
    /// Fill in defaults; refuse wrong shapes, values that are not finite and φ ≤ 0.
    pub fn new(fields: &SolidFields<'_>, mesh: &Mesh) -> Result<Solid, FluidError> {
        let n = mesh.node_count();
        let scalar = |field, values: Option<&[f64]>, default: f64| match values {
            None => Ok(vec![default; n]),
            Some(values) => checked(field, values, 1, mesh).map(<[f64]>::to_vec),
        };
        let vector = |field, values: Option<&[f64]>| match values {
            None => Ok(vec![[0.0; 2]; n]),
            Some(values) => checked(field, values, 2, mesh)
                .map(|values| values.chunks_exact(2).map(|x| [x[0], x[1]]).collect()),
        };
        let porosity = scalar("porosity", fields.porosity, 1.0)?;
        if let Some(node) = porosity.iter().position(|&value| value <= 0.0) {
            let [x, y] = mesh.position[node];
            return Err(FluidError::Porosity {
                node,
                x,
                y,
                value: porosity[node],
            });
        }
        Ok(Solid {
            matrix: SolidMatrix {
                porosity,
                drag: scalar("drag", fields.drag, 0.0)?,
                entrained_fraction: scalar("entrained_fraction", fields.entrained_fraction, 0.0)?,
                solid_mobility: scalar("solid_mobility", fields.solid_mobility, 0.0)?,
            },
            drag_source: vector("drag_source", fields.drag_source)?,
            solid_flux: vector("solid_flux", fields.solid_flux)?,
        })
    }
}

/// The values, if there are `components` for each node and all are finite.
fn checked<'a>(
    field: &'static str,
    values: &'a [f64],
    components: usize,
    mesh: &Mesh,
) -> Result<&'a [f64], FluidError> {
    let expected = components * mesh.node_count();
    if values.len() != expected {
        return Err(FluidError::Shape {
            field,
            got: values.len(),
            expected,
        });
    }
    finite(field, values, components, mesh)?;
    Ok(values)
}

/// An error that names the first value that is not finite.
pub(crate) fn finite(
    what: &'static str,
    values: &[f64],
    components: usize,
    mesh: &Mesh,
) -> Result<(), FluidError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let node = at / components;
            let [x, y] = mesh.position[node];
            Err(FluidError::NotFinite {
                what,
                node,
                x,
                y,
                value: values[at],
            })
        }
    }
}
