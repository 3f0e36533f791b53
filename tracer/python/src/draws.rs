//! The random words of templates, and the bodies that are measured.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtcli_draws::Draw;

/// Return the word of a key, and of an index, an attempt, and the number of an object in its group.
#[pyfunction]
#[pyo3(signature = (key, counter, /))]
pub fn draw_word(key: (u64, u64), counter: (u64, u64, u64)) -> u64 {
    let (index, attempt, element) = counter;
    Draw::new(key.into(), index, attempt, element).0
}

/// A solid object.
#[pyclass(module = "rtcli.tracer._native", frozen)]
pub struct Body(rtcli_bodies::Body);

#[pymethods]
impl Body {
    #[new]
    #[pyo3(signature = (kind, position, parameters, /))]
    fn new(kind: &str, position: [f64; 3], parameters: Vec<f64>) -> PyResult<Body> {
        let body = rtcli_bodies::Body::new(kind, position, &parameters);
        body.map(Body).ok_or_else(|| PyValueError::new_err(format!("{kind} is not a solid shape")))
    }

    #[pyo3(signature = (direction, /))]
    fn reach(&self, direction: [f64; 3]) -> f64 {
        self.0.reach(direction)
    }

    fn inradius(&self) -> f64 {
        self.0.inradius()
    }

    #[pyo3(signature = (other, /))]
    fn distance(&self, other: &Body) -> f64 {
        self.0.distance(&other.0)
    }
}
