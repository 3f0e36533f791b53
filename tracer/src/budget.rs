//! Bounds on work, in steps that are counted and not timed: whether they suffice
//! depends on the world alone, not on the machine, its SIMD level or the number of threads.
//!
//! A step is a node of the tree that is visited, or a test of a shape against 16 rays: about 10 ns.

use crate::tile::STEP;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// How much work may be done; shared between threads, and by several works in turn.
#[derive(Debug)]
pub struct WorkBudget {
    limit: u64,
    spent: AtomicU64,
}

impl WorkBudget {
    /// Make a budget of a number of steps.
    pub fn new(steps: u64) -> WorkBudget {
        WorkBudget {
            limit: steps,
            spent: AtomicU64::new(0),
        }
    }

    /// Without a bound.
    pub fn unlimited() -> WorkBudget {
        WorkBudget::new(u64::MAX)
    }

    /// The steps that were done: of work that ended, always the same; of work that did not, more than the limit.
    pub fn spent(&self) -> u64 {
        self.spent.load(Relaxed)
    }

    /// Whether there was more to do than there may be.
    ///
    /// Each part of a work counts the same steps whoever does it, and their sum only grows: so it does not depend
    /// on their order whether it ever passes the limit.
    pub fn is_exceeded(&self) -> bool {
        self.spent() > self.limit
    }

    /// A meter for a part of the work.
    pub(crate) fn meter(&self) -> WorkMeter {
        let left = self.limit.saturating_sub(self.spent());
        let allowed = i64::try_from(left).unwrap_or(i64::MAX);
        WorkMeter { allowed, left: allowed }
    }

    /// Count what a part of the work took, or more than there was left for it.
    pub(crate) fn spend(&self, meter: WorkMeter) {
        self.spent.fetch_add(meter.allowed.abs_diff(meter.left), Relaxed);
    }
}

/// Counts the steps of a part of the work, by one thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorkMeter {
    allowed: i64,
    /// Below 0 once more was asked for than there may be.
    left: i64,
}

impl Default for WorkMeter {
    fn default() -> WorkMeter {
        WorkBudget::unlimited().meter()
    }
}

impl WorkMeter {
    /// Count steps that are to be done now, and return whether they may.
    #[inline(always)]
    pub(crate) fn take(&mut self, steps: u64) -> bool {
        self.left = self.left.saturating_sub_unsigned(steps);
        !self.ran_out()
    }

    /// Whether steps were asked for that may not be done: the result of the work is not to be used.
    #[inline(always)]
    pub(crate) fn ran_out(&self) -> bool {
        self.left < 0
    }
}

/// Fetching a shape and computing its constants takes as long as the test of a few more groups of rays.
const SHAPE_STEPS: u64 = 4;

/// Return the steps of a test of one shape against a number of rays.
#[inline(always)]
pub(crate) const fn steps_of(rays: usize) -> u64 {
    SHAPE_STEPS + rays.div_ceil(STEP) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_is_done_and_counted() {
        let budget = WorkBudget::new(10);
        let mut meter = budget.meter();
        assert!(meter.take(4) && meter.take(6));
        budget.spend(meter);
        assert_eq!(budget.spent(), 10);
        assert!(!budget.is_exceeded());
    }

    #[test]
    fn one_step_too_many_exceeds_the_budget() {
        let budget = WorkBudget::new(10);
        let mut meter = budget.meter();
        assert!(meter.take(10));
        assert!(!meter.take(1));
        assert!(meter.ran_out());
        budget.spend(meter);
        assert!(budget.is_exceeded());
        assert!(!budget.meter().take(1));
    }

    #[test]
    fn parts_that_fit_alone_exceed_it_together() {
        let budget = WorkBudget::new(10);
        let (mut first, mut second) = (budget.meter(), budget.meter());
        assert!(first.take(6) && second.take(6));
        budget.spend(first);
        assert!(!budget.is_exceeded());
        budget.spend(second);
        assert!(budget.is_exceeded());
    }

    #[test]
    fn no_work_exceeds_a_budget_without_bound() {
        let budget = WorkBudget::unlimited();
        let mut meter = budget.meter();
        assert!(meter.take(1 << 62));
        budget.spend(meter);
        assert!(!budget.is_exceeded());
    }
}
