//! A coupler's end for tests of engines: the engine runs on a thread of this process, over the
//! same loop, messages and buffers as in a run.

use std::path::PathBuf;
use std::thread::ThreadId;

use protocol::engine::InitialGrains;
use protocol::field::Field;
use protocol::local;
use protocol::message::Advance;
use protocol::partner::Partner;
use protocol::report::Report;
use protocol::scene::{FluidScene, ParticleScene};
use pyo3::buffer::PyBuffer;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::bridge::Parts;
use crate::{failure, role_of};

/// Drives one engine; behind `sillage.testing`.
#[pyclass(module = "sillage._native")]
pub struct Driver {
    partner: Option<Here<Partner>>,
    home: ThreadId,
}

/// Something that stays on its thread, where more is asked for.
struct Here<T>(T);

// SAFETY: `Python::detach` runs its closure on the calling thread; the bound only keeps objects of
// the interpreter out of it, and a `Partner` has none. A `Driver` that is used or dropped on another
// thread than its home does not touch its partner.
unsafe impl<T> Send for Here<T> {}
// SAFETY: as above; nothing gives out a shared reference.
unsafe impl<T> Sync for Here<T> {}

impl Drop for Driver {
    fn drop(&mut self) {
        // The collector may run on the engine's thread.
        if self.home != std::thread::current().id() {
            std::mem::forget(self.partner.take());
        }
    }
}

impl<T> Here<T> {
    fn into_inner(self) -> T {
        self.0
    }
}

type Arrays = Vec<(String, Py<PyByteArray>)>;
type Named = Vec<(String, f64)>;

/// What a report tells, by name.
fn named(report: &Report) -> Named {
    let numbers = match *report {
        Report::Fluid(report) => vec![
            ("solid_power", report.solid_power),
            ("reynolds", report.reynolds),
            ("convects", report.convects.map(f64::from)),
        ],
        Report::Particles(report) => vec![
            ("sub_steps", Some(f64::from(report.sub_steps.get()))),
            ("touching", report.touching.map(|count| count as f64)),
        ],
    };
    let told = numbers.into_iter();
    told.filter_map(|(name, value)| Some((name.to_owned(), value?)))
        .collect()
}

fn field(name: &str) -> PyResult<Field> {
    Field::from_name(name)
        .ok_or_else(|| PyValueError::new_err(format!("there is no field {name:?}")))
}

fn bytes(py: Python<'_>, values: &[f64]) -> Py<PyByteArray> {
    let bytes: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_ne_bytes())
        .collect();
    PyByteArray::new(py, &bytes).unbind()
}

fn parse<T: serde::de::DeserializeOwned>(scene: &str) -> PyResult<T> {
    serde_json::from_str(scene).map_err(|e| failure::SceneError::new_err(e.to_string()))
}

impl Driver {
    /// Call the engine without holding the interpreter, which the engine needs.
    fn with<T>(
        &mut self,
        py: Python<'_>,
        work: impl FnOnce(&mut Partner) -> Result<T, protocol::Error>,
    ) -> PyResult<T> {
        if self.home != std::thread::current().id() {
            return Err(PyValueError::new_err(
                "a driver stays on the thread that made it",
            ));
        }
        let partner = self.partner.as_mut();
        let partner = partner.ok_or_else(|| PyValueError::new_err("the driver is closed"))?;
        let (partner, work) = (Here(&mut partner.0), Here(work));
        let result = py.detach(move || {
            let work = work.into_inner();
            Here(work(partner.into_inner()))
        });
        result.into_inner().map_err(|e| failure::to_exception(&e))
    }
}

#[pymethods]
impl Driver {
    #[new]
    fn new(py: Python<'_>, role: &str, seat: Py<PyAny>) -> PyResult<Driver> {
        let role = role_of(role)?;
        let mut parts = Parts::new(py, &seat)?;
        let partner = py.detach(move || {
            Here(local::spawn(role, move |link| {
                let served = parts.serve(role, link);
                // With the interpreter, or the engine would live until somebody else calls it.
                Python::attach(|_| drop(parts));
                served
            }))
        });
        let partner = partner
            .into_inner()
            .map_err(|e| failure::to_exception(&e))?;
        Ok(Driver {
            partner: Some(Here(partner)),
            home: std::thread::current().id(),
        })
    }

