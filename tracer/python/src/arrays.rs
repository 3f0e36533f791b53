//! The arrays of a film, which Python owns.

use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use rtcli_tracer::Film;
use rtcli_tracer::world::Window;

/// The passes of a film beside radiance, and their components a pixel.
const PASSES: [(&str, usize); 6] = [
    ("depth", 1),
    ("distance", 1),
    ("normal", 3),
    ("position", 3),
    ("albedo", 3),
    ("object_id", 1),
];

/// Returns how many pixels a window has.
pub fn pixels(window: Window) -> u64 {
    u64::from(window.width) * u64::from(window.height)
}

/// Returns the arrays of a film with these passes: the name of each, and its components a pixel.
///
/// # Errors
///
/// `ValueError` for an unknown pass.
pub fn arrays_of(passes: &[String]) -> PyResult<Vec<(&'static str, usize)>> {
    let pass = |name: &String| {
        let known = PASSES.into_iter().find(|(known, _)| known == name);
        known.ok_or_else(|| PyValueError::new_err(format!("unknown pass {name:?}")))
    };
    let mut arrays = vec![("radiance", 3)];
    for name in passes {
        let array = pass(name)?;
        if !arrays.contains(&array) {
            arrays.push(array);
        }
    }
    Ok(arrays)
}

/// Returns how long an array of a window is.
///
/// # Errors
///
/// `MemoryError` if no memory holds it.
pub fn byte_length(window: Window, components: usize) -> PyResult<usize> {
    let too_large = || PyMemoryError::new_err("the film is larger than all memory");
    let pixels = usize::try_from(pixels(window)).map_err(|_| too_large())?;
    // Each component is a float32 or uint32; an array of Python is at most isize::MAX long.
    let bytes = pixels.checked_mul(components * 4).ok_or_else(too_large)?;
    isize::try_from(bytes).map_err(|_| too_large())?;
    Ok(bytes)
}

/// Makes a `bytearray` of each length, and has all of them filled while nobody else sees them.
///
/// Each is writable only inside of `PyByteArray::new_with`, so the calls are nested, one for each array.
pub fn with_arrays<'py>(
    py: Python<'py>,
    lengths: &[usize],
    open: Vec<&mut [u8]>,
    made: &mut Vec<Bound<'py, PyByteArray>>,
    fill: &mut dyn FnMut(Vec<&mut [u8]>) -> PyResult<()>,
) -> PyResult<()> {
    let Some((length, others)) = lengths.split_first() else {
        return fill(open);
    };
    let array = PyByteArray::new_with(py, *length, |bytes| {
        let mut open = open; // for the shorter time that these bytes are writable
        open.push(bytes);
        with_arrays(py, others, open, made, fill)
    })?;
    made.push(array); // after the arrays that follow it
    Ok(())
}

/// Returns the film over these arrays.
pub fn film_over<'a>(arrays: &[(&str, usize)], bytes: Vec<&'a mut [u8]>) -> PyResult<Film<'a>> {
    let mut film = Film::default();
    for ((name, _), bytes) in arrays.iter().zip(bytes) {
        match *name {
            "depth" => film.depth = Some(items(bytes)?),
            "distance" => film.distance = Some(items(bytes)?),
            "normal" => film.normal = Some(items(bytes)?),
            "position" => film.position = Some(items(bytes)?),
            "albedo" => film.albedo = Some(items(bytes)?),
            "object_id" => film.object_id = Some(items(bytes)?),
            _ => film.radiance = items(bytes)?,
        }
    }
    Ok(film)
}

/// Returns the bytes of a new array as its items, for which Python aligns them.
fn items<T: bytemuck::Pod>(bytes: &mut [u8]) -> PyResult<&mut [T]> {
    bytemuck::try_cast_slice_mut(bytes).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}
