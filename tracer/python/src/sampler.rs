//! Templates as `rtcli/template/compiled.py` compiles them: their draws, and their samples.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyString, PyTuple};
use rtcli_dataset::{Engine, Failure, Made, Models, Outputs, Request, Requirement, Template};
use rtcli_draws::Draw;
use rtcli_plain::PlainScene;
use rtcli_sampler::{Context, Group, Shape, Value};
use rtcli_tracer::world::Camera;

use crate::arrays::pass;
use crate::display::developer_of;
use crate::interruptible::{Listener, bytes_of};
use crate::tracer::level;
use crate::world::{self, plain_scene};

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
    let requirement = |(kind, margin): &(String, f64)| rtcli_sampler::Requirement::new(kind, *margin);
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
pub struct Sampler(Template);

/// An index, an attempt, and the values of the factors in JSON.
type PyDraw = (u64, u64, Vec<String>);

/// A kind of constraint on pictures, its bound, and the number of the group.
type PyRequirement = (String, f64, usize);

#[pymethods]
impl Sampler {
    #[new]
    #[pyo3(signature = (sections, groups, order, requirements, tries, /))]
    fn new(
        sections: &Bound<'_, PyDict>,
        groups: Vec<PyGroup<'_>>,
        order: Vec<usize>,
        requirements: Vec<PyRequirement>,
        tries: u64,
    ) -> PyResult<Sampler> {
        let groups: Vec<_> = groups.into_iter().map(group).collect::<PyResult<_>>()?;
        let numbers = order.iter().copied().chain(groups.iter().filter_map(|group| group.rest_on));
        if numbers.chain(requirements.iter().map(|each| each.2)).any(|number| number >= groups.len()) {
            return Err(unknown("a group"));
        }
        let requirement = |(kind, least, group): &PyRequirement| Requirement::new(kind, *least, *group);
        let requirements = requirements.iter().map(requirement).collect::<Option<_>>();
        let sampler = rtcli_sampler::Sampler { sections: entries(sections)?, groups, order };
        Ok(Sampler(Template {
            sampler,
            requirements: requirements.ok_or_else(|| unknown("a constraint"))?,
            tries,
        }))
    }

    #[pyo3(signature = (draw, /))]
    fn sections<'py>(&self, py: Python<'py>, draw: PyDraw) -> PyResult<Bound<'py, PyDict>> {
        let (index, attempt, factors) = &draw;
        let context = Context { index: *index, attempt: *attempt, element: 0, factors };
        let sections = PyDict::new(py);
        for (key, json) in self.0.sampler.sections(&context).ok_or_else(|| unknown("a value"))? {
            sections.set_item(key, json)?;
        }
        Ok(sections)
    }

    #[pyo3(signature = (draw, request, labels, models, /))]
    fn sample(
        &self,
        py: Python<'_>,
        draw: (u64, Vec<String>),
        request: PyRequest,
        labels: Option<(String, String, bool)>,
        models: Py<PyAny>,
    ) -> PyResult<Sample> {
        let (index, factors) = &draw;
        let outputs = request.outputs.iter().map(String::as_str).try_fold(Outputs::default(), with)?;
        let wanted = Request {
            index: *index,
            factors,
            tries: request.tries.unwrap_or(u64::MAX),
            passes: &request.passes.iter().map(|name| pass(name)).collect::<PyResult<Vec<_>>>()?,
            outputs,
            labels: labels.as_ref().map(|(split, factors, has_objects)| (&split[..], &factors[..], *has_objects)),
        };
        let mut models = PyModels { models, error: None };
        let level = level()?;
        let made = Listener::default().run_interruptibly(py, request.threads, |monitor, _| {
            let software = concat!("rtcli ", env!("CARGO_PKG_VERSION"));
            let engine = Engine { level, developers: developer_of, monitor, software };
            match self.0.make(&wanted, engine, &mut models) {
                Ok(made) => Ok(Some(made)),
                Err(Failure::Unknown) => Ok(None),
                Err(Failure::Stopped(stopped)) => Err(stopped),
            }
        });
        match models.error {
            Some(error) => Err(error),
            None => Sample::new(py, made?.ok_or_else(|| unknown("a value"))?),
        }
    }
}

/// A `rtcli.dataset.sample.SampleRequest`.
#[derive(FromPyObject)]
struct PyRequest {
    passes: Vec<String>,
    outputs: Vec<String>,
    threads: usize,
    tries: Option<u64>,
}

