//! The arrays of a film, which NumPy owns.

use std::collections::HashMap;

use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadwriteArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtcli_tracer::names::UnknownName;
use rtcli_tracer::world::Window;
use rtcli_tracer::{Film, Pass, ValueType, Values};

/// The arrays of a film, borrowed from Python.
pub struct PyFilm<'py> {
    arrays: Vec<(Pass, PyArray<'py>)>,
}

enum PyArray<'py> {
    Floats(PyReadwriteArrayDyn<'py, f32>),
    Integers(PyReadwriteArrayDyn<'py, u32>),
}

impl<'py> PyFilm<'py> {
    /// Borrow arrays.
    ///
    /// # Errors
    ///
    /// `ValueError` for an unknown name, `TypeError` for another type, `BorrowError` for an array that is not
    /// writable.
    pub fn new(arrays: HashMap<String, Bound<'py, PyAny>>) -> PyResult<Self> {
        let borrow = |(name, array): (String, Bound<'py, PyAny>)| {
            let pass = pass(&name)?;
            let array = match pass.value_type() {
                ValueType::Float => PyArray::Floats(borrowed(&array)?),
                ValueType::Integer => PyArray::Integers(borrowed(&array)?),
            };
            Ok((pass, array))
        };
        let arrays: PyResult<Vec<_>> = arrays.into_iter().map(borrow).collect();
        Ok(PyFilm { arrays: arrays? })
    }

    /// Return the film of a window over these arrays.
    ///
    /// # Errors
    ///
    /// `ValueError` if an array has not the items that the window needs; `TypeError` if they do not follow each
    /// other.
    pub fn film(&mut self, window: Window) -> PyResult<Film<'_>> {
        let mut film = Film::default();
        for (pass, array) in &mut self.arrays {
            let values = match array {
                PyArray::Floats(array) => Values::Floats(array.as_slice_mut()?),
                PyArray::Integers(array) => Values::Integers(array.as_slice_mut()?),
            };
            film = film.with(*pass, values);
        }
        if film.holds(window) { Ok(film) } else { Err(PyValueError::new_err("the arrays do not fit the window")) }
    }
}

/// Return the pass of a name.
///
/// # Errors
///
/// `ValueError` for an unknown name.
pub fn pass(name: &str) -> PyResult<Pass> {
    name.parse().map_err(|UnknownName| PyValueError::new_err(format!("unknown pass {name:?}")))
}

fn borrowed<'py, T: Element>(array: &Bound<'py, PyAny>) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    Ok(array.cast::<PyArrayDyn<T>>()?.try_readwrite()?)
}
