//! Developing and metering radiance from any engine.

use std::borrow::Cow;
use std::io;
use std::mem;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};
use rtcli_tracer::develop::{BitDepth, Developer, ToneCurve};
use rtcli_tracer::memory::{Growing, filled, spare};
use rtcli_tracer::meter::MeterReading;
use rtcli_tracer::names::UnknownName;
use rtcli_tracer::png::{Color, Compression, Header, PngWriter};

use crate::columns::{copied, items};
use crate::errors::{io_error, out_of_memory};
use crate::interruptible::bytes_of;

/// Stops, tone curve, bits a channel.
pub type PyDisplay<'a> = (f64, &'a str, u8);

const CHANNELS: usize = 3;

/// The largest side of a picture, pixels.
const LONGEST_SIDE: u32 = 65_535;

/// Return a developer of these settings.
///
/// # Errors
///
/// `ValueError` for an unknown tone curve or number of bits, or an exposure that is no number.
pub fn developer((exposure, tone, bits): PyDisplay<'_>) -> PyResult<Arc<Developer>> {
    if exposure.is_nan() {
        return Err(PyValueError::new_err("the exposure is not a number"));
    }
    let unknown = |UnknownName| PyValueError::new_err(format!("unknown tone curve {tone:?}"));
    let tone = tone.parse::<ToneCurve>().map_err(unknown)?;
    Ok(developer_of(exposure, tone, bit_depth(bits)?))
}

/// Return a developer, the last one if its settings are the same: making its tables takes as long as tracing a small
/// picture, and those of a batch or a data set mostly share them.
pub fn developer_of(exposure: f64, tone: ToneCurve, bits: BitDepth) -> Arc<Developer> {
    type Key = (u64, ToneCurve, BitDepth);
    static LAST: Mutex<Option<(Key, Arc<Developer>)>> = Mutex::new(None);
    let key = (exposure.to_bits(), tone, bits);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    match &*last {
        Some((known, developer)) if *known == key => Arc::clone(developer),
        _ => Arc::clone(&last.insert((key, Arc::new(Developer::new(exposure, tone, bits)))).1),
    }
}

/// Return the depth of channels with a number of bits.
///
/// # Errors
///
/// `ValueError` for another number than 8 or 16.
pub fn bit_depth(bits: u8) -> PyResult<BitDepth> {
    match bits {
        8 => Ok(BitDepth::Eight),
        16 => Ok(BitDepth::Sixteen),
        _ => Err(PyValueError::new_err(format!("bits must be 8 or 16, got {bits}"))),
    }
}

/// Return the compression of a name.
///
/// # Errors
///
/// `ValueError` for another name than `fast` or `small`.
pub fn compression(name: &str) -> PyResult<Compression> {
    let unknown = |UnknownName| PyValueError::new_err(format!("compress must be 'fast' or 'small', got {name:?}"));
    name.parse().map_err(unknown)
}

/// Return the tangent of half an angle in degrees, the same on every machine.
#[pyfunction]
#[pyo3(signature = (degrees, /))]
pub fn half_tangent(degrees: f64) -> f64 {
    rtcli_tracer::half_tangent(degrees)
}

/// Develop radiance, interleaved float32 RGB, to 8 bits a channel, or to 16 with the high byte first; radiance that is
/// multiplied by alpha, float32, to four channels.
#[pyfunction]
#[pyo3(signature = (radiance, transform, alpha=None, /))]
pub fn develop<'py>(
    py: Python<'py>,
    radiance: &[u8],
    transform: PyDisplay<'_>,
    alpha: Option<&[u8]>,
) -> PyResult<Bound<'py, PyByteArray>> {
    let (developer, mut radiance) = (developer(transform)?, pixels(radiance)?);
    let count = radiance.len() / CHANNELS;
    let color = count * developer.bytes_per_pixel();
    let Some(alpha) = alpha.map(items::<f32>).transpose()? else {
        return PyByteArray::new_with(py, color, |developed| {
            py.detach(|| developer.develop(&radiance, developed));
            Ok(())
        });
    };
    if alpha.len() != count {
        return Err(PyValueError::new_err("alpha has not as many pixels as radiance"));
    }
    PyByteArray::new_with(py, color + count * developer.bits().bytes(), |developed| {
        py.detach(|| developer.develop_straight(radiance.to_mut(), &alpha, developed));
        Ok(())
    })
}

