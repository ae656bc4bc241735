//! When fusion is asked for an image of its engine.
//!
//! A recording can be replayed from a beginning of fusion on for as long as nothing is missing in it. A recorder that
//! was not there at the beginning, or has lost something since, asks for an image, from which replay goes on. So does
//! one that deletes old files, now and then: what is left shall have a beginning, too. An image costs fusion a pause,
//! so there are few.

use bus::{Bus, Mark, Publisher, Transport};
use configuration::Segments as Settings;
use messages::Control;
use runtime::Now;

/// Least time between two images, nanoseconds.
const PAUSE_NS: i64 = 60_000_000_000;

/// Asks fusion for images.
#[derive(Debug)]
pub(crate) struct Images<S: Transport> {
    publisher: Publisher<S, Control>,
    /// Whether replay could not go on without one.
    is_missed: bool,
    /// Samples that had been lost when it was asked last.
    lost: u64,
    asked_ns: i64,
    /// When it may be asked again.
    earliest_ns: i64,
    /// Time after which it is asked in any case, nanoseconds.
    period_ns: Option<i64>,
}

impl<S: Transport> Images<S> {
    /// Of a recorder that starts now, and asks not before `earliest_ns` (monotonic, nanoseconds): what was sent to it
    /// before it was there must have been worked off by then. `is_late` if something has been sent already.
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
            publisher: bus.publisher(&messages::control(), incarnation)?,
            is_missed: is_late,
            lost: 0,
            asked_ns: earliest_ns,
            earliest_ns,
            period_ns: settings.keep_bytes.map(|_| settings.length_ns),
        })
    }

    /// Asks for one if it is time; the recorder has lost so many samples.
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
        self.publisher.send(mark, 1, |_, _| Control::image())?;
        Ok(())
    }
}
