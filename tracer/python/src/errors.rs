//! The core's errors as Python exceptions.

use std::io;

use pyo3::create_exception;
use pyo3::exceptions::{PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;
use rtcli_tracer::Stopped;
use rtcli_tracer::memory::OutOfMemory;

create_exception!(
    rtcli.tracer._native,
    BudgetExceededError,
    PyRuntimeError,
    "There was more to do than a `WorkBudget` allows."
);

/// `MemoryError`, with the purpose of the memory.
pub fn out_of_memory(error: OutOfMemory) -> PyErr {
    PyMemoryError::new_err(error.to_string())
}

/// The exception of work that ended early. Only the listener cancels work, and then raises an error of its own.
pub fn stopped(stopped: Stopped) -> PyErr {
    match stopped {
        Stopped::Cancelled => PyRuntimeError::new_err(stopped.to_string()),
        Stopped::BudgetExceeded => BudgetExceededError::new_err(stopped.to_string()),
        Stopped::OutOfMemory(error) => out_of_memory(error),
        Stopped::Io(error) => io_error(error),
    }
}

/// `MemoryError` if memory ran out, else `OSError`.
pub fn io_error(error: io::Error) -> PyErr {
    match error.kind() {
        io::ErrorKind::OutOfMemory => PyMemoryError::new_err("not enough memory for a file"),
        _ => error.into(),
    }
}
