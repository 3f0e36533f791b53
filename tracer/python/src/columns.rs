//! Bytes of Python as numbers.

use std::borrow::Cow;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rtcli_tracer::memory::collect;

use crate::errors::out_of_memory;

/// Return the items of a column; they are copied only if they are not aligned.
///
/// # Errors
///
/// `ValueError` for bytes that are not a whole number of items, `MemoryError` if memory runs out.
pub fn items<T: bytemuck::AnyBitPattern>(bytes: &[u8]) -> PyResult<Cow<'_, [T]>> {
    if !bytes.len().is_multiple_of(size_of::<T>()) {
        let message = format!("{} bytes are not a whole number of items", bytes.len());
        return Err(PyValueError::new_err(message));
    }
    match bytemuck::try_cast_slice(bytes) {
        Ok(items) => Ok(items.into()),
        Err(_) => Ok(copied(bytes, "the scene")?.into()),
    }
}

/// Copy bytes of any alignment to a list of items.
///
/// # Errors
///
/// `MemoryError` if memory runs out.
pub fn copied<T: bytemuck::AnyBitPattern>(bytes: &[u8], what: &'static str) -> PyResult<Vec<T>> {
    let items = bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned);
    collect(items, what).map_err(out_of_memory)
}
