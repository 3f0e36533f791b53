//! PNG files of values that are already developed, or are no colors.

use std::borrow::Cow;
use std::io;

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rtcli_tracer::develop::BitDepth;
use rtcli_tracer::memory::{OutOfMemory, spare, with_capacity};
use rtcli_tracer::png::{self, Color, Header};
use rtcli_tracer::rle::{self, PixelBox};

use crate::arrays::pass;
use crate::columns::items;
use crate::display::{bit_depth, compression, has_pixels};
use crate::errors::out_of_memory;
use crate::interruptible::bytes_of;

/// The largest picture to decode: 65,535 x 16,384 pixels of 16-bit RGB.
const MOST_BYTES: usize = 6 << 30;

/// Encode 8-bit values, or 16-bit values in native byte order, as a PNG: 1 or 3 channels that are no colors, or sRGB
/// with alpha in 4.
#[pyfunction]
#[pyo3(signature = (pixels, size, channels, bits, texts, compress="fast", /))]
pub fn encode_png<'py>(
    py: Python<'py>,
    pixels: &[u8],
    size: (u32, u32),
    channels: u8,
    bits: u8,
    texts: Vec<(String, String)>,
    compress: &str,
) -> PyResult<Bound<'py, PyBytes>> {
    let (width, height) = size;
    has_pixels(width, height)?;
    let header = Header { width, height, color: color(channels)?, bits: bit_depth(bits)?, texts: &texts };
    let compression = compression(compress)?;
    let file = py.detach(|| {
        spare()?;
        png::encode(header, &swapped(pixels, header.bits)?, compression)
    });
    bytes_of(py, &file.map_err(|error| of_a_picture(error.kind(), &error))?)
}

/// Decode a PNG; return width, height, channels, bits, and the values, 16 bits in native byte order.
#[pyfunction]
#[pyo3(signature = (file, /))]
pub fn decode_png<'py>(py: Python<'py>, file: &[u8]) -> PyResult<(u32, u32, usize, u8, Bound<'py, PyBytes>)> {
    spare().map_err(out_of_memory)?;
    let decoded = py.detach(|| png::decode(file, MOST_BYTES));
    let decoded = decoded.map_err(|error| match &error {
        png::DecodingError::IoError(io) => of_a_picture(io.kind(), io),
        _ => PyValueError::new_err(error.to_string()),
    })?;
    let pixels = bytes_of(py, &swapped(&decoded.pixels, decoded.bits).map_err(out_of_memory)?)?;
    Ok((decoded.width, decoded.height, decoded.channels, decoded.bits as u8, pixels))
}

/// `MemoryError` if memory ran out, else `ValueError`: the picture is wrong.
fn of_a_picture(kind: io::ErrorKind, error: &dyn std::error::Error) -> PyErr {
    match kind {
        io::ErrorKind::OutOfMemory => PyMemoryError::new_err("not enough memory for the picture"),
        _ => PyValueError::new_err(error.to_string()),
    }
}

fn color(channels: u8) -> PyResult<Color> {
    match channels {
        1 => Ok(Color::Grey),
        3 => Ok(Color::Triple),
        4 => Ok(Color::SrgbAlpha),
        _ => Err(PyValueError::new_err(format!("channels must be 1, 3 or 4, got {channels}"))),
    }
}

/// From native byte order to the high byte first, or back.
fn swapped(pixels: &[u8], bits: BitDepth) -> Result<Cow<'_, [u8]>, OutOfMemory> {
    if bits == BitDepth::Eight || cfg!(target_endian = "big") {
        return Ok(Cow::Borrowed(pixels));
    }
    let mut swapped = with_capacity(pixels.len(), "the picture")?;
    swapped.extend(pixels.as_chunks().0.iter().flat_map(|&[a, b]| [b, a]));
    Ok(swapped.into())
}

/// Return a pass of floats as levels with a number of bits, 16 in native byte order, and how to get its values, in JSON.
#[pyfunction]
#[pyo3(signature = (name, values, scale, /))]
pub fn pass_picture<'py>(
    py: Python<'py>,
    name: &str,
    values: &[u8],
    scale: Option<f64>,
) -> PyResult<(Bound<'py, PyBytes>, u8, String)> {
    let (pass, values) = (pass(name)?, items(values)?);
    spare().map_err(out_of_memory)?;
    let picture = py.detach(|| rtcli_tracer::pass_picture::pass_picture(pass, &values, scale));
    let picture = picture.map_err(out_of_memory)?;
    let picture = picture.ok_or_else(|| PyValueError::new_err(format!("{name} has no levels")))?;
    let levels = swapped(&picture.levels, picture.bits).map_err(out_of_memory)?;
    Ok((bytes_of(py, &levels)?, picture.bits as u8, rtcli_plain::decode_json(&picture.decode)))
}

/// Return the number of pixels of the objects 1 to `count`, and the box around them.
#[pyfunction]
#[pyo3(signature = (ids, count, /))]
pub fn id_boxes(py: Python<'_>, ids: PyReadonlyArray2<'_, u32>, count: usize) -> PyResult<Vec<(usize, PixelBox)>> {
    let (ids, width) = rows_of_ids(&ids)?;
    Ok(py.detach(|| rle::boxes(ids, width, count)))
}

/// Return ids row by row, and the length of a row.
fn rows_of_ids<'a>(ids: &'a PyReadonlyArray2<'_, u32>) -> PyResult<(&'a [u32], usize)> {
    match ids.shape() {
        &[_, width] if width > 0 => Ok((ids.as_slice()?, width)),
        _ => Err(PyValueError::new_err("the ids have no pixels")),
    }
}
