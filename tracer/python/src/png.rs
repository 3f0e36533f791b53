//! PNG files of numbers that are developed already, or are no color at all.

use std::borrow::Cow;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rtcli_tracer::develop::Bits;
use rtcli_tracer::png::{self, Color, Header, PngWriter};

use crate::look::{depth, has_pixels};

/// The largest picture that is read: 65,535 x 16,384 pixels of RGB in 16 bits.
const MOST_BYTES: usize = 6 << 30;

/// Encodes numbers of 8 bits, or of 16 in native byte order, as a PNG.
#[pyfunction]
#[pyo3(signature = (pixels, size, channels, bits, texts, /))]
pub fn encode_png<'py>(
    py: Python<'py>,
    pixels: &[u8],
    size: (u32, u32),
    channels: u8,
    bits: u8,
    texts: Vec<(String, String)>,
) -> PyResult<Bound<'py, PyBytes>> {
    let (width, height) = size;
    has_pixels(width, height)?;
    let header = Header {
        width,
        height,
        color: color(channels)?,
        bits: depth(bits)?,
        texts: &texts,
    };
    let file = py.detach(|| {
        let mut file = Vec::new();
        let mut writer = PngWriter::new(&mut file, header)?;
        writer.write_rows(&swapped(pixels, header.bits))?;
        writer.finish()?;
        Ok::<_, std::io::Error>(file)
    });
    let file = file.map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(PyBytes::new(py, &file))
}

/// Decodes a PNG; returns width, height, channels, bits, and the numbers of 8 bits, or of 16 in native byte order.
#[pyfunction]
#[pyo3(signature = (file, /))]
pub fn decode_png<'py>(py: Python<'py>, file: &[u8]) -> PyResult<(u32, u32, usize, u8, Bound<'py, PyBytes>)> {
    let decoded = py.detach(|| png::decode(file, MOST_BYTES));
    let decoded = decoded.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let bits = depth(decoded.bits)?;
    let pixels = PyBytes::new(py, &swapped(&decoded.pixels, bits));
    Ok((decoded.width, decoded.height, decoded.channels, decoded.bits, pixels))
}

fn color(channels: u8) -> PyResult<Color> {
    match channels {
        1 => Ok(Color::Grey),
        3 => Ok(Color::Triple),
        _ => Err(PyValueError::new_err(format!(
            "channels must be 1 or 3, got {channels}"
        ))),
    }
}

/// From native byte order to the high byte first, or back.
fn swapped(pixels: &[u8], bits: Bits) -> Cow<'_, [u8]> {
    if bits == Bits::Eight || cfg!(target_endian = "big") {
        return Cow::Borrowed(pixels);
    }
    pixels
        .as_chunks()
        .0
        .iter()
        .flat_map(|&[a, b]| [b, a])
        .collect::<Vec<u8>>()
        .into()
}
