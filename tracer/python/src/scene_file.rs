//! How Python names the parts of a scene file, and its format.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtcli_reader::Format;
use rtcli_reader::scene::{Edit, Step};

/// A step into a list or mapping.
#[derive(FromPyObject, IntoPyObject)]
pub enum PyStep {
    Index(usize),
    Key(String),
}

impl PyStep {
    fn as_step(&self) -> Step<'_> {
        match self {
            PyStep::Index(index) => Step::Index(*index),
            PyStep::Key(key) => Step::Key(key),
        }
    }
}

/// The path of a value, and the value in YAML.
pub type PyEdit = (Vec<PyStep>, String);

/// Returns changes as the reader takes them.
pub fn borrowed(edits: &[PyEdit]) -> Vec<Edit<'_>> {
    edits.iter().map(|(path, value)| Edit { path: path.iter().map(PyStep::as_step).collect(), value }).collect()
}

/// Returns the format of a name.
pub fn format_of(name: &str) -> PyResult<Format> {
    match name {
        "json" => Ok(Format::Json),
        "yaml" => Ok(Format::Yaml),
        _ => Err(PyValueError::new_err(format!("unknown format {name:?}"))),
    }
}
