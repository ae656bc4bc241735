//! Words in the place of those of shared memory: the checker tries all orders of their operations.
//!
//! A protocol states with each operation which orders it excludes. So that a check shows that each statement is needed,
//! a model can be [weakened](Weakness): one kind of statement has no effect then, and the model must fail.

use std::cell::Cell;

use loom::sync::atomic::Ordering::{self, AcqRel, Acquire, Relaxed, Release};

/// Kind of statement that has no effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Weakness {
    /// All have.
    #[default]
    None,
    /// Stores, and those of a swap, are relaxed.
    Stores,
    /// Loads, and those of a swap, are relaxed.
    Loads,
    /// Fences of a writer are missing.
    ReleaseFences,
    /// Fences of a reader are missing.
    AcquireFences,
}

thread_local! {
    // The checker runs all threads of a model in the thread of the test.
    static WEAKNESS: Cell<Weakness> = const { Cell::new(Weakness::None) };
}

/// Most changes of the running thread, apart from waits, in a checked order.
const PREEMPTIONS: usize = 3;

/// Runs `model` in all orders of its operations; statements of one kind may have no effect.
pub(crate) fn check(weakness: Weakness, model: impl Fn() + Send + Sync + 'static) {
    WEAKNESS.set(weakness);
    let mut builder = loom::model::Builder::new();
    // Without a bound, the orders of three threads take hours.
    builder.preemption_bound = Some(PREEMPTIONS);
    builder.check(model);
}

/// A word of shared memory.
#[derive(Debug, Default)]
pub(crate) struct AtomicU64(loom::sync::atomic::AtomicU64);

impl AtomicU64 {
    pub(crate) fn load(&self, order: Ordering) -> u64 {
        self.0.load(if WEAKNESS.get() == Weakness::Loads {
            Relaxed
        } else {
            order
        })
    }

    pub(crate) fn store(&self, word: u64, order: Ordering) {
        let is_weak = WEAKNESS.get() == Weakness::Stores;
        self.0.store(word, if is_weak { Relaxed } else { order });
    }

    pub(crate) fn fetch_add(&self, word: u64, order: Ordering) -> u64 {
        self.0.fetch_add(word, of_swap(order))
    }

    pub(crate) fn compare_exchange(&self, from: u64, to: u64, order: Ordering, failed: Ordering) -> Result<u64, u64> {
        self.0.compare_exchange(from, to, of_swap(order), failed)
    }
}

fn of_swap(order: Ordering) -> Ordering {
    match (WEAKNESS.get(), order) {
        (Weakness::Stores, AcqRel) => Acquire,
        (Weakness::Loads, AcqRel) => Release,
        (Weakness::Stores, Release) | (Weakness::Loads, Acquire) => Relaxed,
        _ => order,
    }
}

pub(crate) fn fence(order: Ordering) {
    match (WEAKNESS.get(), order) {
        (Weakness::ReleaseFences, Release) | (Weakness::AcquireFences, Acquire) => {}
        _ => loom::sync::atomic::fence(order),
    }
}
