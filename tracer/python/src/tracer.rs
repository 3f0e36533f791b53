//! The class `Tracer`, which renders a world to a film or a picture.

use std::collections::HashMap;
use std::env;
use std::io::Write;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use rtcli_tracer::Level;
use rtcli_tracer::Monitor;
use rtcli_tracer::meter::MeterReading;
use rtcli_tracer::names::UnknownName;
use rtcli_tracer::world::{Objects, Vector, World};

use crate::arrays::PyFilm;
use crate::display::{PyDisplay, compression, developer, has_pixels};
use crate::interruptible::Listener;
use crate::world::{self, PyCamera, PyCheckers, PyLights, PyObjects, PySettings, PyWindow};

/// The environment variable that forces a SIMD level.
const SIMD: &str = "RTCLI_SIMD";

/// The SIMD level that the tracer uses on this machine.
#[pyfunction]
pub fn simd_level() -> PyResult<&'static str> {
    Ok(level()?.name())
}

/// The offsets of a pixel's samples from its left and top edge.
#[pyfunction]
#[pyo3(signature = (count, /))]
pub fn sample_offsets(count: u32) -> Vec<(f64, f64)> {
    rtcli_tracer::sample_offsets(count)
}

/// The places of an emitter of radius 1.
#[pyfunction]
#[pyo3(signature = (count, /))]
pub fn emitter_places(count: u32) -> Vec<Vector> {
    rtcli_tracer::emitter_places(count)
}

/// Return the SIMD level to use.
///
/// # Errors
///
/// `ValueError` if the environment forces one that this machine lacks.
pub fn level() -> PyResult<Level> {
    let name = env::var_os(SIMD).unwrap_or_default();
    if name.is_empty() {
        return Ok(Level::best());
    }
    let name = name.to_string_lossy();
    name.parse().map_err(|UnknownName| {
        let names = Level::available().into_iter().map(Level::name).collect::<Vec<_>>().join(", ");
        PyValueError::new_err(format!("{SIMD}: unknown SIMD level {name:?}: this machine supports {names}"))
    })
}

/// Return a camera as matrices in JSON, for the pixels of a window.
#[pyfunction]
#[pyo3(signature = (camera, window, /))]
pub fn camera_matrices(camera: PyCamera<'_>, window: PyWindow) -> PyResult<String> {
    let camera = world::camera(camera)?;
    let window = world::window(window, (camera.width, camera.height))?;
    Ok(rtcli_plain::camera_matrices(&camera, window))
}

/// A limit on work, in counted steps.
#[pyclass(frozen, module = "rtcli.tracer._native")]
pub struct WorkBudget {
    core: Arc<rtcli_tracer::WorkBudget>,
}

#[pymethods]
impl WorkBudget {
    #[new]
    #[pyo3(signature = (steps, /))]
    fn new(steps: u64) -> Self {
        WorkBudget { core: Arc::new(rtcli_tracer::WorkBudget::new(steps)) }
    }

    /// The steps that were done so far.
    #[getter]
    fn spent(&self) -> u64 {
        self.core.spent()
    }
}

/// Renders a world to a film or a picture.
#[pyclass(frozen, module = "rtcli.tracer._native")]
pub struct Tracer {
    core: rtcli_tracer::Tracer,
    /// Width and height of the whole picture.
    size: (u32, u32),
    threads: usize,
}

#[pymethods]
impl Tracer {
    #[new]
    #[pyo3(signature = (camera, objects, checkers, lights, settings, threads, /))]
    fn new(
        py: Python<'_>,
        camera: PyCamera<'_>,
        objects: PyObjects<'_>,
        checkers: PyCheckers<'_>,
        lights: PyLights<'_>,
        settings: PySettings,
        threads: usize,
    ) -> PyResult<Self> {
        let level = level()?;
        let objects = world::objects(objects)?;
        let count = objects.count();
        let world = World {
            camera: world::camera(camera)?,
            checkers: world::checkers(checkers, count)?,
            lights: world::lights(lights, count)?,
            objects,
            settings: world::settings(settings)?,
        };
        let listener = Listener::new(0, None, None);
        Ok(Tracer {
            size: (world.camera.width, world.camera.height),
            threads,
            core: listener.run_interruptibly(py, threads, |_, _| rtcli_tracer::Tracer::new(world, level))?,
        })
    }

