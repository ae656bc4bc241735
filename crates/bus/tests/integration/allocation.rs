//! What the steady state asks of the heap.
//!
//! Taking and waiting: nothing. Sending: nothing by this crate; iceoryx2 0.10 keeps the state of a loaned slice in one
//! small block, which it takes when the slice is loaned and gives back before the send returns. This test says so with
//! exact numbers, so that a change in either direction is noticed.

use std::time::Duration;

use crate::common::heap::{Counting, SMALL_BYTES, heap_use};
use crate::common::{Home, Line, PATIENCE, mark, track};
use bus::{InProcess, SharedMemory, Transport, WaitMode, Woken};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

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
        let taking = heap_use(|| {
            let mut early = true;
            let woken = waiter.wait(PATIENCE, || !std::mem::take(&mut early) && subscriber.has_slices());
            assert_eq!(woken.unwrap(), Woken::Work);
            while subscriber.take(3, |_, _| ()).unwrap() == 3 {}
            let nothing = waiter.wait(Duration::from_micros(50), || subscriber.has_slices());
            assert_eq!(nothing.unwrap(), Woken::Timeout);
        });
        (sending, slices, taking)
    };
    // The ports meet, and the first memory is touched.
    round(1, 1);

    // One sample; empty slices; several slices; more than the queue holds.
    for (count, times) in [(1, 1), (0, 2), (9, 1), (2, 20)].repeat(50) {
        let (sending, slices, taking) = round(count, times);
        assert_eq!((taking.taken, taking.given_back), (0, 0), "{mode:?}");
        assert_eq!((sending.taken, sending.given_back), (slices, slices), "{mode:?}");
        assert!(sending.largest_bytes <= SMALL_BYTES);
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
