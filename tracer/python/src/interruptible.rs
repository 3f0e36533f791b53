//! Work that Python can interrupt: in the calling thread, or in a pool while the calling thread listens.

use std::hint::black_box;
use std::io::{self, Write};
use std::num::NonZero;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, ThreadId};
use std::time::Duration;
use std::{mem, process};

use pyo3::exceptions::{PyMemoryError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::{ThreadPool, ThreadPoolBuilder};
use rtcli_tracer::memory::reserve;
use rtcli_tracer::{Monitor, Stopped, WorkBudget};

use crate::byte_channel::ByteChannel;
use crate::errors::stopped;

/// The interval at which a listening thread checks for signals; a working one does so as often (`Monitor::polling`).
const PAUSE: Duration = Duration::from_millis(20);

/// The memory of a thread with its stack, and the memory to leave free.
const THREAD_BYTES: usize = 3 << 20;
const SPARE_BYTES: usize = 4 << 20;

/// The stack that Python's calls may use in a listening thread, and that a working one needs beside.
const STACK_BYTES: usize = 256 << 10;
const WORKING_STACK_BYTES: usize = 1 << 20;

/// Reports the progress and the bytes of a rendering to Python.
#[derive(Default)]
pub struct Listener {
    /// Called with (pixels done, pixels in all).
    progress: Option<Py<PyAny>>,
    /// Called with bytes.
    write: Option<Py<PyAny>>,
    pixels: u64,
    /// The pixels done that were reported last.
    reported: AtomicU64,
    /// None for unlimited work.
    budget: Option<Arc<WorkBudget>>,
}

impl Listener {
    /// Return a listener without a budget.
    pub fn new(pixels: u64, progress: Option<Bound<'_, PyAny>>, write: Option<Bound<'_, PyAny>>) -> Self {
        let [progress, write] = [progress, write].map(|function| function.map(Bound::unbind));
        Listener { progress, write, pixels, ..Listener::default() }
    }

    /// Set a budget: the work ends as soon as it exceeds it.
    pub fn within(self, budget: Option<Arc<WorkBudget>>) -> Self {
        Listener { budget, ..self }
    }

    /// Run work with a number of threads and return its result.
    ///
    /// The calling thread passes signals, progress and bytes to Python. An exception raised there ends the work.
    pub fn run_interruptibly<T: Send, E: Into<Stopped> + Send>(
        self,
        py: Python<'_>,
        threads: usize,
        work: impl FnOnce(&Monitor, &mut (dyn Write + Send)) -> Result<T, E> + Send,
    ) -> PyResult<T> {
        let monitor = self.budget.clone().map_or_else(Monitor::default, Monitor::within);
        if threads == 1 && works_itself()? {
            self.work(py, monitor, work)
        } else {
            self.listen(py, threads, &monitor, work)
        }
    }

    /// Run work in the calling thread.
    fn work<T: Send, E: Into<Stopped> + Send>(
        self,
        py: Python<'_>,
        monitor: Monitor,
        work: impl FnOnce(&Monitor, &mut (dyn Write + Send)) -> Result<T, E> + Send,
    ) -> PyResult<T> {
        let outbox = Arc::new(Outbox { listener: self, bytes: Mutex::default(), error: Mutex::default() });
        let mut sink = OutboxSink(Arc::clone(&outbox));
        let monitor = monitor.polling({
            let outbox = Arc::clone(&outbox);
            move |done| outbox.empty(done)
        });
        let result = py.detach(|| {
            let result = work(&monitor, &mut sink);
            outbox.empty(monitor.done());
            result
        });
        match lock(&outbox.error).take() {
            Some(error) => Err(error),
            None => result.map_err(|error| stopped(error.into())),
        }
    }

    /// Run work in a pool of threads.
    fn listen<T: Send, E: Into<Stopped> + Send>(
        &self,
        py: Python<'_>,
        threads: usize,
        monitor: &Monitor,
        work: impl FnOnce(&Monitor, &mut (dyn Write + Send)) -> Result<T, E> + Send,
    ) -> PyResult<T> {
        let channel = ByteChannel::default();
        let pool = pool(py, threads)?;
        let mut result = None;
        let listened = pool.in_place_scope(|scope| {
            scope.spawn(|_| {
                // Dropped even if the work panics, which the scope propagates.
                let _end = EndOnDrop(&channel);
                result = Some(work(monitor, &mut &channel));
            });
            self.pass_all(py, monitor, &channel).inspect_err(|_| {
                monitor.cancel();
                py.detach(|| channel.close());
            })
        });
        keep(pool);
        listened?;
        let result = result.ok_or_else(|| PyRuntimeError::new_err("the worker thread ended without a result"))?;
        result.map_err(|error| stopped(error.into()))
    }

    /// Pass what a pool reports to Python until its work ends.
    fn pass_all(&self, py: Python<'_>, monitor: &Monitor, channel: &ByteChannel) -> PyResult<()> {
        loop {
            let (bytes, ended) = py.detach(|| channel.wait(PAUSE));
            self.pass(py, &bytes, monitor.done())?;
            if ended {
                return Ok(());
            }
        }
    }

    /// Pass signals, bytes and progress to Python.
    fn pass(&self, py: Python<'_>, bytes: &[u8], done: u64) -> PyResult<()> {
        py.check_signals()?;
        if let (Some(write), false) = (&self.write, bytes.is_empty()) {
            write.call1(py, (bytes_of(py, bytes)?,))?;
        }
        if let (Some(progress), true) = (&self.progress, done > self.reported.load(Relaxed)) {
            progress.call1(py, (done.min(self.pixels), self.pixels))?;
            self.reported.store(done, Relaxed);
        }
        Ok(())
    }
}

/// The number of waiting bytes that are worth a call of Python.
const WORTH_PASSING: usize = 1 << 20;

/// What the calling thread has for Python while it works.
struct Outbox {
    listener: Listener,
    bytes: Mutex<Vec<u8>>,
    error: Mutex<Option<PyErr>>,
}

impl Outbox {
    /// Pass it to Python; return false if that raised an exception, now or before.
    fn empty(&self, done: u64) -> bool {
        if lock(&self.error).is_some() {
            return false;
        }
        let bytes = mem::take(&mut *lock(&self.bytes));
        let passed = Python::attach(|py| self.listener.pass(py, &bytes, done));
        passed.map_err(|error| *lock(&self.error) = Some(error)).is_ok()
    }
}

struct OutboxSink(Arc<Outbox>);

impl Write for OutboxSink {
    fn write(&mut self, new: &[u8]) -> io::Result<usize> {
        let mut bytes = lock(&self.0.bytes);
        reserve(&mut bytes, new.len(), "the file")?;
        bytes.extend_from_slice(new);
        let is_full = bytes.len() >= WORTH_PASSING;
        drop(bytes);
        // Progress is for the poll to report.
        if is_full && !self.0.empty(0) { Err(io::ErrorKind::BrokenPipe.into()) } else { Ok(new.len()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the calling thread does the work of a single thread itself, without the hand-over to a pool, which takes
/// as long as tracing a small picture: the first thread that asks does, as the main thread of a worker process.
///
/// It becomes a pool of its own, whose memory rayon never frees; so others, of which there may be any number, do not.
fn works_itself() -> PyResult<bool> {
    static FIRST: OnceLock<ThreadId> = OnceLock::new();
    let this = thread::current().id();
    if FIRST.set(this).is_ok() {
        grow_stack::<WORKING_STACK_BYTES>();
        let pool = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
        mem::forget(pool.map_err(|error| PyOSError::new_err(error.to_string()))?);
    }
    Ok(FIRST.get() == Some(&this))
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
    grow_stack::<STACK_BYTES>();
    let pages = py.import("mmap")?.call_method1("mmap", (-1, SPARE_BYTES + threads * THREAD_BYTES));
    let pages = pages.map_err(|_| PyMemoryError::new_err("not enough memory for threads"))?;
    pages.call_method0("close").map(drop)
}

/// Grow the calling thread's stack to its final size: the system ends a process whose stack cannot grow.
#[inline(never)]
fn grow_stack<const BYTES: usize>() {
    black_box([1_u8; BYTES]);
}
