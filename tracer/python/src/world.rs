//! What Python packs, as the tracer's `World`: see `rtcli/tracer/world.py` for the meaning of each number.

use crate::display::{copied, has_pixels};
use crate::errors::out_of_memory;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtcli_tracer::memory::with_capacity;
use rtcli_tracer::world::{Camera, LightDesc, Object, Settings, ShapeDesc, Vector, Window};

/// Objects whose faces can be numbered in 32 bits.
const MOST_OBJECTS: usize = 1 << 28;

/// Width, height, fov, position, right, up, forward.
pub type PyCamera = (u32, u32, f64, Vector, Vector, Vector, Vector);

/// Kind (u8), position, extent, rotation, color (f64), in native byte order.
pub type PyObjects<'a> = (&'a [u8], &'a [u8], &'a [u8], &'a [u8], &'a [u8]);

/// Position, color, intensity (f64), body (i64), in native byte order.
pub type PyLights<'a> = (&'a [u8], &'a [u8], &'a [u8], &'a [u8]);

/// Samples, background, whether objects are lit, whether light weakens on its way to the eye.
pub type PySettings = (u32, Vector, bool, bool);

/// Left, top, width, height.
pub type PyWindow = (u32, u32, u32, u32);

/// The whole picture, pixels.
#[derive(Clone, Copy)]
pub struct Size {
    width: u32,
    height: u32,
}

impl From<&Camera> for Size {
    fn from(camera: &Camera) -> Size {
        Size {
            width: camera.width,
            height: camera.height,
        }
    }
}

/// The kinds of `rtcli/tracer/world.py`.
const SPHERE: u8 = 0;
const PLANE: u8 = 1;
const BOX: u8 = 2;

/// Returns the camera.
///
/// # Errors
///
/// `ValueError` for a picture without pixels.
pub fn camera(camera: PyCamera) -> PyResult<Camera> {
    let (width, height, fov, position, right, up, forward) = camera;
    has_pixels(width, height)?;
    Ok(Camera {
        width,
        height,
        fov,
        position,
        right,
        up,
        forward,
    })
}

/// Returns the objects.
///
/// # Errors
///
/// `ValueError` for an unknown kind, columns of different lengths, or more objects than can be numbered.
pub fn objects(columns: PyObjects<'_>) -> PyResult<Vec<Object>> {
    let (kinds, position, extent, rotation, color) = columns;
    let (position, extent) = (vectors(position)?, vectors(extent)?);
    let (rotation, color) = (numbers(rotation)?, vectors(color)?);
    let lengths = [position.len(), extent.len(), rotation.len(), color.len()];
    same_lengths(kinds.len(), &lengths)?;
    if kinds.len() > MOST_OBJECTS {
        return Err(PyValueError::new_err(format!(
            "there may be {MOST_OBJECTS} objects, not {}",
            kinds.len()
        )));
    }
    let mut objects = with_capacity(kinds.len(), "the objects").map_err(out_of_memory)?;
    for i in 0..kinds.len() {
        objects.push(Object {
            position: position[i],
            color: color[i],
            shape: shape(kinds[i], extent[i], rotation[i])?,
        });
    }
    Ok(objects)
}

fn shape(kind: u8, extent: Vector, rotation: f64) -> PyResult<ShapeDesc> {
    match kind {
        SPHERE => Ok(ShapeDesc::Sphere { radius: extent[0] }),
        PLANE => Ok(ShapeDesc::Plane { normal: extent }),
        BOX => Ok(ShapeDesc::Box { size: extent, rotation }),
        _ => Err(PyValueError::new_err(format!("unknown kind of shape {kind}"))),
    }
}

/// Returns the lights.
///
/// # Errors
///
/// `ValueError` for columns of different lengths, or a body that is none of the objects.
pub fn lights(columns: PyLights<'_>, objects: usize) -> PyResult<Vec<LightDesc>> {
    let (position, color, intensity, bodies) = columns;
    let (position, color) = (vectors(position)?, vectors(color)?);
    let (intensity, bodies) = (numbers(intensity)?, indices(bodies)?);
    same_lengths(bodies.len(), &[position.len(), color.len(), intensity.len()])?;
    let mut lights = with_capacity(bodies.len(), "the lights").map_err(out_of_memory)?;
    for i in 0..bodies.len() {
        lights.push(LightDesc {
            position: position[i],
            color: color[i],
            intensity: intensity[i],
            body: body(bodies[i], objects)?,
        });
    }
    Ok(lights)
}

fn body(index: i64, objects: usize) -> PyResult<Option<usize>> {
    match usize::try_from(index) {
        Ok(index) if index < objects => Ok(Some(index)),
        Err(_) => Ok(None),
        Ok(_) => Err(PyValueError::new_err(format!(
            "there is no object {index} to carry a light"
        ))),
    }
}

/// Returns the settings.
///
/// # Errors
///
/// `ValueError` for a picture without samples.
pub fn settings((samples, background, lit, eye_falloff): PySettings) -> PyResult<Settings> {
    if samples == 0 {
        return Err(PyValueError::new_err("samples must be at least 1"));
    }
    Ok(Settings {
        samples,
        background,
        lit,
        eye_falloff,
    })
}

/// Returns a window of a picture.
///
/// # Errors
///
/// `ValueError` if it is empty or reaches out of the picture.
pub fn window((x, y, width, height): PyWindow, whole: Size) -> PyResult<Window> {
    let inside = |start: u32, length: u32, whole: u32| {
        length > 0 && start.checked_add(length).is_some_and(|end| end <= whole)
    };
    if inside(x, width, whole.width) && inside(y, height, whole.height) {
        Ok(Window { x, y, width, height })
    } else {
        Err(PyValueError::new_err("the window is not inside the picture"))
    }
}

fn vectors(bytes: &[u8]) -> PyResult<Vec<Vector>> {
    items(bytes)
}

fn numbers(bytes: &[u8]) -> PyResult<Vec<f64>> {
    items(bytes)
}

fn indices(bytes: &[u8]) -> PyResult<Vec<i64>> {
    items(bytes)
}

fn items<T: bytemuck::AnyBitPattern>(bytes: &[u8]) -> PyResult<Vec<T>> {
    if !bytes.len().is_multiple_of(size_of::<T>()) {
        let message = format!("{} bytes are no whole number of items", bytes.len());
        return Err(PyValueError::new_err(message));
    }
    copied(bytes, "the scene")
}

fn same_lengths(rows: usize, columns: &[usize]) -> PyResult<()> {
    if columns.iter().all(|length| *length == rows) {
        Ok(())
    } else {
        Err(PyValueError::new_err("columns of different lengths"))
    }
}
