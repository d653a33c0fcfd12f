//! The traits of `protocol` on top of an engine written in Python.
//!
//! The interpreter is held only while the engine computes. What crosses over is plain: names,
//! numbers, JSON for the scene, bytes for arrays that the engine may keep, [`Buffer`]s for fields.

use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;

use protocol::channel::Channel;
use protocol::engine::{
    self, Computed, FacetDescription, FluidEngine, InitialGrains, Inputs, MeshDescription, Outputs,
    ParticleEngine,
};
use protocol::error::Error;
use protocol::message::{Advance, Capability, Diagnostic, Failure, FailureKind, Role};
use protocol::report::{FluidReport, ParticleReport};
use protocol::scene::{FluidScene, ParticleScene, Refinement};
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

use crate::buffer::Buffer;
use crate::failure;
use crate::held::{Escaped, HeldLink};

/// What is known of an engine before it serves; can go to another thread.
pub struct Parts {
    seat: Py<PyAny>,
    identity: (&'static str, &'static str),
    capabilities: Vec<Capability>,
}

impl Parts {
    /// Ask `seat` (`sillage.seat.Seat`) who it is.
    pub fn new(py: Python<'_>, seat: &Py<PyAny>) -> PyResult<Parts> {
        let bound = seat.bind(py);
        let text = |name: &str| -> PyResult<&'static str> {
            // Once a process: the protocol wants names that live as long as the engine.
            Ok(bound.getattr(name)?.extract::<String>()?.leak())
        };
        let names: Vec<String> = bound.getattr("capabilities")?.extract()?;
        let capabilities = names.iter().map(|name| capability(name));
        Ok(Parts {
            seat: seat.clone_ref(py),
            identity: (text("name")?, text("version")?),
            capabilities: capabilities.collect::<PyResult<_>>()?,
        })
    }

    /// Serve the coupler at the other end of `link` until `Finish`.
    pub fn serve(&mut self, role: Role, link: Box<dyn Channel>) -> Result<(), Error> {
        let escaped: Escaped = Rc::new(Cell::new(false));
        let link = Box::new(HeldLink {
            inner: link,
            escaped: Rc::clone(&escaped),
        });
        let mut bridge = Bridge {
            parts: self,
            escaped,
            dimension: 0,
        };
        match role {
            Role::Fluid => engine::serve_fluid(&mut bridge, link),
            Role::Particles => engine::serve_particles(&mut bridge, link),
        }
    }
}

fn capability(name: &str) -> PyResult<Capability> {
    let known = [
        ("affine-response", Capability::AffineResponse),
        ("implicit-drag", Capability::ImplicitDrag),
        ("contact-state", Capability::ContactState),
        ("checkpoint", Capability::Checkpoint),
        ("convection-as-needed", Capability::ConvectionAsNeeded),
        ("moving-walls", Capability::MovingWalls),
        ("steers-mean-flow", Capability::SteersMeanFlow),
        ("spin", Capability::Spin),
        ("removes-grains", Capability::RemovesGrains),
        ("adapts", Capability::Adapts),
    ];
    let found = known.iter().find(|(known, _)| *known == name);
    found.map(|&(_, capability)| capability).ok_or_else(|| {
        let names = known.map(|(name, _)| name).join(", ");
        pyo3::exceptions::PyValueError::new_err(format!(
            "capability {name:?} is unknown: use {names}"
        ))
    })
}

/// An engine that serves.
struct Bridge<'a> {
    parts: &'a Parts,
    escaped: Escaped,
    /// Of the space, once it is configured.
    dimension: usize,
}

/// What `Seat.advance` returns: the report's numbers, and named numbers for people.
type Told<R> = (R, Vec<(String, f64)>);

impl Bridge<'_> {
    /// Call into Python; an exception becomes a failure, and is gone before this returns.
    fn call<T>(
        &self,
        work: impl FnOnce(Python<'_>, &Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, Failure> {
        Python::attach(|py| {
            work(py, self.parts.seat.bind(py)).map_err(|error| failure::of_exception(py, &error))
        })
    }

    /// One `advance`: views are given, counted, and must all be gone when it is over.
    fn compute<R: for<'py> FromPyObject<'py, 'py, Error = PyErr>>(
        &self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<(R, Vec<Diagnostic>), Failure> {
        if self.escaped.get() {
            let why = "it kept a view of an earlier step; it cannot go on";
            return Err(Failure::new(FailureKind::Engine, why));
        }
        let mut lent: Vec<Py<Buffer>> = Vec::new();
        let result = self.call(|py, seat| {
            let (given, filled) = (PyDict::new(py), PyDict::new(py));
            for &(field, values) in inputs.all() {
                let buffer = Py::new(py, Buffer::input((field, self.dimension), values))?;
                given.set_item(field.name(), &buffer)?;
                lent.push(buffer);
            }
            for (field, room) in outputs.into_all() {
                let buffer = Py::new(py, Buffer::output((field, self.dimension), room))?;
                filled.set_item(field.name(), &buffer)?;
                lent.push(buffer);
            }
            let numbers = (
                request.step,
                request.pass,
                request.time,
                request.dt,
                request.sub_steps,
                request.tolerance,
            );
            let told = seat.call_method1("advance", (numbers, given, filled))?;
            let (report, named): Told<R> = told.extract()?;
            let diagnostics = named
                .into_iter()
                .map(|(name, value)| Diagnostic { name, value });
            Ok((report, diagnostics.collect()))
        });
        match self.take_back(&lent) {
            Ok(()) => result,
            Err(escape) => {
                self.escaped.set(true);
                Err(match result {
                    Ok(_) => escape,
                    Err(first) => Failure::new(
                        FailureKind::Engine,
                        format!("{}; it came after: {}", escape.why, first.why),
                    ),
                })
            }
        }
    }

    /// Close the buffers; an array that still looks at one is a failure that names the field.
    fn take_back(&self, lent: &[Py<Buffer>]) -> Result<(), Failure> {
        Python::attach(|py| {
            lent.iter().for_each(|buffer| buffer.get().close());
            let kept = |py: Python<'_>| -> Vec<String> {
                let still = lent.iter().filter(|buffer| buffer.get().exports() > 0);
                let name = |buffer: &Py<Buffer>| buffer.bind(py).getattr("name")?.extract();
                still.map(name).filter_map(PyResult::ok).collect()
            };
            if kept(py).is_empty() {
                return Ok(());
            }
            // Garbage that waits for the collector is not kept.
            let _ = py.import("gc").and_then(|gc| gc.call_method0("collect"));
            let names = kept(py);
            if names.is_empty() {
                return Ok(());
            }
            let why = format!(
                "ViewError: an array over {} is kept beyond its step: fields belong to one advance; \
                 keep a copy, as in `numpy.array(…)`",
                names.join(", ")
            );
            Err(Failure::new(FailureKind::Engine, why))
        })
    }

    fn commit(&self) -> Result<(), Failure> {
        self.call(|_, seat| seat.call_method0("commit").map(drop))
    }

    fn store(&self, method: &str, path: &Path) -> Result<(), Failure> {
        let path = path.to_string_lossy().into_owned();
        self.call(|_, seat| seat.call_method1(method, (path,)).map(drop))
    }
}