    /// Configure a fluid engine; node positions, corners and nodal masses.
    fn configure_fluid(&mut self, py: Python<'_>, scene: &str) -> PyResult<Arrays> {
        let scene: FluidScene = parse(scene)?;
        let mesh = self.with(py, |partner| partner.configure_fluid(&scene))?;
        Ok(vec![
            ("nodes".to_owned(), bytes(py, &mesh.node_position)),
            ("simplices".to_owned(), bytes(py, &mesh.corner_numbers())),
            ("nodal_mass".to_owned(), bytes(py, &mesh.nodal_mass)),
        ])
    }

    /// Configure a particle engine with the six arrays of grains; the number it will run.
    fn configure_particles(
        &mut self,
        py: Python<'_>,
        scene: &str,
        grains: Vec<PyBuffer<f64>>,
    ) -> PyResult<usize> {
        let scene: ParticleScene = parse(scene)?;
        let arrays = grains.iter().map(|array| array.to_vec(py));
        let arrays = arrays.collect::<PyResult<Vec<_>>>()?;
        let arrays = <[Vec<f64>; 6]>::try_from(arrays)
            .map_err(|_| PyValueError::new_err("six arrays of grains expected"))?;
        let grains = InitialGrains::from_arrays(scene.dimension, arrays);
        let taken = self.with(py, |partner| partner.configure_particles(&scene, &grains))?;
        Ok(taken.radius.len())
    }

    /// One candidate: its fields, the numbers of its report, its diagnostics.
    fn advance(
        &mut self,
        py: Python<'_>,
        numbers: (u64, u32, f64, f64, u32, f64),
        inputs: Vec<(String, PyBuffer<f64>)>,
    ) -> PyResult<(Arrays, Named, Named)> {
        let (step, pass, time, dt, sub_steps, tolerance) = numbers;
        let request = Advance {
            step,
            pass,
            time,
            dt,
            sub_steps,
            tolerance,
            fields: Vec::new(),
        };
        let mut given = Vec::new();
        for (name, array) in &inputs {
            given.push((field(name)?, array.to_vec(py)?));
        }
        let (wanted, done, values) = self.with(py, |partner| {
            let wanted = partner.hello().answer();
            let mut values = vec![Vec::new(); wanted.len()];
            let given: Vec<(Field, &[f64])> = given
                .iter()
                .map(|(field, values)| (*field, values.as_slice()))
                .collect();
            let mut outputs: Vec<_> = wanted.iter().copied().zip(values.iter_mut()).collect();
            let done = partner.advance(&request, &given, &mut outputs)?;
            Ok((wanted, done, values))
        })?;
        let fields = wanted.iter().zip(&values);
        let fields = fields.map(|(field, values)| (field.name().to_owned(), bytes(py, values)));
        let diagnostics = done.diagnostics.into_iter().map(|d| (d.name, d.value));
        Ok((fields.collect(), named(&done.report), diagnostics.collect()))
    }

    fn commit(&mut self, py: Python<'_>, step: u64) -> PyResult<()> {
        self.with(py, |partner| partner.commit(step))
    }

    /// Take grains out; how many are left.
    fn remove(&mut self, py: Python<'_>, grains: Vec<usize>) -> PyResult<usize> {
        let left = self.with(py, |partner| partner.remove(&grains))?;
        Ok(left.count())
    }

    fn save(&mut self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.with(py, |partner| partner.save(&path))
    }

    fn restore(&mut self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.with(py, |partner| partner.restore(&path))
    }

    /// Tell the engine to leave.
    fn close(&mut self, py: Python<'_>) -> PyResult<()> {
        if self.partner.is_none() {
            return Ok(());
        }
        let result = self.with(py, Partner::finish);
        self.partner = None;
        result
    }
}
