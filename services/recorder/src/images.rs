//! Requests for snapshots of the fusion engine.
//!
//! A recording can be replayed from a start of fusion up to the first missing sample. A recorder that was absent at
//! the start, or has lost samples since, requests a snapshot from which replay can continue. A recorder that
//! deletes old files also requests snapshots regularly, so that the remaining files have a starting point. A
//! snapshot pauses fusion, so requests are rare: the pause between two requests grows while losses go on.
//!
//! Every gap ends with a request, once the recorder can write again: a snapshot that cannot be written proves nothing.

use bus::{Bus, Mark, Publisher, Transport};
use deployment::Segments as Settings;
use messages::{Order, OrderKind};
use runtime::Now;

/// Minimum time between two snapshots, nanoseconds: the first, and the longest, after requests that followed each other
/// as closely as permitted.
const PAUSE_MIN_NS: i64 = 1_000_000_000;
const PAUSE_MAX_NS: i64 = 60_000_000_000;

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
    /// Time from the latest request to the next.
    pause_ns: i64,
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
            pause_ns: PAUSE_MIN_NS,
            period_ns: settings.keep_bytes.map(|_| settings.length_ns),
        })
    }

    /// Requests a snapshot if due; `lost` is the recorder's number of lost samples, and `is_writing` whether its files
    /// take what arrives.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(crate) fn tend(&mut self, lost: u64, is_writing: bool, now: Now) -> anyhow::Result<()> {
        self.is_missed |= lost > self.lost;
        self.lost = lost;
        let is_old = self
            .period_ns
            .is_some_and(|period_ns| now.mono_ns - self.asked_ns >= period_ns);
        if now.mono_ns < self.earliest_ns || !is_writing || !(self.is_missed || is_old) {
            return Ok(());
        }
        let is_quiet = now.mono_ns - self.asked_ns >= (4 * self.pause_ns).min(PAUSE_MAX_NS);
        self.pause_ns = match is_quiet {
            true => PAUSE_MIN_NS,
            false => (2 * self.pause_ns).min(PAUSE_MAX_NS),
        };
        self.is_missed = false;
        (self.asked_ns, self.earliest_ns) = (now.mono_ns, now.mono_ns + self.pause_ns);
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
