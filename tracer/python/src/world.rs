//! The conversion of packed columns to a `World`; `rtcli/tracer/world.py` describes each number.

use crate::columns::items;
use crate::display::has_pixels;
use crate::errors::out_of_memory;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtcli_plain::PlainScene;
use rtcli_tracer::memory::{reserve, with_capacity};
use rtcli_tracer::names::UnknownName;
use rtcli_tracer::world::{
    Camera, CheckerDesc, Columns, Kind, LightDesc, LightSource, Object, Objects, Settings, ShapeDesc, Vector,
    Window, World,
};

/// The most objects whose faces can be numbered in 32 bits.
const MOST_OBJECTS: usize = 1 << 28;

/// Width, height, projection, half height, pixel aspect, center, position, right, up, forward.
pub type PyCamera<'a> = (u32, u32, &'a str, f64, f64, (f64, f64), Vector, Vector, Vector, Vector);

/// Kind (u8), position, parameters, color (f64), in native byte order.
pub type PyObjects<'a> = (&'a [u8], &'a [u8], &'a [u8], &'a [u8]);

/// Object (i64), size, color (f64), in native byte order.
pub type PyCheckers<'a> = (&'a [u8], &'a [u8], &'a [u8]);

/// Kind (u8), parameters, color, intensity (f64), carrier (i64), in native byte order.
pub type PyLights<'a> = (&'a [u8], &'a [u8], &'a [u8], &'a [u8], &'a [u8]);

/// Samples, background, ambient light, whether there is direct light, shadow samples, eye falloff.
pub type PySettings = (u32, Vector, Vector, bool, u32, bool);

/// Left, top, width, height.
pub type PyWindow = (u32, u32, u32, u32);

/// Return the camera.
///
/// # Errors
///
/// `ValueError` for a picture without pixels, or an unknown projection.
pub fn camera(camera: PyCamera<'_>) -> PyResult<Camera> {
    let (width, height, projection, half_height, pixel_aspect, center, position, right, up, forward) = camera;
    has_pixels(width, height)?;
    let unknown = |_| PyValueError::new_err(format!("unknown projection {projection:?}"));
    let projection = projection.parse().map_err(unknown)?;
    Ok(Camera { width, height, projection, half_height, pixel_aspect, center, position, right, up, forward })
}

/// Camera, objects, checkers, lights, settings with the depth of light; vertical field of view, names of the objects,
/// exposure, tone curve, alpha.
pub type PyPlainScene<'a> = (
    (PyCamera<'a>, PyObjects<'a>, PyCheckers<'a>, PyLights<'a>, PySettings),
    (Option<f64>, i64, &'a str, Option<f64>, &'a str, bool),
);

/// Return a scene with all that is known of a plainly valid one.
///
/// # Errors
///
/// As for its parts.
pub fn plain_scene(scene: PyPlainScene<'_>) -> PyResult<PlainScene> {
    let ((camera_of, objects_of, checkers_of, lights_of, settings_of), rest) = scene;
    let (fov, max_depth, names, exposure, tone, alpha) = rest;
    let columns = objects(objects_of)?;
    let count = columns.count();
    let object = |number| Object {
        position: columns.position(number),
        color: columns.color(number),
        shape: columns.shape(number),
    };
    let (kind, parameters, color, intensity, carrier) = lights_of;
    let unknown = |UnknownName| PyValueError::new_err(format!("unknown tone curve {tone:?}"));
    Ok(PlainScene {
        world: World {
            camera: camera(camera_of)?,
            objects: (0..count).map(object).collect(),
            checkers: checkers(checkers_of, count)?,
            lights: lights(lights_of, count)?,
            settings: settings(settings_of)?,
        },
        exposure,
        tone: tone.parse().map_err(unknown)?,
        alpha,
        fov,
        max_depth,
        objects: rtcli_reader::Objects {
            kind: columns.kinds.to_vec(),
            position: columns.positions.as_flattened().to_vec(),
            parameters: columns.parameters.to_vec(),
            color: columns.colors.as_flattened().to_vec(),
            names: names.into(),
        },
        lights: rtcli_reader::Lights {
            kind: kind.to_vec(),
            parameters: items(parameters)?.to_vec(),
            color: items(color)?.to_vec(),
            intensity: items(intensity)?.to_vec(),
            carrier: items(carrier)?.to_vec(),
        },
    })
}