    /// Render a window into arrays; return the number of rays of their samples, none without radiance or alpha.
    #[pyo3(signature = (window, arrays, progress, /))]
    fn film<'py>(
        &self,
        py: Python<'py>,
        window: PyWindow,
        arrays: HashMap<String, Bound<'py, PyAny>>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<u64> {
        let window = world::window(window, self.size)?;
        let mut arrays = PyFilm::new(arrays)?;
        let film = arrays.film(window)?;
        let listener = Listener::new(window.pixels() as u64, progress, None);
        let work = |monitor: &Monitor, _: &mut (dyn Write + Send)| self.core.film(window, film, monitor);
        listener.run_interruptibly(py, self.threads, work)
    }

    /// Render a window and develop it, within a budget.
    #[pyo3(signature = (window, transform, budget=None, /))]
    fn levels<'py>(
        &self,
        py: Python<'py>,
        window: PyWindow,
        transform: PyDisplay<'py>,
        budget: Option<&WorkBudget>,
    ) -> PyResult<Bound<'py, PyByteArray>> {
        let window = world::window(window, self.size)?;
        let developer = developer(transform)?;
        let listener = Listener::new(0, None, None).within(core(budget));
        let work =
            |monitor: &Monitor, _: &mut (dyn Write + Send)| self.core.levels(window, &developer, false, monitor);
        let (levels, _) = listener.run_interruptibly(py, self.threads, work)?;
        PyByteArray::new_with(py, levels.len(), |copy| {
            copy.copy_from_slice(&levels);
            Ok(())
        })
    }

    /// Render a window to a PNG, passed to `write` in pieces; return the number of rays, and the seconds that
    /// all threads spent tracing, developing and encoding.
    #[pyo3(signature = (window, transform, texts_and_compress, write, progress, /))]
    fn picture<'py>(
        &self,
        py: Python<'py>,
        window: PyWindow,
        transform: PyDisplay<'py>,
        texts_and_compress: (Vec<(String, String)>, String),
        write: Bound<'py, PyAny>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(u64, f64, f64, f64)> {
        let window = world::window(window, self.size)?;
        let (texts, compress) = texts_and_compress;
        let (developer, compression) = (developer(transform)?, compression(&compress)?);
        let listener = Listener::new(window.pixels() as u64, progress, Some(write));
        let work = |monitor: &Monitor, sink: &mut (dyn Write + Send)| {
            self.core.write_png(window, &developer, &texts, compression, sink, monitor)
        };
        let stats = listener.run_interruptibly(py, self.threads, work)?;
        let [trace, develop, write] = [stats.trace, stats.develop, stats.write].map(|time| time.as_secs_f64());
        Ok((stats.rays, trace, develop, write))
    }

    /// Count the pixels of a window that each object would cover if it were alone, within a budget.
    #[pyo3(signature = (window, budget=None, /))]
    fn coverage(&self, py: Python<'_>, window: PyWindow, budget: Option<&WorkBudget>) -> PyResult<Vec<u64>> {
        let window = world::window(window, self.size)?;
        let listener = Listener::new(0, None, None).within(core(budget));
        let work = |monitor: &Monitor, _: &mut (dyn Write + Send)| self.core.coverage(window, monitor);
        listener.run_interruptibly(py, self.threads, work)
    }

    /// Meter the whole picture at `grid` x `grid` points, within a budget; return stops, percentile and number
    /// of rays.
    #[pyo3(signature = (grid, budget=None, /))]
    fn exposure(
        &self,
        py: Python<'_>,
        grid: u32,
        budget: Option<&WorkBudget>,
    ) -> PyResult<(f64, Option<f64>, u64)> {
        has_pixels(grid, grid)?;
        let listener = Listener::new(0, None, None).within(core(budget));
        let work = |monitor: &Monitor, _: &mut (dyn Write + Send)| self.core.exposure(grid, monitor);
        let (MeterReading { stops, percentile }, rays) = listener.run_interruptibly(py, self.threads, work)?;
        Ok((stops, percentile, rays))
    }
}

fn core(budget: Option<&WorkBudget>) -> Option<Arc<rtcli_tracer::WorkBudget>> {
    budget.map(|budget| Arc::clone(&budget.core))
}
