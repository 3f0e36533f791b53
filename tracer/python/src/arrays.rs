//! The arrays of a film, which NumPy owns.

use std::collections::HashMap;

use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadwriteArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtcli_tracer::Film;
use rtcli_tracer::world::Window;

/// Returns how many pixels a window has.
pub fn pixels(window: Window) -> u64 {
    u64::from(window.width) * u64::from(window.height)
}

/// The arrays of a film, which nobody else borrows meanwhile.
pub struct PyFilm<'py> {
    floats: HashMap<&'static str, PyReadwriteArrayDyn<'py, f32>>,
    object_id: Option<PyReadwriteArrayDyn<'py, u32>>,
}

/// The arrays of float32.
const FLOATS: [&str; 6] = ["radiance", "depth", "distance", "normal", "position", "albedo"];
const OBJECT_ID: &str = "object_id";

impl<'py> PyFilm<'py> {
    /// Borrows arrays.
    ///
    /// # Errors
    ///
    /// `ValueError` for an unknown name, `TypeError` for another type, `BorrowError` for what is not writable.
    pub fn new(arrays: HashMap<String, Bound<'py, PyAny>>) -> PyResult<Self> {
        let mut film = PyFilm {
            floats: HashMap::new(),
            object_id: None,
        };
        for (name, array) in arrays {
            if name == OBJECT_ID {
                film.object_id = Some(borrowed(&array)?);
            } else if let Some(known) = FLOATS.into_iter().find(|known| *known == name) {
                film.floats.insert(known, borrowed(&array)?);
            } else {
                return Err(PyValueError::new_err(format!("unknown pass {name:?}")));
            }
        }
        Ok(film)
    }

    /// Returns the film of a window over these arrays.
    ///
    /// # Errors
    ///
    /// `ValueError` if there is no radiance, or an array has not the items that the window needs; `TypeError` if they
    /// do not follow each other.
    pub fn film(&mut self, window: Window) -> PyResult<Film<'_>> {
        let mut film = Film::default();
        for (name, array) in &mut self.floats {
            let items = array.as_slice_mut()?;
            match *name {
                "depth" => film.depth = Some(items),
                "distance" => film.distance = Some(items),
                "normal" => film.normal = Some(items),
                "position" => film.position = Some(items),
                "albedo" => film.albedo = Some(items),
                _ => film.radiance = items,
            }
        }
        film.object_id = self.object_id.as_mut().map(|array| array.as_slice_mut()).transpose()?;
        if film.holds(window) {
            Ok(film)
        } else {
            Err(PyValueError::new_err("the arrays do not fit the window"))
        }
    }
}

fn borrowed<'py, T: Element>(array: &Bound<'py, PyAny>) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    Ok(array.cast::<PyArrayDyn<T>>()?.try_readwrite()?)
}