/// Return the objects.
///
/// # Errors
///
/// `ValueError` for an unknown kind, columns of different lengths, or more objects than can be numbered.
pub fn objects((kinds, positions, parameters, colors): PyObjects<'_>) -> PyResult<Columns<'_>> {
    let (positions, colors) = (items::<Vector>(positions)?, items::<Vector>(colors)?);
    same_lengths(kinds.len(), &[positions.len(), colors.len()])?;
    if kinds.len() > MOST_OBJECTS {
        return Err(PyValueError::new_err(format!(
            "a scene is limited to {MOST_OBJECTS} objects, got {}",
            kinds.len()
        )));
    }
    let (mut starts, mut start) = (Vec::new(), 0);
    let parameters = items(parameters)?;
    if kinds.iter().any(|&kind| kind != kinds[0]) {
        reserve(&mut starts, kinds.len(), "the objects").map_err(out_of_memory)?;
        for_each_row(ShapeDesc::KINDS, kinds, &parameters, |_, own| {
            starts.push(start);
            start += own.len() as u32;
            Ok(())
        })?;
    } else {
        let kind = kinds.first().map(|&kind| kind_of(ShapeDesc::KINDS, kind)).transpose()?;
        same_lengths(kind.map_or(0, |kind| kind.parameters * kinds.len()), &[parameters.len()])?;
    }
    Ok(Columns { kinds, positions, parameters, starts, colors })
}

fn kind_of(kinds: &[Kind], tag: u8) -> PyResult<&Kind> {
    kinds.get(usize::from(tag)).ok_or_else(|| PyValueError::new_err(format!("unknown kind {tag}")))
}

/// Pass the index of each row and its parameters to `add`.
///
/// # Errors
///
/// `ValueError` for an unknown kind or columns of different lengths, and those of `add`.
pub fn for_each_row<'a>(
    kinds: &[Kind],
    tags: &[u8],
    mut parameters: &'a [f64],
    mut add: impl FnMut(usize, &'a [f64]) -> PyResult<()>,
) -> PyResult<()> {
    for (i, &tag) in tags.iter().enumerate() {
        let count = kind_of(kinds, tag)?.parameters;
        add(i, parameters.split_off(..count).ok_or_else(different_lengths)?)?;
    }
    if parameters.is_empty() { Ok(()) } else { Err(different_lengths()) }
}

/// Return the checkers.
///
/// # Errors
///
/// `ValueError` for columns of different lengths, or an index that is none of the objects.
pub fn checkers((indices, size, color): PyCheckers<'_>, objects: usize) -> PyResult<Vec<CheckerDesc>> {
    let (indices, size, color) = (items::<i64>(indices)?, items::<f64>(size)?, items::<Vector>(color)?);
    same_lengths(indices.len(), &[size.len(), color.len()])?;
    let checker = |((&index, &size), &color): ((&i64, &f64), &Vector)| match usize::try_from(index) {
        Ok(object) if object < objects => Ok(CheckerDesc { object, size, color }),
        _ => Err(PyValueError::new_err(format!("a checker is on object {index}, which does not exist"))),
    };
    indices.iter().zip(&*size).zip(&*color).map(checker).collect()
}

/// Return the lights.
///
/// # Errors
///
/// `ValueError` for an unknown kind, columns of different lengths, or a carrier that is none of the objects.
pub fn lights(columns: PyLights<'_>, objects: usize) -> PyResult<Vec<LightDesc>> {
    let (kinds, parameters, color, intensity, carriers) = columns;
    let (color, intensity) = (items::<Vector>(color)?, items::<f64>(intensity)?);
    let (carriers, parameters) = (items::<i64>(carriers)?, items(parameters)?);
    same_lengths(kinds.len(), &[color.len(), intensity.len(), carriers.len()])?;
    let mut lights = with_capacity(kinds.len(), "the lights").map_err(out_of_memory)?;
    for_each_row(LightSource::KINDS, kinds, &parameters, |i, own| {
        let source = LightSource::new(usize::from(kinds[i]), own);
        let carrier = carrier(carriers[i], objects)?;
        lights.push(LightDesc { source, color: color[i], intensity: intensity[i], carrier });
        Ok(())
    })?;
    Ok(lights)
}

fn carrier(index: i64, objects: usize) -> PyResult<Option<usize>> {
    match usize::try_from(index) {
        Ok(index) if index < objects => Ok(Some(index)),
        Err(_) => Ok(None),
        Ok(_) => Err(PyValueError::new_err(format!("a light is carried by object {index}, which does not exist"))),
    }
}

/// Return the settings.
///
/// # Errors
///
/// `ValueError` for a picture or lights without samples.
pub fn settings(settings: PySettings) -> PyResult<Settings> {
    let (samples, background, ambient, direct_light, shadow_samples, eye_falloff) = settings;
    if samples == 0 || shadow_samples == 0 {
        return Err(PyValueError::new_err("samples and shadow samples must be at least 1"));
    }
    Ok(Settings { samples, background, ambient, direct_light, shadow_samples, eye_falloff })
}

/// Return a window of a picture, whose width and height are given.
///
/// # Errors
///
/// `ValueError` if it is empty or not inside the picture.
pub fn window((x, y, width, height): PyWindow, whole: (u32, u32)) -> PyResult<Window> {
    let inside = |start: u32, length: u32, whole: u32| {
        length > 0 && start.checked_add(length).is_some_and(|end| end <= whole)
    };
    if inside(x, width, whole.0) && inside(y, height, whole.1) {
        Ok(Window { x, y, width, height })
    } else {
        Err(PyValueError::new_err("the window is not inside the picture"))
    }
}

fn same_lengths(rows: usize, columns: &[usize]) -> PyResult<()> {
    if columns.iter().all(|length| *length == rows) { Ok(()) } else { Err(different_lengths()) }
}

fn different_lengths() -> PyErr {
    PyValueError::new_err("columns of different lengths")
}
