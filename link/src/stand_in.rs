//! A publisher here that stands for one on another host.
//!
//! Slices are published as they were there: the same samples under the same marks of progress, and gaps in the numbers
//! where something was lost on the way, so that whoever reads here counts it. When the other publisher is replaced, so
//! is this one.

use anyhow::Context as _;
use bus::{Bus, Mark, Payload, Publisher, SharedMemory};
use messages::{BatchHeader, Topic};
use runtime::Now;

use crate::inbound::{Arrival, Counts};
use crate::stamps;
use crate::wire::{self, Head, Slice};

/// Place of samples that are told apart from their sequence.
pub(crate) const UNNUMBERED: u64 = u64::MAX;

/// Publishers here that stand, one after another, for those of a topic elsewhere.
pub(crate) struct StandIn<T: Payload> {
    pub(crate) topic: Topic<T>,
    open: Option<Open<T>>,
    /// Samples left out, as the sender said last.
    conflated: u64,
}

struct Open<T: Payload> {
    publisher: Publisher<SharedMemory, T>,
    /// Incarnation and epoch that it stands for.
    stands_for: (u64, u64),
    /// Number that comes next there; `None` while nothing has come.
    next_sequence: Option<u64>,
}

impl<T: Payload> StandIn<T> {
    pub(crate) fn new(topic: Topic<T>) -> Self {
        Self {
            topic,
            open: None,
            conflated: 0,
        }
    }

    /// Reads a message of samples that become those of the topic, with stamps of this host's clock; `None` if it is
    /// none, which is counted.
    pub(crate) fn read<R: Payload>(
        &mut self,
        arrival: &Arrival<'_>,
        counts: &mut Counts,
    ) -> Option<(Head, Vec<Slice<R>>)> {
        let Some((head, mut slices)) = wire::read::<R>(arrival.message, self.topic.capacity.slice_len) else {
            match wire::is_of_another_layout::<R>(arrival.message) {
                true => counts.schema_mismatch += 1,
                false => counts.rejected += 1,
            }
            return None;
        };
        if head.part.is_none() {
            let before = std::mem::replace(&mut self.conflated, head.conflated);
            counts.conflated += head.conflated.saturating_sub(before);
            counts.came += slices.iter().map(|(_, samples)| samples.len() as u64).sum::<u64>();
        }
        for sample in slices.iter_mut().flat_map(|(_, samples)| samples) {
            stamps::bring_here(sample, arrival.offset_ns, arrival.now);
        }
        Some((head, slices))
    }

    /// Number of samples that are missing before a slice with this header; `None` if it repeats what has been.
    pub(crate) fn missing(&self, header: &BatchHeader) -> Option<u64> {
        let same = |open: &&Open<T>| open.stands_for == (header.incarnation, header.epoch);
        let next = self.open.as_ref().filter(same).and_then(|open| open.next_sequence);
        header.first_sequence.checked_sub(next.unwrap_or(header.first_sequence))
    }

    /// Publishes samples of a slice with this header, of the deployment whose number is `origin`. `last` is called for
    /// each with its number here.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(crate) fn publish(
        &mut self,
        bus: &Bus<SharedMemory>,
        (header, origin): (&BatchHeader, u32),
        samples: &[T],
        now: Now,
        mut last: impl FnMut(&mut T, u64),
    ) -> anyhow::Result<()> {
        let missing = if header.first_sequence == UNNUMBERED {
            0
        } else {
            self.missing(header).unwrap_or(0)
        };
        let stands_for = (header.incarnation, header.epoch);
        if self.open.as_ref().is_none_or(|open| open.stands_for != stands_for) {
            // The one before is gone first: a topic has room for one and its successor.
            self.open = None;
            let publisher = bus.publisher(&self.topic, now.mono_ns as u64)?;
            let publisher = publisher.of_sensor(header.sensor_uid).of_origin(origin);
            self.open = Some(Open {
                publisher: publisher.with_epoch(header.epoch).of_boot(header.boot()),
                stands_for,
                next_sequence: None,
            });
        }
        let open = self.open.as_mut().context("it was just opened")?;
        open.publisher.pass_over(missing);
        let mark = Mark {
            progress_ns: header.progress_ns,
            sent_ns: now.mono_ns,
            end: header.flags & BatchHeader::END != 0,
        };
        open.publisher.send(mark, samples.len(), |index, sequence| {
            let mut sample = samples[index];
            last(&mut sample, sequence);
            sample
        })?;
        Ok(())
    }

    /// All samples of the other publisher up to the end of a slice of so many have been published, or never will be.
    pub(crate) fn pass(&mut self, header: &BatchHeader, count: usize) {
        if let Some(open) = self.open_for(header) {
            open.next_sequence = open.next_sequence.max(Some(header.first_sequence + count as u64));
        }
    }

    /// Nothing has come of the other publisher before a slice with this header, or how far it is stays as it is: what
    /// came apart from the sequence makes nothing less missing.
    pub(crate) fn begin(&mut self, header: &BatchHeader) {
        if let Some(open) = self.open_for(header) {
            open.next_sequence.get_or_insert(header.first_sequence);
        }
    }

    fn open_for(&mut self, header: &BatchHeader) -> Option<&mut Open<T>> {
        let same = |open: &&mut Open<T>| open.stands_for == (header.incarnation, header.epoch);
        self.open.as_mut().filter(same)
    }
}
