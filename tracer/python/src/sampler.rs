//! Templates as `rtcli/template/compiled.py` compiles them: their draws, and their objects.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString, PyTuple};
use rtcli_draws::Draw;
use rtcli_reader::Format;
use rtcli_sampler::{Caller, Context, Group, Requirement, Shape, Value, View};
use rtcli_tracer::world::Projection;

use crate::scene::columns;

/// Keeps the focal length of the narrowest field of view finite, as in `rtcli.tracer.world`.
const SMALLEST: f64 = 1e-300;

fn unknown(what: &str) -> PyErr {
    PyValueError::new_err(format!("no checked template has such {what}"))
}

/// A value: its text in JSON, a list, a mapping, or a draw as its kind, its key, its parameters and values within it.
struct PyValue(Value);

impl<'py> FromPyObject<'_, 'py> for PyValue {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<PyValue> {
        if value.is_instance_of::<PyString>() {
            Ok(PyValue(Value::Constant(value.extract()?)))
        } else if value.is_instance_of::<PyList>() {
            Ok(PyValue(Value::List(values(value.extract()?))))
        } else if value.is_instance_of::<PyDict>() {
            Ok(PyValue(Value::Mapping(entries(&value)?)))
        } else {
            Ok(PyValue(Value::Drawn(value.extract::<Drawn>()?.0)))
        }
    }
}

fn values(values: Vec<PyValue>) -> Vec<Value> {
    values.into_iter().map(|value| value.0).collect()
}

/// Returns the keys of a mapping with their values.
fn entries(mapping: &Bound<'_, PyAny>) -> PyResult<Vec<(String, Value)>> {
    let entries = mapping.cast::<PyDict>()?.iter();
    entries.map(|(key, value)| Ok((key.extract()?, value.extract::<PyValue>()?.0))).collect()
}

/// A draw.
#[pyclass(module = "rtcli.tracer._native", frozen)]
pub struct Drawn(rtcli_sampler::Drawn);

impl<'py> FromPyObject<'_, 'py> for Drawn {
    type Error = PyErr;

    fn extract(draw: Borrowed<'_, 'py, PyAny>) -> PyResult<Drawn> {
        let (kind, key, numbers, parts): (String, [u64; 2], _, _) = draw.extract()?;
        rtcli_sampler::Drawn::new(&kind, key, numbers, values(parts)).map(Drawn).ok_or_else(|| unknown("a draw"))
    }
}

#[pymethods]
impl Drawn {
    #[new]
    #[pyo3(signature = (draw, /))]
    fn new(draw: Drawn) -> Drawn {
        draw
    }

    #[pyo3(signature = (word, index, /))]
    fn value(&self, word: u64, index: u64) -> PyResult<String> {
        let context = Context { index, attempt: 0, element: 0, factors: &[] };
        let mut json = String::new();
        self.0.write(Draw(word), &context, &mut json).ok_or_else(|| unknown("a value"))?;
        Ok(json)
    }
}

