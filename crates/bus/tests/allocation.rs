//! What the steady state asks of the heap.
//!
//! Taking and waiting: nothing. Sending: nothing by this crate; iceoryx2 0.10 keeps the state of a loaned slice in one
//! small block, which it takes when the slice is loaned and gives back before the send returns. This test says so with
//! exact numbers, so that a change in either direction is noticed.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::Duration;

use bus::{InProcess, SharedMemory, Transport, WaitMode, Woken};
use common::{Home, Line, PATIENCE, mark, track};

/// Counts what the current thread asks of the heap.
struct Counting;

/// Larger than the block that iceoryx2 takes for each slice.
const SMALL_BYTES: usize = 64;

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

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How often `work` took a block from the heap, and gave one back.
fn heap_use(work: impl FnOnce()) -> (u64, u64) {
    let before = (TAKEN.get(), GIVEN_BACK.get());
    LARGEST.set(0);
    work();
    (TAKEN.get() - before.0, GIVEN_BACK.get() - before.1)
}

fn steady_state_leaves_the_heap_alone<S: Transport>(mode: WaitMode) {
    let home = Home::new();
    let line = Line::<S>::new(&home, "a", 8, 4);
    let (mut publisher, mut subscriber) = (line.publisher(10), line.subscriber(5));
    let mut waiter = line.bus.waiter(mode);
    waiter.watch(&line.bus, &line.topic).unwrap();

    let mut round = |count: usize, times: usize| {
        let slices = publisher.counts().slices;
        let sending = heap_use(|| {
            for _ in 0..times {
                publisher.send(mark(0), count, |_, s| track(s)).unwrap();
            }
        });
        let slices = publisher.counts().slices - slices;
        let small = LARGEST.get() <= SMALL_BYTES;
        let taking = heap_use(|| {
            let mut early = true;
            let woken = waiter.wait(PATIENCE, || !std::mem::take(&mut early) && subscriber.has_slices());
            assert_eq!(woken.unwrap(), Woken::Work);
            while subscriber.take(3, |_, _| ()).unwrap() == 3 {}
            let nothing = waiter.wait(Duration::from_micros(50), || subscriber.has_slices());
            assert_eq!(nothing.unwrap(), Woken::Timeout);
        });
        (sending, slices, small, taking)
    };
    // The ports meet, and the first memory is touched.
    round(1, 1);

    // One sample; empty slices; several slices; more than the queue holds.
    for (count, times) in [(1, 1), (0, 2), (9, 1), (2, 20)].repeat(50) {
        let (sending, slices, small, taking) = round(count, times);
        assert_eq!(taking, (0, 0), "{mode:?}");
        assert_eq!(sending, (slices, slices), "{mode:?}");
        assert!(small);
    }
}

#[test]
fn in_shared_memory() {
    for mode in [WaitMode::Spin, WaitMode::Event, WaitMode::Hybrid { spin_ns: 1000 }] {
        steady_state_leaves_the_heap_alone::<SharedMemory>(mode);
    }
}

#[test]
fn in_the_process() {
    for mode in [WaitMode::Spin, WaitMode::Event, WaitMode::Hybrid { spin_ns: 1000 }] {
        steady_state_leaves_the_heap_alone::<InProcess>(mode);
    }
}
