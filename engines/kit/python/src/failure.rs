//! Exceptions of an engine as failures of the protocol, and the other way round.

use protocol::error::Error;
use protocol::message::{Failure, FailureKind};
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(
    sillage,
    SceneError,
    PyException,
    "The scene's part is not usable: raise it in `configure` (exit code 2)."
);
create_exception!(
    sillage,
    NotFinite,
    PyException,
    "A value is not finite, or an invariant is broken (exit code 7)."
);
create_exception!(
    sillage,
    NotConverged,
    PyException,
    "An iteration did not converge: the coupler may try a smaller step (exit code 8)."
);
create_exception!(
    sillage,
    ViewError,
    PyException,
    "A field of the exchange was used, or kept, after its step (exit code 4)."
);
create_exception!(
    sillage,
    EngineFailed,
    PyException,
    "Raised by `sillage.testing` when the engine under test answered with a failure."
);

/// The failure that an exception of the engine stands for; its traceback goes to stderr.
pub fn of_exception(py: Python<'_>, error: &PyErr) -> Failure {
    let kinds = [
        (error.is_instance_of::<SceneError>(py), FailureKind::Scene),
        (
            error.is_instance_of::<NotFinite>(py),
            FailureKind::NotFinite,
        ),
        (
            error.is_instance_of::<NotConverged>(py),
            FailureKind::NotConverged,
        ),
    ];
    let declared = kinds.into_iter().find_map(|(is, kind)| is.then_some(kind));
    if declared.is_none() {
        error.display(py);
    }
    let kind = declared.unwrap_or(FailureKind::Engine);
    let text = error.value(py).to_string();
    let why = match declared {
        Some(_) => text,
        None => format!("{}: {text}{}", type_name(py, error), place(py, error)),
    };
    Failure::new(kind, why)
}

fn type_name(py: Python<'_>, error: &PyErr) -> String {
    let name = error.get_type(py).name();
    name.map_or_else(|_| "exception".to_owned(), |name| name.to_string())
}

/// " (main.py:42)" of the innermost frame, where there is one.
fn place(py: Python<'_>, error: &PyErr) -> String {
    let find = || -> PyResult<Option<String>> {
        let Some(mut last) = error.traceback(py).map(Bound::into_any) else {
            return Ok(None);
        };
        loop {
            let next = last.getattr("tb_next")?;
            if next.is_none() {
                break;
            }
            last = next;
        }
        let line: usize = last.getattr("tb_lineno")?.extract()?;
        let code = last.getattr("tb_frame")?.getattr("f_code")?;
        let file: String = code.getattr("co_filename")?.extract()?;
        let file = file.rsplit('/').next().unwrap_or_default().to_owned();
        Ok(Some(format!(" ({file}:{line})")))
    };
    find().ok().flatten().unwrap_or_default()
}

/// What a test of an engine sees.
pub fn to_exception(error: &Error) -> PyErr {
    match error {
        Error::Engine { failure, .. } => match failure.kind {
            FailureKind::Scene => SceneError::new_err(failure.why.clone()),
            FailureKind::NotFinite => NotFinite::new_err(failure.why.clone()),
            FailureKind::NotConverged => NotConverged::new_err(failure.why.clone()),
            FailureKind::Engine => EngineFailed::new_err(failure.why.clone()),
        },
        Error::NotFinite { .. } | Error::Invalid { .. } => NotFinite::new_err(error.to_string()),
        _ => EngineFailed::new_err(error.to_string()),
    }
}
