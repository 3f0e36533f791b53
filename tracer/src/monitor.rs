//! Progress and cancellation of work.

use crate::budget::WorkBudget;
use crate::memory::OutOfMemory;
use std::error::Error;
use std::fmt;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

/// Progress, cancellation and budget of some work, shared between threads; unlimited by default.
#[derive(Debug, Default)]
pub struct Monitor {
    done: AtomicU64,
    cancelled: Arc<AtomicBool>,
    /// The budget that the work counts its steps in.
    pub(crate) budget: Arc<WorkBudget>,
}

impl Monitor {
    /// Monitor work that ends when it exceeds a budget.
    pub fn within(budget: Arc<WorkBudget>) -> Monitor {
        Monitor { budget, ..Monitor::default() }
    }

    /// The pixels that are done.
    pub fn done(&self) -> u64 {
        self.done.load(Relaxed)
    }

    /// Count pixels that are done.
    pub(crate) fn add(&self, pixels: u64) {
        self.done.fetch_add(pixels, Relaxed);
    }

    /// Cancel the work: it ends within a tile.
    pub fn cancel(&self) {
        self.cancelled.store(true, Relaxed);
    }

    /// A monitor with a progress of its own, cancelled together with this one.
    pub(crate) fn aside(&self) -> Monitor {
        Monitor { cancelled: Arc::clone(&self.cancelled), ..Monitor::within(Arc::clone(&self.budget)) }
    }

    /// Whether the work was cancelled.
    pub fn cancelled(&self) -> bool {
        self.cancelled.load(Relaxed)
    }

    /// Return an error if the work was cancelled or exceeds its budget.
    pub(crate) fn check(&self) -> Result<(), Stopped> {
        if self.cancelled() {
            Err(Stopped::Cancelled)
        } else if self.budget.is_exceeded() {
            Err(Stopped::BudgetExceeded)
        } else {
            Ok(())
        }
    }
}

/// Why work ended early.
#[derive(Debug)]
pub enum Stopped {
    /// The caller asked for it.
    Cancelled,
    /// The work exceeds its budget.
    BudgetExceeded,
    /// There is not enough memory.
    OutOfMemory(OutOfMemory),
    /// The sink of a picture failed.
    Io(io::Error),
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stopped::Cancelled => f.write_str("the rendering was given up"),
            Stopped::BudgetExceeded => f.write_str("there is more to do than the budget allows"),
            Stopped::OutOfMemory(error) => error.fmt(f),
            Stopped::Io(error) => error.fmt(f),
        }
    }
}

impl Error for Stopped {}

impl From<OutOfMemory> for Stopped {
    fn from(error: OutOfMemory) -> Stopped {
        Stopped::OutOfMemory(error)
    }
}

impl From<io::Error> for Stopped {
    fn from(error: io::Error) -> Stopped {
        Stopped::Io(error)
    }
}
