//! Bounds on work, in counted steps instead of seconds: whether they suffice depends on the world alone, not on
//! the machine, its SIMD level or the number of threads.
//!
//! A step is a visit to a node of the tree, or a test of a shape against 16 rays: about 10 ns.

use crate::tile::STEP;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A limit on work, shared between threads and between consecutive works.
#[derive(Debug)]
pub struct WorkBudget {
    limit: u64,
    spent: AtomicU64,
}

impl Default for WorkBudget {
    /// Return a budget without a limit.
    fn default() -> WorkBudget {
        WorkBudget::new(u64::MAX)
    }
}

impl WorkBudget {
    /// Make a budget of a number of steps.
    pub fn new(steps: u64) -> WorkBudget {
        WorkBudget { limit: steps, spent: AtomicU64::new(0) }
    }

    /// The steps done: always the same for completed work, and more than the limit otherwise.
    pub fn spent(&self) -> u64 {
        self.spent.load(Relaxed)
    }

    /// Whether the work exceeds the limit. The steps of each part are fixed and their sum only grows, so their
    /// order does not matter.
    pub fn is_exceeded(&self) -> bool {
        self.spent() > self.limit
    }

    /// A counter for a part of the work.
    pub(crate) fn counter(&self) -> WorkCounter {
        let left = self.limit.saturating_sub(self.spent());
        let allowed = i64::try_from(left).unwrap_or(i64::MAX);
        WorkCounter { allowed, left: allowed }
    }

    /// Count the steps of a part of the work.
    pub(crate) fn spend(&self, counter: WorkCounter) {
        self.spent.fetch_add(counter.allowed.abs_diff(counter.left), Relaxed);
    }
}

/// Counts the steps of a part of the work, by one thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorkCounter {
    allowed: i64,
    /// Below 0 once the limit is exceeded.
    left: i64,
}

impl Default for WorkCounter {
    fn default() -> WorkCounter {
        WorkBudget::default().counter()
    }
}

impl WorkCounter {
    /// Count steps about to be done, and return whether they are allowed.
    #[inline(always)]
    pub(crate) fn take(&mut self, steps: u64) -> bool {
        self.left = self.left.saturating_sub_unsigned(steps);
        !self.ran_out()
    }

    /// Whether the limit is exceeded: the result of the work is unusable.
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
        let mut counter = budget.counter();
        assert!(counter.take(4) && counter.take(6));
        budget.spend(counter);
        assert_eq!(budget.spent(), 10);
        assert!(!budget.is_exceeded());
    }

    #[test]
    fn one_step_too_many_exceeds_the_budget() {
        let budget = WorkBudget::new(10);
        let mut counter = budget.counter();
        assert!(counter.take(10));
        assert!(!counter.take(1));
        assert!(counter.ran_out());
        budget.spend(counter);
        assert!(budget.is_exceeded());
        assert!(!budget.counter().take(1));
    }

    #[test]
    fn parts_that_fit_alone_exceed_it_together() {
        let budget = WorkBudget::new(10);
        let (mut first, mut second) = (budget.counter(), budget.counter());
        assert!(first.take(6) && second.take(6));
        budget.spend(first);
        assert!(!budget.is_exceeded());
        budget.spend(second);
        assert!(budget.is_exceeded());
    }

    #[test]
    fn no_work_exceeds_a_budget_without_bound() {
        let budget = WorkBudget::default();
        let mut counter = budget.counter();
        assert!(counter.take(1 << 62));
        budget.spend(counter);
        assert!(!budget.is_exceeded());
    }
}
