//! A field of one exchange as an object with Python's buffer protocol: an array made from it looks
//! at the shared memory itself.
//!
//! An array cannot be taken away from who has it, so the buffer counts who looks at it, and is closed
//! at the end of the exchange: nothing can look at it any more, and whoever still does is found.

use std::ffi::{c_int, c_void};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use protocol::field::Field;
use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;

use crate::failure::ViewError;

/// One field of the exchange in progress.
#[pyclass(frozen, module = "sillage._native")]
pub struct Buffer {
    name: &'static str,
    // An address: the memory belongs to the transport, which is asked to keep it while `exports` > 0.
    address: usize,
    read_only: bool,
    dimensions: c_int,
    shape: [isize; 2],
    strides: [isize; 2],
    open: AtomicBool,
    exports: AtomicUsize,
}

const SIZE: isize = size_of::<f64>() as isize;

impl Buffer {
    fn new(
        (field, dimension): (Field, usize),
        address: usize,
        count: usize,
        read_only: bool,
    ) -> Buffer {
        let components = field.components(dimension);
        Buffer {
            name: field.name(),
            address,
            read_only,
            dimensions: if components == 1 { 1 } else { 2 },
            shape: [(count / components) as isize, components as isize],
            strides: [components as isize * SIZE, SIZE],
            open: AtomicBool::new(true),
            exports: AtomicUsize::new(0),
        }
    }

    /// A field that arrived, in a space of this dimension.
    pub fn input(field: (Field, usize), values: &[f64]) -> Buffer {
        Buffer::new(field, values.as_ptr() as usize, values.len(), true)
    }

    /// A field that will be sent.
    pub fn output(field: (Field, usize), values: &mut [f64]) -> Buffer {
        Buffer::new(field, values.as_mut_ptr() as usize, values.len(), false)
    }

    /// No new view from now on.
    pub fn close(&self) {
        self.open.store(false, Ordering::Release);
    }

    /// Views that are still alive.
    pub fn exports(&self) -> usize {
        self.exports.load(Ordering::Acquire)
    }
}

#[pymethods]
impl Buffer {
    /// Name of the field.
    #[getter]
    fn name(&self) -> &'static str {
        self.name
    }

    /// # Safety
    /// Called by the interpreter only, with a view to fill.
    unsafe fn __getbuffer__(
        slf: Bound<'_, Self>,
        view: *mut ffi::Py_buffer,
        flags: c_int,
    ) -> PyResult<()> {
        // SAFETY: the interpreter passes a valid view, or null.
        let Some(view) = (unsafe { view.as_mut() }) else {
            return Err(PyBufferError::new_err("no view to fill"));
        };
        view.obj = std::ptr::null_mut();
        let buffer = slf.get();
        if !buffer.open.load(Ordering::Acquire) {
            let name = buffer.name;
            return Err(ViewError::new_err(format!(
                "{name} was read after its step: its memory belongs to one advance; \
                 keep a copy, as in `{name}.copy()`"
            )));
        }
        if buffer.read_only && flags & ffi::PyBUF_WRITABLE != 0 {
            let why = format!("{} is an input: it cannot be written", buffer.name);
            return Err(PyBufferError::new_err(why));
        }
        buffer.exports.fetch_add(1, Ordering::AcqRel);
        let shaped = flags & ffi::PyBUF_ND == ffi::PyBUF_ND;
        let strided = flags & ffi::PyBUF_STRIDES == ffi::PyBUF_STRIDES;
        let formatted = flags & ffi::PyBUF_FORMAT == ffi::PyBUF_FORMAT;
        let rows = buffer.shape[0];
        let columns = if buffer.dimensions == 1 {
            1
        } else {
            buffer.shape[1]
        };
        view.buf = buffer.address as *mut c_void;
        view.len = rows * columns * SIZE;
        view.itemsize = SIZE;
        view.readonly = c_int::from(buffer.read_only);
        view.ndim = buffer.dimensions;
        // The interpreter never writes through these three.
        view.format = if formatted {
            c"d".as_ptr().cast_mut()
        } else {
            std::ptr::null_mut()
        };
        view.shape = if shaped {
            buffer.shape.as_ptr().cast_mut()
        } else {
            std::ptr::null_mut()
        };
        view.strides = if strided {
            buffer.strides.as_ptr().cast_mut()
        } else {
            std::ptr::null_mut()
        };
        view.suboffsets = std::ptr::null_mut();
        view.internal = std::ptr::null_mut();
        view.obj = slf.into_any().into_ptr();
        Ok(())
    }

    /// # Safety
    /// Called by the interpreter only, for a view it got before.
    unsafe fn __releasebuffer__(&self, _view: *mut ffi::Py_buffer) {
        self.exports.fetch_sub(1, Ordering::AcqRel);
    }
}
