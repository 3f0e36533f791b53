//! Errors of the core, as Python has them.

use std::io;

use pyo3::create_exception;
use pyo3::exceptions::{PyMemoryError, PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use rtcli_tracer::Stopped;
use rtcli_tracer::memory::OutOfMemory;
use rtcli_tracer::render::PictureError;

create_exception!(
    rtcli.tracer._native,
    BudgetExceededError,
    PyRuntimeError,
    "There was more to do than a `WorkBudget` allows."
);

/// `MemoryError`, which says what for.
pub fn out_of_memory(error: OutOfMemory) -> PyErr {
    PyMemoryError::new_err(error.to_string())
}

/// Only who listens cancels a rendering, and then raises an error of its own.
pub fn stopped(stopped: Stopped) -> PyErr {
    match stopped {
        Stopped::Cancelled => PyRuntimeError::new_err(stopped.to_string()),
        Stopped::BudgetExceeded => BudgetExceededError::new_err(stopped.to_string()),
        Stopped::OutOfMemory(error) => out_of_memory(error),
    }
}

/// Why a picture was not written.
pub fn unwritten(error: PictureError) -> PyErr {
    match error {
        PictureError::Stopped(reason) => stopped(reason),
        PictureError::Io(error) => io_error(error),
    }
}

/// `MemoryError` if that is the reason, else `OSError`.
pub fn io_error(error: io::Error) -> PyErr {
    match error.kind() {
        io::ErrorKind::OutOfMemory => PyMemoryError::new_err("not enough memory for a file"),
        _ => error.into(),
    }
}

/// `OSError` of threads that the system refuses.
pub fn no_threads(count: usize, error: &dyn std::error::Error) -> PyErr {
    PyOSError::new_err(format!("cannot start {count} threads: {error}"))
}
