//! The boxes around the objects of a scene, and the search for those that hold others.

use std::borrow::Cow;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtcli_bodies::boxes::{Beyond, Triple};

use crate::columns::items;

/// The box around each of many objects.
#[pyclass(module = "rtcli.tracer._native", frozen)]
pub struct Boxes(Arc<rtcli_bodies::boxes::Boxes>);

#[pymethods]
impl Boxes {
    #[new]
    #[pyo3(signature = (centers, halves, /))]
    fn new(centers: &[u8], halves: &[u8]) -> PyResult<Boxes> {
        let (centers, halves) = (items(centers)?, items(halves)?);
        if centers.len() != halves.len() {
            return Err(PyValueError::new_err("each box has a center and a size"));
        }
        let boxes = rtcli_bodies::boxes::Boxes::new(Cow::into_owned(centers), Cow::into_owned(halves));
        Ok(Boxes(Arc::new(boxes)))
    }

    #[pyo3(signature = (center, half, /))]
    fn meeting(&self, py: Python<'_>, center: Triple, half: Triple) -> Vec<usize> {
        py.detach(|| self.0.meeting(center, half))
    }

    #[pyo3(signature = (eye, planes, /))]
    fn beyond(&self, py: Python<'_>, eye: Triple, planes: Vec<(Triple, f64, f64)>) -> Vec<usize> {
        let beyond = |(normal, offset, limit)| Beyond { normal, offset, limit };
        let planes: Vec<_> = planes.into_iter().map(beyond).collect();
        py.detach(|| self.0.beyond(eye, &planes))
    }
}

/// A search for boxes that hold others.
#[pyclass(module = "rtcli.tracer._native")]
pub struct Enclosures(rtcli_bodies::enclosures::Enclosures);

#[pymethods]
impl Enclosures {
    #[new]
    #[pyo3(signature = (boxes, chosen, comparisons, /))]
    fn new(boxes: &Boxes, chosen: Vec<usize>, comparisons: u32) -> PyResult<Enclosures> {
        for &index in &chosen {
            in_range(boxes.0.len(), index)?;
        }
        Ok(Enclosures(rtcli_bodies::enclosures::Enclosures::new(Arc::clone(&boxes.0), &chosen, comparisons)))
    }

    #[getter]
    fn gave_up(&self) -> bool {
        self.0.gave_up()
    }

    #[pyo3(signature = (center, half, is_wanted, /))]
    fn around(&mut self, center: Triple, half: Triple, is_wanted: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
        self.0.around((center, half), |outer| is_wanted.call1((outer,))?.is_truthy())
    }

    #[pyo3(signature = (inner, start, is_wanted, /))]
    fn first_inside(
        &mut self,
        inner: &[u8],
        start: usize,
        is_wanted: &Bound<'_, PyAny>,
    ) -> PyResult<Option<(usize, usize)>> {
        let inner = items::<u64>(inner)?;
        // Each index is checked when its turn comes: a caller that goes on after each box found would else have all
        // that wait checked again each time.
        let count = self.0.len();
        let waiting = inner.iter().skip(start).map(|&index| in_range(count, index as usize));
        let found = self.0.first_inside(waiting, |inner, outer| is_wanted.call1((inner, outer))?.is_truthy())?;
        Ok(found.map(|(place, outer)| (start + place, outer)))
    }
}

/// Returns an index, if there is such a box.
fn in_range(count: usize, index: usize) -> PyResult<usize> {
    if index < count { Ok(index) } else { Err(PyValueError::new_err(format!("there is no box {index}"))) }
}
