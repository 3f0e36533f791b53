//! Where the values of a scene file stand.

use std::collections::HashMap;
use std::sync::Mutex;

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rtcli_reader::{Span, Spans, text_of};

use crate::scene_file::{PyStep, format_of};

/// The bytes of a block of a text whose characters are counted.
const BLOCK: usize = 1024;

/// The places of all values and keys in the text of a plainly valid scene file, in characters.
#[pyclass(frozen, module = "rtcli.tracer._native")]
pub struct FileSpans {
    file: Py<PyBytes>,
    spans: Spans,
    /// The bytes before the text.
    before: usize,
    /// The characters before each block, unless each is one byte.
    characters: Option<Vec<u32>>,
    /// The values in lists that were asked for.
    items: Mutex<HashMap<usize, Vec<u32>>>,
}

#[pymethods]
impl FileSpans {
    /// Reads the spans of a file; returns None if it is not plainly valid.
    #[staticmethod]
    #[pyo3(signature = (file, format, /))]
    fn of(py: Python<'_>, file: Py<PyBytes>, format: &str) -> PyResult<Option<Self>> {
        let format = format_of(format)?;
        let bytes = file.as_bytes(py);
        let Some((spans, characters)) = py.detach(|| {
            let spans = Spans::of(bytes, format)?;
            Some((spans, characters_before_blocks(text_of(bytes))))
        }) else {
            return Ok(None);
        };
        let before = bytes.len() - text_of(bytes).len();
        Ok(Some(FileSpans { file, spans, before, characters, items: Mutex::default() }))
    }

    /// Returns the start and end of a value, by its index, and whether it is a list or mapping.
    #[pyo3(signature = (index, /))]
    fn value(&self, py: Python<'_>, index: usize) -> (usize, usize, bool) {
        let (start, end) = self.in_characters(py, self.spans.value(index));
        (start, end, self.spans.is_container(index))
    }

    /// Returns the start and end of the key of a value, if it has one.
    #[pyo3(signature = (index, /))]
    fn key(&self, py: Python<'_>, index: usize) -> Option<(usize, usize)> {
        self.spans.key(index).map(|span| self.in_characters(py, span))
    }

    /// Returns the index of a value in a list or mapping.
    #[pyo3(signature = (index, step, /))]
    fn child(&self, py: Python<'_>, index: usize, step: PyStep) -> Option<usize> {
        match step {
            PyStep::Key(name) => self.spans.children(index).find(|&child| self.name(py, child) == Some(&name)),
            PyStep::Index(at) => {
                let mut items = self.items.lock().ok()?;
                let children = items
                    .entry(index)
                    .or_insert_with(|| self.spans.children(index).map(|child| child as u32).collect());
                let child = *children.get(at)? as usize;
                self.spans.key(child).is_none().then_some(child)
            }
        }
    }

    /// Returns the steps into a list or mapping.
    #[pyo3(signature = (index, /))]
    fn steps(&self, py: Python<'_>, index: usize) -> Vec<PyStep> {
        let step = |(at, child)| self.name(py, child).map_or(PyStep::Index(at), |name| PyStep::Key(name.into()));
        self.spans.children(index).enumerate().map(step).collect()
    }
}

impl FileSpans {
    fn text<'py>(&'py self, py: Python<'py>) -> &'py [u8] {
        &self.file.as_bytes(py)[self.before..]
    }

    /// Returns the key of a value without its quotes.
    fn name<'py>(&'py self, py: Python<'py>, index: usize) -> Option<&'py str> {
        let Span { start, end } = self.spans.key(index)?;
        let key = str::from_utf8(&self.text(py)[start as usize..end as usize]).ok()?;
        Some(key.trim_matches(['"', '\'']))
    }

    fn in_characters(&self, py: Python<'_>, Span { start, end }: Span) -> (usize, usize) {
        let count = |at: u32| {
            let at = at as usize;
            let Some(before) = &self.characters else { return at };
            let block = at / BLOCK;
            before[block] as usize + characters(&self.text(py)[block * BLOCK..at])
        };
        (count(start), count(end))
    }
}

/// Returns the number of characters that start in a part of a text.
fn characters(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte & 0xc0 != 0x80).count()
}

fn characters_before_blocks(text: &[u8]) -> Option<Vec<u32>> {
    if text.is_ascii() {
        return None;
    }
    let before = text.chunks(BLOCK).scan(0, |sum, block| {
        let before = *sum;
        *sum += characters(block) as u32;
        Some(before)
    });
    // A value may end where the last block does.
    let all = characters(text) as u32;
    Some(before.chain([all]).collect())
}
