//! Work in a pool of threads, while the calling thread listens to Python.

use std::num::NonZero;
use std::sync::Arc;
use std::time::Duration;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rtcli_tracer::WorkBudget;
use rtcli_tracer::render::Monitor;

use crate::mailbox::Mailbox;

/// How often the calling thread looks up: an interrupt is heeded this soon.
const PAUSE: Duration = Duration::from_millis(20);

/// What a rendering is told to Python while it goes on.
pub struct Listener<'a, 'py> {
    py: Python<'py>,
    /// Called with (pixels done, pixels in all).
    progress: Option<&'a Bound<'py, PyAny>>,
    /// Called with bytes.
    write: Option<&'a Bound<'py, PyAny>>,
    pixels: u64,
    told: u64,
    /// How much may be done; None for any amount.
    budget: Option<Arc<WorkBudget>>,
}

impl<'a, 'py> Listener<'a, 'py> {
    /// Returns a listener that nothing was told yet.
    pub fn new(
        py: Python<'py>,
        pixels: u64,
        progress: Option<&'a Bound<'py, PyAny>>,
        write: Option<&'a Bound<'py, PyAny>>,
    ) -> Self {
        Listener {
            py,
            progress,
            write,
            pixels,
            told: 0,
            budget: None,
        }
    }

    /// Bounds the work, which then ends as soon as it exceeds the budget.
    pub fn within(self, budget: Option<Arc<WorkBudget>>) -> Self {
        Listener { budget, ..self }
    }

    /// Runs work in a pool of threads and returns its result.
    ///
    /// The calling thread gives signals, progress and bytes to Python. What Python raises there ends the work.
    pub fn attend<T: Send>(
        &mut self,
        threads: usize,
        work: impl FnOnce(&Monitor, &Mailbox) -> T + Send,
    ) -> PyResult<T> {
        let monitor = self.budget.clone().map_or_else(Monitor::new, Monitor::within);
        let mailbox = Mailbox::default();
        let pool = pool(threads)?;
        let mut result = None;
        pool.in_place_scope(|scope| {
            scope.spawn(|_| {
                // Also when the work panics, which the scope then passes on.
                let _end = EndOf(&mailbox);
                result = Some(work(&monitor, &mailbox));
            });
            self.listen(&monitor, &mailbox).inspect_err(|_| {
                monitor.cancel();
                self.py.detach(|| mailbox.close());
            })
        })?;
        result.ok_or_else(|| PyRuntimeError::new_err("the work ended without a result"))
    }

    fn listen(&mut self, monitor: &Monitor, mailbox: &Mailbox) -> PyResult<()> {
        loop {
            let mail = self.py.detach(|| mailbox.wait(PAUSE));
            self.py.check_signals()?;
            if let (Some(write), false) = (self.write, mail.bytes.is_empty()) {
                write.call1((PyBytes::new(self.py, &mail.bytes),))?;
            }
            self.tell(monitor.done())?;
            if mail.ended {
                return Ok(());
            }
        }
    }

    fn tell(&mut self, done: u64) -> PyResult<()> {
        if let (Some(progress), true) = (self.progress, done > self.told) {
            progress.call1((done.min(self.pixels), self.pixels))?;
            self.told = done;
        }
        Ok(())
    }
}

struct EndOf<'a>(&'a Mailbox);

impl Drop for EndOf<'_> {
    fn drop(&mut self) {
        self.0.end();
    }
}

fn pool(threads: usize) -> PyResult<rayon::ThreadPool> {
    if threads < 1 {
        return Err(PyValueError::new_err("threads must be at least 1"));
    }
    // More would only wait for each other, and tens of thousands cannot be started.
    let most = 4 * std::thread::available_parallelism().map_or(1, NonZero::get);
    let threads = threads.min(most);
    let built = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    built.map_err(|error| PyRuntimeError::new_err(format!("cannot start {threads} threads: {error}")))
}