fn with(outputs: Outputs, name: &str) -> PyResult<Outputs> {
    Ok(match name {
        "files" => Outputs { files: true, ..outputs },
        "tar" => Outputs { tar: true, ..outputs },
        "parts" => Outputs { parts: true, ..outputs },
        "arrays" => Outputs { arrays: true, ..outputs },
        "levels" => Outputs { levels: true, ..outputs },
        _ => return Err(PyValueError::new_err(format!("unknown output {name:?}"))),
    })
}

/// The models in Python, `rtcli.dataset.models`.
struct PyModels {
    models: Py<PyAny>,
    error: Option<PyErr>,
}

impl PyModels {
    /// Returns an answer, which is a text if it is the reason why something is not valid.
    fn ask<T>(
        &mut self,
        question: &str,
        json: &str,
        read: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, String> {
        let answer = Python::attach(|py| {
            let answer = self.models.bind(py).call_method1(question, (json,))?;
            match answer.extract() {
                Ok(reason) => Ok(Err(reason)),
                Err(_) => read(&answer).map(Ok),
            }
        });
        answer.unwrap_or_else(|error| {
            self.error = Some(error);
            Err(String::new())
        })
    }
}

impl Models for PyModels {
    fn camera_of(&mut self, camera: &str) -> Result<Camera, String> {
        self.ask("camera_of", camera, |answer| world::camera(answer.extract()?))
    }

    fn shape_of(&mut self, object: &str) -> Result<Shape, String> {
        self.ask("shape_of", object, |answer| {
            let (kind, position, parameters) = answer.extract()?;
            Ok(Shape { kind, position, parameters })
        })
    }

    fn scene_of(&mut self, scene: &str) -> Result<PlainScene, String> {
        self.ask("scene_of", scene, |answer| plain_scene(answer.extract()?))
    }

    fn has_failed(&self) -> bool {
        self.error.is_some()
    }
}

/// A sample, and how it was found.
#[pyclass(module = "rtcli.tracer._native", frozen, get_all)]
pub struct Sample {
    attempt: u64,
    groups: Vec<usize>,
    text: Option<String>,
    labels: Option<Py<PyBytes>>,
    files: Vec<(String, Py<PyBytes>)>,
    tar: Py<PyBytes>,
    parts: Vec<(&'static str, &'static str, Py<PyBytes>)>,
    arrays: Vec<(&'static str, Py<PyTuple>, &'static str, Py<PyBytes>)>,
    levels: Option<(Py<PyTuple>, Py<PyBytes>)>,
    draws: usize,
    checks: Vec<(&'static str, usize)>,
    refusals: Vec<(&'static str, usize, usize, String)>,
}

impl Sample {
    fn new(py: Python<'_>, made: Made) -> PyResult<Sample> {
        let Made { sample, rejections } = made;
        let is_found = sample.is_some();
        let sample = sample.unwrap_or_default();
        let bytes = |bytes: &[u8]| bytes_of(py, bytes).map(Bound::unbind);
        let tuple = |lengths: &[usize]| PyTuple::new(py, lengths).map(Bound::unbind);
        Ok(Sample {
            attempt: sample.attempt,
            groups: sample.groups,
            text: is_found.then_some(sample.text),
            labels: sample.labels.map(|labels| bytes(labels.as_bytes())).transpose()?,
            files: sample
                .files
                .into_iter()
                .map(|(end, file)| Ok((end, bytes(&file)?)))
                .collect::<PyResult<_>>()?,
            tar: bytes(&sample.tar)?,
            parts: sample
                .parts
                .into_iter()
                .map(|(name, suffix, file)| Ok((name, suffix, bytes(&file)?)))
                .collect::<PyResult<_>>()?,
            arrays: sample
                .arrays
                .into_iter()
                .map(|(name, shape, of, data)| Ok((name, tuple(&shape)?, of, bytes(&data)?)))
                .collect::<PyResult<_>>()?,
            levels: sample
                .levels
                .map(|(shape, data)| Ok::<_, PyErr>((tuple(&shape)?, bytes(&data)?)))
                .transpose()?,
            draws: rejections.draws,
            checks: rejections.checks,
            refusals: rejections
                .refusals
                .into_iter()
                .map(|each| (each.kind, each.count, each.ended, each.last))
                .collect(),
        })
    }
}