fn json(scene: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string(scene).map_err(|e| Failure::new(FailureKind::Engine, e.to_string()))
}

/// The numbers of a contiguous array of float64.
fn numbers(array: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    PyBuffer::<f64>::get(array)?.to_vec(array.py())
}

fn bytes<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyByteArray> {
    let bytes: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_ne_bytes())
        .collect();
    PyByteArray::new(py, &bytes)
}

/// A `sillage.Mesh`.
fn mesh_of(mesh: &Bound<'_, PyAny>) -> PyResult<MeshDescription> {
    let array = |name: &str| numbers(&mesh.getattr(name)?);
    let corners = array("simplices")?;
    Ok(MeshDescription {
        dimension: mesh.getattr("dimension")?.extract()?,
        node_position: array("nodes")?,
        simplex_nodes: corners.iter().map(|&node| node as u32).collect(),
        simplex_position: array("simplex_position")?,
        nodal_mass: array("nodal_mass")?,
        period: mesh.getattr("period")?.extract()?,
        facets: FacetDescription::default(),
    })
}

/// Grains from their six arrays.
fn grains_of(arrays: &Bound<'_, PyAny>, dimension: usize) -> PyResult<InitialGrains> {
    let arrays: Vec<Bound<'_, PyAny>> = arrays.extract()?;
    let arrays = arrays.iter().map(numbers).collect::<PyResult<Vec<_>>>()?;
    let arrays = <[Vec<f64>; 6]>::try_from(arrays).unwrap_or_default();
    Ok(InitialGrains::from_arrays(dimension, arrays))
}

impl FluidEngine for Bridge<'_> {
    fn identity(&self) -> (&'static str, &'static str) {
        self.parts.identity
    }

    fn capabilities(&self) -> Vec<Capability> {
        self.parts.capabilities.clone()
    }

    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        self.dimension = scene.dimension;
        let scene = json(scene)?;
        self.call(|_, seat| mesh_of(&seat.call_method1("configure_fluid", (scene,))?))
    }

    fn adapt(&mut self, sizes: &Refinement) -> Result<Option<MeshDescription>, Failure> {
        let sizes = json(sizes)?;
        self.call(|_, seat| {
            let mesh = seat.call_method1("adapt_fluid", (sizes,))?;
            (!mesh.is_none()).then(|| mesh_of(&mesh)).transpose()
        })
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure> {
        let (told, diagnostics) = self.compute(request, inputs, outputs)?;
        let (solid_power, reynolds, convects): (Option<f64>, Option<f64>, Option<bool>) = told;
        Ok(Computed {
            report: FluidReport {
                solid_power,
                reynolds,
                convects,
            },
            diagnostics,
        })
    }

    fn commit(&mut self) -> Result<(), Failure> {
        Bridge::commit(self)
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.store("save", path)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.store("restore", path)
    }
}

impl ParticleEngine for Bridge<'_> {
    fn identity(&self) -> (&'static str, &'static str) {
        self.parts.identity
    }

    fn capabilities(&self) -> Vec<Capability> {
        self.parts.capabilities.clone()
    }

    fn configure(
        &mut self,
        scene: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        let dimension = scene.dimension;
        self.dimension = dimension;
        let scene = json(scene)?;
        self.call(|py, seat| {
            let given = grains.slices().map(|(_, values)| bytes(py, values));
            let taken = seat.call_method1("configure_particles", (scene, given))?;
            grains_of(&taken, dimension)
        })
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        let (told, diagnostics) = self.compute(request, inputs, outputs)?;
        let (sub_steps, touching): (u32, Option<u64>) = told;
        let report = ParticleReport::new(sub_steps).ok_or_else(|| {
            let why = "sub_steps of the report is 0, must be 1 or more";
            Failure::new(FailureKind::Engine, why)
        })?;
        Ok(Computed {
            report: ParticleReport { touching, ..report },
            diagnostics,
        })
    }

    fn commit(&mut self) -> Result<(), Failure> {
        Bridge::commit(self)
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.store("save", path)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.store("restore", path)
    }

    fn remove(&mut self, grains: &[usize]) -> Result<InitialGrains, Failure> {
        self.call(|_, seat| {
            let left = seat.call_method1("remove", (grains,))?;
            grains_of(&left, self.dimension)
        })
    }
}
