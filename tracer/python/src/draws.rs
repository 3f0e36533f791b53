//! Draws of templates, and the bodies that their constraints measure.

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

/// Return a word as a number with `low <= x < high`.
#[pyfunction]
#[pyo3(signature = (word, low, high, /))]
pub fn draw_uniform(word: u64, low: f64, high: f64) -> f64 {
    Draw(word).uniform(low, high)
}

/// Return a word as a number whose logarithm is uniform.
#[pyfunction]
#[pyo3(signature = (word, low, high, /))]
pub fn draw_log_uniform(word: u64, low: f64, high: f64) -> f64 {
    Draw(word).log_uniform(low, high)
}

/// Return a word as a number of a truncated normal distribution.
#[pyfunction]
#[pyo3(signature = (word, mean, deviation, low, high, /))]
pub fn draw_normal(word: u64, mean: f64, deviation: f64, low: f64, high: f64) -> f64 {
    Draw(word).normal(mean, deviation, low, high)
}

/// Return a word as an integer from 0 to `count - 1`.
#[pyfunction]
#[pyo3(signature = (word, count, /))]
pub fn draw_below(word: u64, count: u64) -> u64 {
    Draw(word).below(count)
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
