//! Progress and cancellation of work.

use crate::budget::WorkBudget;
use crate::memory::OutOfMemory;
use std::error::Error;
use std::fmt;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Progress, cancellation and budget of some work, shared between threads; unlimited by default.
#[derive(Debug, Default)]
pub struct Monitor {
    done: AtomicU64,
    cancelled: Arc<AtomicBool>,
    /// The budget that the work counts its steps in.
    pub(crate) budget: Arc<WorkBudget>,
    poll: Option<Arc<Poll>>,
}

/// The time between two polls.
const INTERVAL: Duration = Duration::from_millis(20);

/// The calls of `is_due` for each look at the clock, which takes as long as one of the shortest steps between them.
const CALLS: u32 = 8;

/// A function that the working thread calls every 20 ms.
struct Poll {
    /// Given the pixels that are done, returns whether to continue.
    function: Box<dyn Fn(u64) -> bool + Send + Sync>,
    start: Instant,
    /// When to call it next, in nanoseconds from the start.
    due: AtomicU64,
    calls: AtomicU32,
}

impl Poll {
    fn is_due(&self) -> bool {
        let calls = self.calls.load(Relaxed).wrapping_add(1);
        self.calls.store(calls, Relaxed);
        calls.is_multiple_of(CALLS) && self.start.elapsed().as_nanos() as u64 >= self.due.load(Relaxed)
    }

    fn call(&self, done: u64) -> bool {
        let continues = (self.function)(done);
        self.due.store((self.start.elapsed() + INTERVAL).as_nanos() as u64, Relaxed);
        continues
    }
}

impl fmt::Debug for Poll {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Poll").finish_non_exhaustive()
    }
}

impl Monitor {
    /// Monitor work that ends when it exceeds a budget.
    pub fn within(budget: Arc<WorkBudget>) -> Monitor {
        Monitor { budget, ..Monitor::default() }
    }

    /// Let the working thread, which must be the only one, call a function every 20 ms with the pixels that are done;
    /// the work is cancelled once it returns false.
    pub fn polling(self, function: impl Fn(u64) -> bool + Send + Sync + 'static) -> Monitor {
        let due = AtomicU64::new(INTERVAL.as_nanos() as u64);
        let poll = Poll { function: Box::new(function), start: Instant::now(), due, calls: AtomicU32::new(0) };
        Monitor { poll: Some(Arc::new(poll)), ..self }
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
        self.aside_within(Arc::clone(&self.budget))
    }

    /// A monitor with a progress and a budget of its own, cancelled together with this one.
    pub fn aside_within(&self, budget: Arc<WorkBudget>) -> Monitor {
        Monitor {
            done: AtomicU64::default(),
            cancelled: Arc::clone(&self.cancelled),
            budget,
            poll: self.poll.clone(),
        }
    }

    /// Whether the work was cancelled; polls if that is due.
    pub fn cancelled(&self) -> bool {
        if let Some(poll) = &self.poll {
            self.poll(poll);
        }
        self.cancelled.load(Relaxed)
    }

    /// Poll if that is due. Not inlined into each kernel, of which there is one for each SIMD level.
    #[inline(never)]
    fn poll(&self, poll: &Poll) {
        if poll.is_due() && !poll.call(self.done()) {
            self.cancel();
        }
    }

    /// Return an error if the work was cancelled or exceeds its budget.
    ///
    /// # Errors
    ///
    /// If it was, or does.
    pub fn check(&self) -> Result<(), Stopped> {
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

#[cfg(test)]
mod tests {
    use super::Monitor;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

    #[test]
    fn work_that_polls_ends_when_the_function_says_so() {
        let seen = Arc::new(AtomicU64::new(0));
        let shared = Arc::clone(&seen);
        let monitor = Monitor::default().polling(move |done| {
            shared.store(done, Relaxed);
            done < 3
        });
        monitor.add(2);
        assert!(!monitor.cancelled(), "the first poll is due after the interval");
        while seen.load(Relaxed) == 0 {
            assert!(!monitor.cancelled());
        }
        monitor.add(1);
        while !monitor.cancelled() {}
        assert!(monitor.aside().cancelled());
    }
}
