//! Plainly valid scenes straight to the files of their pictures.

use std::io;
use std::path::{Path, PathBuf};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use rtcli_plain::{FileError, Picture, PictureFile};
use rtcli_tracer::Stopped;

use crate::display::{bit_depth, compression, developer_of};
use crate::errors::{io_error, stopped};
use crate::interruptible::Listener;
use crate::scene_file::{PyEdit, borrowed, format_of};
use crate::tracer::level;

/// Fingerprint, SHA-256, bytes, width and height, and the seconds of each stage.
type PyPictureFile<'py> = (String, String, u64, (u32, u32), Bound<'py, PyDict>);

/// Render a scene file with some changes to a PNG with one thread; return None if it is not plainly valid.
#[pyfunction]
#[pyo3(signature = (scene, format, edits, bits, compress, paths, /))]
pub fn write_picture<'py>(
    py: Python<'py>,
    scene: &[u8],
    format: &str,
    edits: Vec<PyEdit>,
    bits: u8,
    compress: &str,
    paths: (PathBuf, PathBuf),
) -> PyResult<Option<PyPictureFile<'py>>> {
    let (target, temporary) = &paths;
    let picture = Picture {
        scene,
        format: format_of(format)?,
        edits: &borrowed(&edits),
        bits: bit_depth(bits)?,
        compression: compression(compress)?,
        target,
        temporary,
        software: concat!("rtcli ", env!("CARGO_PKG_VERSION")),
    };
    let level = level()?;
    let made = Listener::default().run_interruptibly(py, 1, |monitor, _| {
        // Errors with the file are to name it.
        Ok::<_, Stopped>(picture.write(level, developer_of, monitor))
    })?;
    match made {
        Ok(None) => Ok(None),
        Ok(Some(PictureFile { fingerprint, sha256, bytes, size, seconds })) => {
            Ok(Some((fingerprint, sha256, bytes, size, seconds.into_py_dict(py)?)))
        }
        Err(FileError::Stopped(error)) => Err(stopped(error)),
        Err(FileError::Io(error)) => Err(named(py, error, &paths.0)),
    }
}

/// Return an error with a file that names the file.
fn named(py: Python<'_>, error: io::Error, path: &Path) -> PyErr {
    let Some(number) = error.raw_os_error() else { return io_error(error) };
    let text = py.import("os").and_then(|os| os.call_method1("strerror", (number,))).map(Bound::unbind);
    text.map_or_else(|error| error, |text| PyOSError::new_err((number, text, path.to_path_buf())))
}