/// Return the stops that expose a picture well, and the percentile they follow from.
#[pyfunction]
#[pyo3(signature = (radiance, /))]
pub fn meter(py: Python<'_>, radiance: &[u8]) -> PyResult<(f64, Option<f64>)> {
    let radiance = pixels(radiance)?;
    let metered = py.detach(|| rtcli_tracer::meter::meter(&radiance));
    let MeterReading { stops, percentile } = metered.map_err(out_of_memory)?;
    Ok((stops, percentile))
}

/// Encodes a picture as a PNG, some rows of radiance at a time.
#[pyclass(module = "rtcli.tracer._native")]
pub struct PngEncoder {
    developer: Arc<Developer>,
    /// None once the picture is finished.
    writer: Option<PngWriter<Growing>>,
    width: usize,
    rows_left: usize,
}

#[pymethods]
impl PngEncoder {
    #[new]
    #[pyo3(signature = (width, height, transform, texts, compress="fast", /))]
    fn new(
        width: u32,
        height: u32,
        transform: PyDisplay<'_>,
        texts: Vec<(String, String)>,
        compress: &str,
    ) -> PyResult<Self> {
        has_pixels(width, height)?;
        let compression = compression(compress)?;
        let developer = developer(transform)?;
        let header = Header { width, height, color: Color::Srgb, bits: developer.bits(), texts: &texts };
        Ok(PngEncoder {
            writer: Some(PngWriter::new(Growing::default(), header, compression).map_err(io_error)?),
            developer,
            width: width as usize,
            rows_left: height as usize,
        })
    }

    /// Develop and encode the next rows; return the next bytes of the file.
    #[pyo3(signature = (radiance, /))]
    fn push<'py>(&mut self, py: Python<'py>, radiance: &[u8]) -> PyResult<Bound<'py, PyBytes>> {
        let radiance = pixels(radiance)?;
        let row = self.width * CHANNELS;
        let rows = radiance.len() / row;
        if !radiance.len().is_multiple_of(row) || rows > self.rows_left {
            let left = self.rows_left;
            let message = format!(
                "{} pixels are not at most {left} whole rows of {}",
                radiance.len() / CHANNELS,
                self.width
            );
            return Err(PyValueError::new_err(message));
        }
        self.rows_left -= rows;
        bytes_of(py, &py.detach(|| self.encode(&radiance)).map_err(io_error)?)
    }

    /// End the picture after its last row; return the rest of the file.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        if self.rows_left > 0 {
            let message = format!("{} rows are missing", self.rows_left);
            return Err(PyValueError::new_err(message));
        }
        let rest = self.writer.take().map(PngWriter::finish).transpose().map_err(io_error)?;
        bytes_of(py, &rest.unwrap_or_default().0)
    }
}

impl PngEncoder {
    fn encode(&mut self, radiance: &[f32]) -> io::Result<Vec<u8>> {
        spare()?;
        let bytes = radiance.len() / CHANNELS * self.developer.bytes_per_pixel();
        let mut rows = filled(bytes, 0, "rows of the picture")?;
        self.developer.develop(radiance, &mut rows);
        let Some(writer) = &mut self.writer else {
            return Ok(Vec::new());
        };
        writer.write_rows(&rows)?;
        Ok(mem::take(writer.sink()).0)
    }
}

/// Check the size of a picture.
///
/// # Errors
///
/// `ValueError` if a side is 0 or longer than `LONGEST_SIDE`.
pub fn has_pixels(width: u32, height: u32) -> PyResult<()> {
    if width == 0 || height == 0 {
        return Err(PyValueError::new_err("a picture needs at least one pixel"));
    }
    if width.max(height) > LONGEST_SIDE {
        let message = format!("a picture is limited to {LONGEST_SIDE} pixels per side, got {width}x{height}");
        return Err(PyValueError::new_err(message));
    }
    Ok(())
}

/// Return bytes as interleaved RGB, copied only if they are not aligned.
fn pixels(bytes: &[u8]) -> PyResult<Cow<'_, [f32]>> {
    if !bytes.len().is_multiple_of(CHANNELS * size_of::<f32>()) {
        let message = format!("{} bytes are not a whole number of float32 RGB pixels", bytes.len());
        return Err(PyValueError::new_err(message));
    }
    match bytemuck::try_cast_slice(bytes) {
        Ok(pixels) => Ok(Cow::Borrowed(pixels)),
        Err(_) => Ok(Cow::Owned(copied(bytes, "the radiance")?)),
    }
}
