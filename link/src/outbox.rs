//! Messages that wait for the network, and the thread that hands them over.
//!
//! Zenoh's queues are bounded; with a full queue, a message waits a millisecond and is dropped silently. To keep
//! waiting and losses away from the deployment, messages first wait here, for a separate thread. Messages without
//! room in the outbox return to their sender, which decides about omissions.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use runtime::clock::instant;
use zenoh::Wait as _;
use zenoh::pubsub::Publisher;

/// Time for which the first messages wait for a first reader.
const FIRST_READER: Duration = Duration::from_secs(2);
/// Pause between two looks for one.
const PAUSE: Duration = Duration::from_millis(10);

/// Messages that wait for the network.
#[derive(Debug)]
pub(crate) struct Outbox {
    shared: Arc<OutboxState>,
    room: usize,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct OutboxState {
    waiting: Mutex<WaitingMessage>,
    came: Condvar,
    failures: AtomicU64,
}

#[derive(Debug, Default)]
struct WaitingMessage {
    messages: VecDeque<(usize, Vec<u8>)>,
    octets: usize,
    is_closed: bool,
}

impl OutboxState {
    fn lock(&self) -> MutexGuard<'_, WaitingMessage> {
        // A panic in another thread leaves the queue consistent.
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Outbox {
    /// Opens an outbox of `room` bytes for the streams of `publishers`.
    pub(crate) fn open(room: usize, publishers: Vec<Publisher<'static>>) -> anyhow::Result<Self> {
        let shared = Arc::new(OutboxState::default());
        let of_thread = Arc::clone(&shared);
        let hand_over = move || hand_over(&of_thread, &publishers);
        let thread = std::thread::Builder::new().name("outbox".to_owned()).spawn(hand_over)?;
        Ok(Self {
            shared,
            room,
            thread: Some(thread),
        })
    }

    /// Whether a message of so many bytes would find room now.
    pub(crate) fn has_room(&self, octets: usize) -> bool {
        self.shared.lock().octets + octets <= self.room
    }

    /// Takes a message of `lane`.
    pub(crate) fn put(&self, lane: usize, message: Vec<u8>) {
        let mut waiting = self.shared.lock();
        waiting.octets += message.len();
        waiting.messages.push_back((lane, message));
        self.shared.came.notify_one();
    }

    /// Messages that the network has refused.
    pub(crate) fn failures(&self) -> u64 {
        self.shared.failures.load(Ordering::Relaxed)
    }
}

impl Drop for Outbox {
    fn drop(&mut self) {
        self.shared.lock().is_closed = true;
        self.shared.came.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Waits for a reader for a limited time: existing links need a moment to declare their subscriptions.
fn wait_for_readers(shared: &OutboxState, publishers: &[Publisher<'static>]) {
    let begun = instant();
    let is_read = |publisher: &Publisher<'_>| publisher.matching_status().wait().is_ok_and(|status| status.matching());
    while begun.elapsed() < FIRST_READER && !publishers.iter().any(is_read) && !shared.lock().is_closed {
        std::thread::sleep(PAUSE);
    }
}

fn hand_over(shared: &OutboxState, publishers: &[Publisher<'static>]) {
    wait_for_readers(shared, publishers);
    loop {
        let mut waiting = shared.lock();
        let (lane, message) = loop {
            if let Some(next) = waiting.messages.pop_front() {
                break next;
            }
            if waiting.is_closed {
                return;
            }
            waiting = shared.came.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        };
        waiting.octets -= message.len();
        drop(waiting);
        if publishers[lane].put(message).wait().is_err() {
            shared.failures.fetch_add(1, Ordering::Relaxed);
        }
    }
}
