//! Work in a thread pool while the calling thread listens to Python.

use std::hint::black_box;
use std::num::NonZero;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use std::{mem, process};

use pyo3::exceptions::{PyMemoryError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::{ThreadPool, ThreadPoolBuilder};
use rtcli_tracer::{Monitor, Stopped, WorkBudget};

use crate::byte_channel::ByteChannel;
use crate::errors::stopped;

/// The interval at which the calling thread checks for signals.
const PAUSE: Duration = Duration::from_millis(20);

/// The memory of a thread with its stack, and the memory to leave free.
const THREAD_BYTES: usize = 3 << 20;
const SPARE_BYTES: usize = 4 << 20;

/// The stack that Python's calls may use in the calling thread.
const STACK_BYTES: usize = 256 << 10;

/// Reports the progress and the bytes of a rendering to Python.
pub struct Listener<'a, 'py> {
    py: Python<'py>,
    /// Called with (pixels done, pixels in all).
    progress: Option<&'a Bound<'py, PyAny>>,
    /// Called with bytes.
    write: Option<&'a Bound<'py, PyAny>>,
    pixels: u64,
    /// None for unlimited work.
    budget: Option<Arc<WorkBudget>>,
}

impl<'a, 'py> Listener<'a, 'py> {
    /// Return a listener without a budget.
    pub fn new(
        py: Python<'py>,
        pixels: u64,
        progress: Option<&'a Bound<'py, PyAny>>,
        write: Option<&'a Bound<'py, PyAny>>,
    ) -> Self {
        Listener { py, progress, write, pixels, budget: None }
    }

    /// Set a budget: the work ends as soon as it exceeds it.
    pub fn within(self, budget: Option<Arc<WorkBudget>>) -> Self {
        Listener { budget, ..self }
    }

    /// Run work in a pool of threads and return its result.
    ///
    /// The calling thread passes signals, progress and bytes to Python. An exception raised there ends the work.
    pub fn run_interruptibly<T: Send, E: Into<Stopped> + Send>(
        &self,
        threads: usize,
        work: impl FnOnce(&Monitor, &ByteChannel) -> Result<T, E> + Send,
    ) -> PyResult<T> {
        let monitor = self.budget.clone().map_or_else(Monitor::default, Monitor::within);
        let channel = ByteChannel::default();
        let pool = pool(self.py, threads)?;
        let mut result = None;
        let listened = pool.in_place_scope(|scope| {
            scope.spawn(|_| {
                // Dropped even if the work panics, which the scope propagates.
                let _end = EndOnDrop(&channel);
                result = Some(work(&monitor, &channel));
            });
            self.listen(&monitor, &channel).inspect_err(|_| {
                monitor.cancel();
                self.py.detach(|| channel.close());
            })
        });
        keep(pool);
        listened?;
        let result = result.ok_or_else(|| PyRuntimeError::new_err("the worker thread ended without a result"))?;
        result.map_err(|error| stopped(error.into()))
    }

    fn listen(&self, monitor: &Monitor, channel: &ByteChannel) -> PyResult<()> {
        let mut reported = 0;
        loop {
            let (bytes, ended) = self.py.detach(|| channel.wait(PAUSE));
            self.py.check_signals()?;
            if let (Some(write), false) = (self.write, bytes.is_empty()) {
                write.call1((bytes_of(self.py, &bytes)?,))?;
            }
            let done = monitor.done();
            if let (Some(progress), true) = (self.progress, done > reported) {
                progress.call1((done.min(self.pixels), self.pixels))?;
                reported = done;
            }
            if ended {
                return Ok(());
            }
        }
    }
}

struct EndOnDrop<'a>(&'a ByteChannel);

impl Drop for EndOnDrop<'_> {
    fn drop(&mut self) {
        self.0.end();
    }
}

/// Copy bytes to Python.
///
/// # Errors
///
/// `MemoryError` if no memory holds them, where `PyBytes::new` would panic.
pub fn bytes_of<'py>(py: Python<'py>, bytes: &[u8]) -> PyResult<Bound<'py, PyBytes>> {
    PyBytes::new_with(py, bytes.len(), |copy| {
        copy.copy_from_slice(bytes);
        Ok(())
    })
}

/// The pool that was used last, and the process that started its threads: a fork of it has none of them.
static IDLE: Mutex<Option<(u32, ThreadPool)>> = Mutex::new(None);

/// Return a pool in the sole use of the caller: the idle one if it has as many threads, since starting some takes
/// as long as tracing a small picture, or else a new one.
fn pool(py: Python<'_>, threads: usize) -> PyResult<ThreadPool> {
    if threads < 1 {
        return Err(PyValueError::new_err("threads must be at least 1"));
    }
    // More threads would only compete, and tens of thousands cannot be started.
    let most = 4 * std::thread::available_parallelism().map_or(1, NonZero::get);
    let threads = threads.min(most);
    match IDLE.try_lock().ok().and_then(|mut idle| idle.take()) {
        Some((process, pool)) if process != process::id() => mem::forget(pool),
        Some((_, pool)) if pool.current_num_threads() == threads => return Ok(pool),
        _ => (),
    }
    room_for_threads(py, threads)?;
    let built = ThreadPoolBuilder::new().num_threads(threads).build();
    let failed = |error| PyOSError::new_err(format!("cannot start {threads} threads: {error}"));
    let pool = built.map_err(failed)?;
    // All threads start, and allocate their own memory, before the work allocates large amounts.
    py.detach(|| pool.broadcast(|_| ()));
    Ok(pool)
}

/// Keep a pool for the next work, in place of another.
fn keep(pool: ThreadPool) {
    if let Ok(mut idle) = IDLE.try_lock() {
        *idle = Some((process::id(), pool));
    }
}

/// Check that there is room for threads: a thread that cannot allocate its signal stack ends the process.
/// Python's `mmap` needs new pages, as they do; an allocator might reuse memory.
fn room_for_threads(py: Python<'_>, threads: usize) -> PyResult<()> {
    grow_stack();
    let pages = py.import("mmap")?.call_method1("mmap", (-1, SPARE_BYTES + threads * THREAD_BYTES));
    let pages = pages.map_err(|_| PyMemoryError::new_err("not enough memory for threads"))?;
    pages.call_method0("close").map(drop)
}

/// Grow the calling thread's stack to its final size: the system ends a process whose stack cannot grow.
#[inline(never)]
fn grow_stack() {
    black_box([1_u8; STACK_BYTES]);
}
