//! Queues between a loop and its housekeeper.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;

use crossbeam_queue::ArrayQueue;
use deployment::DecisionUse;
use messages::{Decision, Order, OrderState, RESTORED_WORDS, Restored, SensorTrack};

/// Maximum number of orders that wait for the loop.
const ORDERS_MAX: usize = 16;
/// Maximum number of states of orders that wait for publication: a start publishes all orders in force.
const ORDER_STATES_MAX: usize = 256;
/// Maximum number of decisions that wait for publication; further ones are counted as dropped.
const DECISIONS_MAX: usize = 8192;
/// Maximum number of changes of role that wait for publication.
const NAMES_MAX: usize = 4;
/// Maximum number of reports in quarantine that wait to be written.
const QUARANTINED_MAX: usize = 4;

/// Queues to a loop and from it.
#[derive(Debug)]
pub struct Queues {
    /// Orders to the loop.
    pub orders: ArrayQueue<Order>,
    /// States of orders, for publication.
    pub order_states: ArrayQueue<OrderState>,
    /// True once the loop obeys orders.
    leads: AtomicBool,
    /// The housekeeper, which sleeps long before the loop leads.
    housekeeper: OnceLock<Thread>,
    /// Orders that were refused before the loop.
    refused: AtomicU64,
    /// Decisions of the loop, for publication; `None` without a request.
    pub decisions: Option<ArrayQueue<Decision>>,
    /// Use of these decisions.
    decision_use: Option<DecisionUse>,
    /// Snapshots of the engine.
    pub restored: ArrayQueue<SnapshotParts>,
    /// Reports in quarantine, for a file.
    pub quarantined: ArrayQueue<SensorTrack>,
    /// Names of the process after changes of its role.
    pub names: ArrayQueue<&'static str>,
}

/// Snapshot in parts on `system/restored`.
#[derive(Clone, Debug, Default)]
pub struct SnapshotParts {
    /// Epoch of the loop.
    pub epoch: u64,
    /// UTC, nanoseconds since 1970: see [`Restored::time_ns`].
    pub time_ns: i64,
    /// Kind of snapshot: see [`Restored::ends`].
    pub ends: u32,
    /// Words of all parts, as bytes; the last part is filled with zeros.
    pub octets: Vec<u8>,
}

/// Bytes of a part.
const PART: usize = RESTORED_WORDS * size_of::<u64>();

impl SnapshotParts {
    pub(crate) fn parts(&self) -> usize {
        self.octets.len().div_ceil(PART)
    }

    pub(crate) fn part(&self, part: usize) -> Restored {
        let octets = self.octets.chunks(PART).nth(part).unwrap_or_default();
        let mut restored = Restored {
            epoch: self.epoch,
            time_ns: self.time_ns,
            part: part as u32,
            parts: self.parts() as u32,
            ends: self.ends,
            ..Restored::default()
        };
        for (word, octets) in restored.words.iter_mut().zip(octets.chunks(size_of::<u64>())) {
            let mut whole = [0; size_of::<u64>()];
            whole[..octets.len()].copy_from_slice(octets);
            *word = u64::from_le_bytes(whole);
            restored.count += 1;
        }
        restored
    }
}

impl Queues {
    /// Creates empty queues, with a queue of decisions if these have a use.
    pub fn new(decision_use: Option<DecisionUse>) -> Arc<Self> {
        Arc::new(Self {
            orders: ArrayQueue::new(ORDERS_MAX),
            order_states: ArrayQueue::new(ORDER_STATES_MAX),
            leads: AtomicBool::new(false),
            housekeeper: OnceLock::new(),
            refused: AtomicU64::new(0),
            decisions: decision_use.map(|_| ArrayQueue::new(DECISIONS_MAX)),
            decision_use,
            restored: ArrayQueue::new(1),
            quarantined: ArrayQueue::new(QUARANTINED_MAX),
            names: ArrayQueue::new(NAMES_MAX),
        })
    }

    /// Whether every decision has to be published.
    pub(crate) fn records_decisions(&self) -> bool {
        self.decision_use == Some(DecisionUse::Record)
    }

    /// Begins to pass orders to the loop. Before, orders are taken and dropped: another process obeys.
    pub fn lead(&self) {
        self.leads.store(true, Ordering::Release);
        if let Some(housekeeper) = self.housekeeper.get() {
            housekeeper.unpark();
        }
    }

    /// Lets `thread` wake up once the loop leads.
    pub(crate) fn keep(&self, thread: Thread) {
        // A second housekeeper would look at times only.
        let _ = self.housekeeper.set(thread);
    }

    /// Returns whether the loop obeys orders.
    pub(crate) fn leads(&self) -> bool {
        self.leads.load(Ordering::Acquire)
    }

    /// Returns the number of orders that were refused before the loop.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    pub(crate) fn count_refused(&self) {
        self.refused.fetch_add(1, Ordering::Relaxed);
    }
}
