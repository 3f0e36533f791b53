//! How Python names the parts of a scene file, and its format.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtcli_reader::Format;
use rtcli_reader::scene::Step;

/// A step into a list or mapping.
#[derive(FromPyObject, IntoPyObject)]
pub enum PyStep {
    Index(usize),
    Key(String),
}

impl PyStep {
    /// Returns the step for the reader.
    pub fn as_step(&self) -> Step<'_> {
        match self {
            PyStep::Index(index) => Step::Index(*index),
            PyStep::Key(key) => Step::Key(key),
        }
    }
}

/// Returns the format of a name.
pub fn format_of(name: &str) -> PyResult<Format> {
    match name {
        "json" => Ok(Format::Json),
        "yaml" => Ok(Format::Yaml),
        _ => Err(PyValueError::new_err(format!("unknown format {name:?}"))),
    }
}
