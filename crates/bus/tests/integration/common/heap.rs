//! An allocator that counts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Counts what the current thread asks of the heap.
pub(crate) struct Counting;

/// Larger than the block that iceoryx2 takes for each slice.
pub(crate) const SMALL_BYTES: usize = 64;

thread_local! {
    static TAKEN: Cell<u64> = const { Cell::new(0) };
    static GIVEN_BACK: Cell<u64> = const { Cell::new(0) };
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

fn count_taken(bytes: usize) {
    // At the very end of a thread there is nothing left to count with.
    let _ = TAKEN.try_with(|taken| taken.set(taken.get() + 1));
    let _ = LARGEST.try_with(|largest| largest.set(largest.get().max(bytes)));
}

fn count_given_back() {
    let _ = GIVEN_BACK.try_with(|given_back| given_back.set(given_back.get() + 1));
}

// SAFETY: every call is passed on unchanged to the system's allocator, which keeps the contract.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count_taken(layout.size());
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count_given_back();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count_taken(size);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// What a piece of work asked of the heap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HeapUse {
    /// Blocks taken.
    pub(crate) taken: u64,
    /// Blocks given back.
    pub(crate) given_back: u64,
    /// Size of the largest.
    pub(crate) largest_bytes: usize,
}

/// What `work` asks of the heap on this thread.
pub(crate) fn heap_use(work: impl FnOnce()) -> HeapUse {
    let before = (TAKEN.get(), GIVEN_BACK.get());
    LARGEST.set(0);
    work();
    HeapUse {
        taken: TAKEN.get() - before.0,
        given_back: GIVEN_BACK.get() - before.1,
        largest_bytes: LARGEST.get(),
    }
}
