//! Valid scene files as packed columns; `rtcli/tracer/world.py` describes each number.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString, PyTuple};
use rtcli_reader::scene::{Setting, light_kinds, shapes};
use rtcli_reader::{Lights, Objects, Scene, Section};
use rtcli_tracer::memory::reserve;
use rtcli_tracer::world::{Camera, Kind, LightSource, ShapeDesc};

use crate::columns::items;
use crate::errors::out_of_memory;
use crate::interruptible::bytes_of;
use crate::scene_file::{PyEdit, borrowed, format_of};
use crate::world::for_each_row;

/// The sections, the columns of objects, of checkers and of lights, and the names of the objects.
pub type PyScene<'py> =
    (Bound<'py, PyDict>, Bound<'py, PyTuple>, Bound<'py, PyTuple>, Bound<'py, PyTuple>, Bound<'py, PyString>);

/// Reads a scene file with some changes; returns None if it is not plainly valid.
#[pyfunction]
#[pyo3(signature = (file, format, edits, /))]
pub fn read_scene<'py>(
    py: Python<'py>,
    file: &[u8],
    format: &str,
    edits: Vec<PyEdit>,
) -> PyResult<Option<PyScene<'py>>> {
    let (format, edits) = (format_of(format)?, borrowed(&edits));
    let scene = py.detach(|| rtcli_reader::read(file, format, &edits));
    scene.map(|scene| columns(py, scene)).transpose().map(Option::flatten)
}

/// Returns a scene that was read as columns; None if its camera is not plainly valid.
pub fn columns(py: Python<'_>, scene: Scene) -> PyResult<Option<PyScene<'_>>> {
    let Some((camera, lens)) = rtcli_plain::camera(&scene.sections) else { return Ok(None) };
    let Scene { sections, objects, checkers, lights } = scene;
    let dict = PyDict::new(py);
    for (key, section) in sections {
        dict.set_item(key, values(py, section)?)?;
    }
    let Camera { width, height, half_height, pixel_aspect, center, position, right, up, forward, .. } = camera;
    let [position, right, up, forward] = [position, right, up, forward].map(<(f64, f64, f64)>::from);
    let frame = (
        width,
        height,
        half_height,
        pixel_aspect,
        center,
        position,
        right,
        up,
        forward,
        lens.fov,
        lens.projection,
    );
    dict.set_item("camera", frame)?;
    let names = PyString::from_bytes(py, &objects.names)?;
    let checkers = [column(py, &checkers.object)?, column(py, &checkers.size)?, column(py, &checkers.color)?];
    let checkers = PyTuple::new(py, checkers)?;
    Ok(Some((dict, object_columns(py, objects)?, checkers, light_columns(py, lights)?, names)))
}

/// Returns the values of a section by key.
fn values<'py>(py: Python<'py>, section: Section) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, setting) in section {
        match setting {
            Setting::Boolean(value) => dict.set_item(key, value)?,
            Setting::Integer(value) => dict.set_item(key, value)?,
            Setting::Number(value) => dict.set_item(key, value)?,
            Setting::Numbers(values) => dict.set_item(key, PyTuple::new(py, values)?)?,
            Setting::Integers(values) => dict.set_item(key, PyTuple::new(py, values)?)?,
            Setting::Word(word) => dict.set_item(key, word)?,
            Setting::Missing => dict.set_item(key, py.None())?,
        }
    }
    Ok(dict)
}

fn object_columns(py: Python<'_>, objects: Objects) -> PyResult<Bound<'_, PyTuple>> {
    let kind = tags(&objects.kind, shapes(), ShapeDesc::KINDS)?;
    let columns = [
        bytes_of(py, &kind)?,
        column(py, &objects.position)?,
        column(py, &objects.parameters)?,
        column(py, &objects.color)?,
    ];
    PyTuple::new(py, columns)
}

fn light_columns(py: Python<'_>, lights: Lights) -> PyResult<Bound<'_, PyTuple>> {
    let kind = tags(&lights.kind, light_kinds(), LightSource::KINDS)?;
    let columns = [
        bytes_of(py, &kind)?,
        column(py, &lights.parameters)?,
        column(py, &lights.color)?,
        column(py, &lights.intensity)?,
        column(py, &lights.carrier)?,
    ];
    PyTuple::new(py, columns)
}

fn column<'py, T: bytemuck::NoUninit>(py: Python<'py>, numbers: &[T]) -> PyResult<Bound<'py, PyBytes>> {
    bytes_of(py, bytemuck::cast_slice(numbers))
}

/// Returns the tracer's tags of the reader's kinds.
fn tags(kinds: &[u8], names: impl Iterator<Item = &'static str>, known: &[Kind]) -> PyResult<Vec<u8>> {
    let tag = |name| known.iter().position(|kind| kind.name == name);
    let unknown = || PyValueError::new_err("the reader has a kind that the tracer lacks");
    let tags: Option<Vec<_>> = names.map(|name| tag(name).map(|tag| tag as u8)).collect();
    let tags = tags.ok_or_else(unknown)?;
    Ok(kinds.iter().map(|&kind| tags[usize::from(kind)]).collect())
}

/// Return three of the parameters of each shape, a single one three times; the fourth or 0; and the rest.
#[pyfunction]
#[pyo3(signature = (kinds, parameters, /))]
pub fn by_threes<'py>(py: Python<'py>, kinds: &[u8], parameters: &[u8]) -> PyResult<Bound<'py, PyTuple>> {
    let (mut threes, mut fourths, mut rest): (Vec<f64>, Vec<f64>, Vec<f64>) = Default::default();
    reserve(&mut threes, 3 * kinds.len(), "the metadata").map_err(out_of_memory)?;
    reserve(&mut fourths, kinds.len(), "the metadata").map_err(out_of_memory)?;
    reserve(&mut rest, parameters.len() / size_of::<f64>(), "the metadata").map_err(out_of_memory)?;
    for_each_row(ShapeDesc::KINDS, kinds, &items(parameters)?, |_, own| {
        threes.extend(own.iter().cycle().take(3));
        fourths.push(own.get(3).copied().unwrap_or_default());
        rest.extend(own.iter().skip(4));
        Ok(())
    })?;
    PyTuple::new(py, [column(py, &threes)?, column(py, &fourths)?, column(py, &rest)?])
}