/// An item under `objects`: its name, the number of its objects, the number of the group that they rest on, the
/// number of the alternative, the alternatives, and the kinds and margins of constraints.
type PyGroup<'py> =
    (Option<String>, Option<PyValue>, Option<usize>, PyValue, Vec<Bound<'py, PyAny>>, Vec<(String, f64)>);

fn group((name, repeat, rest_on, form, alternatives, requirements): PyGroup<'_>) -> PyResult<Group> {
    let requirement = |(kind, margin): &(String, f64)| Requirement::new(kind, *margin);
    Ok(Group {
        name,
        repeat: repeat.map(|repeat| repeat.0),
        rest_on,
        form: form.0,
        alternatives: alternatives.iter().map(entries).collect::<PyResult<_>>()?,
        requirements: requirements
            .iter()
            .map(requirement)
            .collect::<Option<_>>()
            .ok_or_else(|| unknown("a constraint"))?,
    })
}

/// A template.
#[pyclass(module = "rtcli.tracer._native", frozen)]
pub struct Sampler(rtcli_sampler::Sampler);

/// An index, an attempt, and the values of the factors in JSON.
type PySample = (u64, u64, Vec<String>);

#[pymethods]
impl Sampler {
    #[new]
    #[pyo3(signature = (sections, groups, order, /))]
    fn new(sections: &Bound<'_, PyDict>, groups: Vec<PyGroup<'_>>, order: Vec<usize>) -> PyResult<Sampler> {
        let groups: Vec<_> = groups.into_iter().map(group).collect::<PyResult<_>>()?;
        let numbers = order.iter().copied().chain(groups.iter().filter_map(|group| group.rest_on));
        if numbers.into_iter().any(|number| number >= groups.len()) {
            return Err(unknown("a group"));
        }
        Ok(Sampler(rtcli_sampler::Sampler { sections: entries(sections)?, groups, order }))
    }

    #[pyo3(signature = (sample, /))]
    fn sections<'py>(&self, py: Python<'py>, sample: PySample) -> PyResult<Bound<'py, PyDict>> {
        let (index, attempt, factors) = &sample;
        let context = Context { index: *index, attempt: *attempt, element: 0, factors };
        let sections = PyDict::new(py);
        for (key, json) in self.0.sections(&context).ok_or_else(|| unknown("a value"))? {
            sections.set_item(key, json)?;
        }
        Ok(sections)
    }

    #[pyo3(signature = (sample, tries, frame_of, shape_of, /))]
    fn draw(
        &self,
        py: Python<'_>,
        sample: PySample,
        tries: u64,
        frame_of: &Bound<'_, PyAny>,
        shape_of: Py<PyAny>,
    ) -> PyResult<Placement> {
        let (index, attempt, factors) = &sample;
        let context = Context { index: *index, attempt: *attempt, element: 0, factors };
        let mut sections = self.0.sections(&context).ok_or_else(|| unknown("a value"))?;
        let camera = sections.iter().find(|(key, _)| *key == "camera").map_or("{}", |(_, camera)| camera);
        let view = match plain_view(camera) {
            Some(view) => view,
            None => frame_of.call1((camera,))?.extract::<Frame>()?.view(),
        };
        let mut caller = Listener { shape_of, error: None };
        let (placement, scene) = py.detach(|| {
            let mut placement = self.0.place(&context, tries, &view, &mut caller);
            let objects = placement.as_mut().and_then(|placement| placement.objects.take());
            let scene = objects.map(|objects| {
                sections.push(("objects", objects));
                let text = rtcli_sampler::mapping(&sections);
                (rtcli_reader::read(text.as_bytes(), Format::Json, &[]), text)
            });
            (placement, scene)
        });
        if let Some(error) = caller.error {
            return Err(error);
        }
        let rtcli_sampler::Placement { counts, invalid, draws, checks, refusals, .. } =
            placement.ok_or_else(|| unknown("a value"))?;
        let (scene, text) = scene.map_or((None, None), |(scene, text)| (scene, Some(text)));
        let scene = scene.map(|scene| columns(py, scene)).transpose()?.flatten();
        Ok(Placement {
            counts,
            text,
            scene: scene.map(|scene| Ok::<_, PyErr>(scene.into_pyobject(py)?.unbind())).transpose()?,
            invalid,
            draws,
            checks,
            refusals: refusals.into_iter().map(|each| (each.kind, each.count, each.ended, each.last)).collect(),
        })
    }
}

/// Returns what a camera in JSON shows; None if it is not plainly valid.
fn plain_view(camera: &str) -> Option<View> {
    let scene = rtcli_reader::read(format!("{{\"camera\":{camera}}}").as_bytes(), Format::Json, &[])?;
    let (camera, _) = rtcli_plain::camera(&scene.sections)?;
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let focal = height / (2.0 * camera.half_height).max(SMALLEST);
    let focal_lengths = [focal / camera.pixel_aspect, focal];
    let (x, y) = camera.center;
    Some(View {
        size: [width, height],
        focal_lengths,
        principal_point: [width / 2.0 - x * focal_lengths[0], height / 2.0 + y * focal_lengths[1]],
        is_orthographic: camera.projection == Projection::Orthographic,
        position: camera.position,
        right: camera.right,
        up: camera.up,
        forward: camera.forward,
    })
}

/// Python, which validates objects and is given signals.
struct Listener {
    shape_of: Py<PyAny>,
    error: Option<PyErr>,
}

impl Caller for Listener {
    fn shape_of(&mut self, json: &str) -> Option<Shape> {
        type Found = Option<(String, [f64; 3], Vec<f64>)>;
        let found: PyResult<Found> = Python::attach(|py| self.shape_of.call1(py, (json,))?.extract(py));
        let (kind, position, parameters) = found.map_err(|error| self.error = Some(error)).ok()??;
        Some(Shape { kind, position, parameters })
    }

    fn is_cancelled(&mut self) -> bool {
        let signaled = Python::attach(|py| py.check_signals());
        signaled.map_err(|error| self.error = Some(error)).is_err()
    }
}

/// A `rtcli.tracer.world.CameraFrame`.
#[derive(FromPyObject)]
struct Frame {
    width: f64,
    height: f64,
    focal_lengths: [f64; 2],
    principal_point: [f64; 2],
    is_orthographic: bool,
    position: [f64; 3],
    right: [f64; 3],
    up: [f64; 3],
    forward: [f64; 3],
}

impl Frame {
    fn view(&self) -> View {
        let Frame { width, height, focal_lengths, principal_point, is_orthographic, position, right, up, forward } =
            *self;
        View {
            size: [width, height],
            focal_lengths,
            principal_point,
            is_orthographic,
            position,
            right,
            up,
            forward,
        }
    }
}

/// The scene of a sample, and how its objects were found.
#[pyclass(module = "rtcli.tracer._native", frozen, get_all)]
pub struct Placement {
    counts: Vec<usize>,
    text: Option<String>,
    scene: Option<Py<PyTuple>>,
    invalid: Option<String>,
    draws: usize,
    checks: Vec<(&'static str, usize)>,
    refusals: Vec<(&'static str, usize, usize, String)>,
}
