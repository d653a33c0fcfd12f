//! Native half of the Python package `sillage`: the loop of `protocol` around an engine written in
//! Python.
//!
//! ```text
//!   protocol::serve ─► bridge.rs (FluidEngine, ParticleEngine) ─► seat.py ─► the engine
//!        ▲                 │ fields as buffers (buffer.rs), no copy
//!   held.rs: keeps the memory of a field that an engine still looks at
//! ```
//!
//! The part in Python (`python/sillage/`) is what an engine sees; nothing here is public.

mod bridge;
mod buffer;
mod driver;
mod failure;
mod held;

use protocol::field::{Exchange, FIELDS, FieldSpec, Rank};
use protocol::message::Role;
use pyo3::prelude::*;

/// Serve the run named by the environment with `seat` until it ends; the exit code.
#[pyfunction]
fn run(py: Python<'_>, role: &str, seat: Py<PyAny>) -> PyResult<i32> {
    let role = role_of(role)?;
    let mut bridge = bridge::Parts::new(py, &seat)?;
    Ok(py.detach(|| {
        protocol::process::exit_code(role.seat(), |runspace| {
            let link = protocol::ipc::engine_link(runspace, role)?;
            bridge.serve(role, link)
        })
    }))
}

fn role_of(name: &str) -> PyResult<Role> {
    match name {
        "fluid" => Ok(Role::Fluid),
        "particles" => Ok(Role::Particles),
        _ => Err(pyo3::exceptions::PyValueError::new_err(format!(
            "role is {name:?}, must be \"fluid\" or \"particles\""
        ))),
    }
}

/// Name, rank, default and senders of every field: what the Python side knows of them.
fn fields() -> Vec<(&'static str, &'static str, Option<f64>, Vec<&'static str>)> {
    let words = |spec: &FieldSpec| {
        let rank = match spec.rank {
            Rank::Scalar => "scalar",
            Rank::Vector => "vector",
            Rank::Spin => "spin",
            Rank::Corners | Rank::CornerVectors | Rank::FacetVectors => "corners",
        };
        let sent = spec.sent.iter().map(|exchange| match exchange {
            Exchange::ToFluid => "to fluid",
            Exchange::ToParticles => "to particles",
            Exchange::FromFluid => "from fluid",
            Exchange::FromParticles | Exchange::MaybeFromParticles => "from particles",
            Exchange::Mesh => "mesh",
            Exchange::Grains => "grains",
            Exchange::Boundary => "boundary",
            Exchange::Shown => "shown",
        });
        (spec.name, rank, spec.default, sent.collect())
    };
    FIELDS.iter().map(words).collect()
}

/// The module `sillage._native`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("PROTOCOL_VERSION", protocol::PROTOCOL_VERSION)?;
    module.add("FIELDS", fields())?;
    module.add("SceneError", py.get_type::<failure::SceneError>())?;
    module.add("NotConverged", py.get_type::<failure::NotConverged>())?;
    module.add("NotFinite", py.get_type::<failure::NotFinite>())?;
    module.add("ViewError", py.get_type::<failure::ViewError>())?;
    module.add("EngineFailed", py.get_type::<failure::EngineFailed>())?;
    module.add_class::<buffer::Buffer>()?;
    module.add_class::<driver::Driver>()?;
    module.add_function(wrap_pyfunction!(run, module)?)
}
