//! Requests for snapshots of the fusion engine.
//!
//! A recording can be replayed from a start of fusion up to the first missing sample. A recorder that was absent at
//! the start, or has lost samples since, requests a snapshot from which replay can continue. A recorder that
//! deletes old files also requests snapshots regularly, so that the remaining files have a starting point. A
//! snapshot pauses fusion, so requests are rare.

use bus::{Bus, Mark, Publisher, Transport};
use deployment::Segments as Settings;
use messages::{Order, OrderKind};
use runtime::Now;

/// Minimum time between two snapshots, nanoseconds.
const PAUSE_NS: i64 = 60_000_000_000;

/// Requester of snapshots.
#[derive(Debug)]
pub(crate) struct Images<S: Transport> {
    publisher: Publisher<S, Order>,
    /// Whether replay needs a snapshot to continue.
    is_missed: bool,
    /// Number of lost samples at the last request.
    lost: u64,
    asked_ns: i64,
    /// Earliest time of the next request.
    earliest_ns: i64,
    /// Time after which a request is made in any case, nanoseconds.
    period_ns: Option<i64>,
}

impl<S: Transport> Images<S> {
    /// Creates the requester of a recorder that starts now. The first request is not before `earliest_ns`
    /// (monotonic, nanoseconds): by then, fusion must have processed everything sent before the recorder's start.
    /// `is_late` states that samples were already sent.
    ///
    /// # Errors
    /// If the topic cannot be opened.
    pub(crate) fn new(
        bus: &Bus<S>,
        settings: &Settings,
        incarnation: u64,
        earliest_ns: i64,
        is_late: bool,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            publisher: bus.publisher(&messages::orders(), incarnation)?,
            is_missed: is_late,
            lost: 0,
            asked_ns: earliest_ns,
            earliest_ns,
            period_ns: settings.keep_bytes.map(|_| settings.length_ns),
        })
    }

    /// Requests a snapshot if due; `lost` is the recorder's number of lost samples.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(crate) fn tend(&mut self, lost: u64, now: Now) -> anyhow::Result<()> {
        let is_old = self
            .period_ns
            .is_some_and(|period_ns| now.mono_ns - self.asked_ns >= period_ns);
        if now.mono_ns < self.earliest_ns || !(self.is_missed || lost > self.lost || is_old) {
            return Ok(());
        }
        (self.is_missed, self.lost) = (false, lost);
        (self.asked_ns, self.earliest_ns) = (now.mono_ns, now.mono_ns + PAUSE_NS);
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: now.mono_ns,
            end: false,
        };
        let order = Order {
            token: now.mono_ns.cast_unsigned(),
            sent_ns: now.utc_ns,
            ..Order::new(OrderKind::Snapshot).with_operator("recorder")
        };
        self.publisher.send(mark, 1, |_, _| order)?;
        Ok(())
    }
}
