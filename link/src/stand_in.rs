//! A publisher here that stands for one on another host.
//!
//! Slices are published as they were there: the same samples under the same marks of progress, and gaps in the numbers
//! where something was lost on the way, so that whoever reads here counts it. When the other publisher is replaced, so
//! is this one. A topic of many publishers has one stand-in for all of them, which follows the numbers of each.

use std::collections::BTreeMap;

use anyhow::Context as _;
use bus::{Bus, Mark, Payload, Publisher, SharedMemory};
use messages::{BatchHeader, Topic};
use runtime::Now;

use crate::inbound::{Arrival, Counts};
use crate::stamps;
use crate::wire::{self, Head, Slice};

/// Place of samples that are told apart from their sequence.
pub(crate) const UNNUMBERED: u64 = u64::MAX;
/// A topic of more publishers than this is one of many processes at a time; others have one and its successor.
const SUCCESSORS_MAX: usize = 8;
/// Publishers of a topic whose numbers are followed, at most.
const FOLLOWED_MAX: usize = 256;

/// Publishers here that stand, one after another, for those of a topic elsewhere.
pub(crate) struct StandIn<T: Payload> {
    pub(crate) topic: Topic<T>,
    open: Option<Open<T>>,
    /// Number that comes next of each publisher there, by its incarnation.
    next: BTreeMap<u64, u64>,
    /// Samples left out, as the sender said last.
    conflated: u64,
}

struct Open<T: Payload> {
    publisher: Publisher<SharedMemory, T>,
    /// Incarnation and epoch that it stands for; of many publishers, 0 in place of the incarnation.
    stands_for: (u64, u64),
}

impl<T: Payload> StandIn<T> {
    pub(crate) fn new(topic: Topic<T>) -> Self {
        Self {
            topic,
            open: None,
            next: BTreeMap::new(),
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
        let next = self.next.get(&header.incarnation).filter(|_| self.is_open_for(header));
        header
            .first_sequence
            .checked_sub(next.copied().unwrap_or(header.first_sequence))
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
        if !self.is_open_for(header) {
            // The one before is gone first: a topic has room for one and its successor.
            self.open = None;
            self.next.clear();
            let publisher = bus.publisher(&self.topic, now.mono_ns as u64)?;
            let publisher = publisher.of_sensor(header.sensor_uid).of_origin(origin);
            self.open = Some(Open {
                publisher: publisher.with_epoch(header.epoch).of_boot(header.boot()),
                stands_for: self.stands_for(header),
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
        if self.is_open_for(header) {
            let next = self.follow(header);
            *next = (*next).max(header.first_sequence + count as u64);
        }
    }

    /// Nothing has come of the other publisher before a slice with this header, or how far it is stays as it is: what
    /// came apart from the sequence makes nothing less missing.
    pub(crate) fn begin(&mut self, header: &BatchHeader) {
        if self.is_open_for(header) {
            self.follow(header);
        }
    }

    /// Number that comes next of the publisher of a slice with this header, which begins there if it is new.
    fn follow(&mut self, header: &BatchHeader) -> &mut u64 {
        if self.next.len() >= FOLLOWED_MAX && !self.next.contains_key(&header.incarnation) {
            // The oldest: incarnations are times.
            self.next.pop_first();
        }
        self.next.entry(header.incarnation).or_insert(header.first_sequence)
    }

    fn stands_for(&self, header: &BatchHeader) -> (u64, u64) {
        let is_of_many = self.topic.capacity.publishers > SUCCESSORS_MAX;
        (if is_of_many { 0 } else { header.incarnation }, header.epoch)
    }

    fn is_open_for(&self, header: &BatchHeader) -> bool {
        let stands_for = self.stands_for(header);
        self.open.as_ref().is_some_and(|open| open.stands_for == stands_for)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::Root;

    #[test]
    fn the_numbers_of_many_publishers_are_followed_one_by_one() {
        let folder = tempfile::tempdir().unwrap();
        let bus: Bus<SharedMemory> = Bus::open(&Root::in_base(folder.path(), "t").unwrap(), "test").unwrap();
        let _held = bus.hold(&messages::health()).unwrap();
        let mut stand_in = StandIn::new(messages::health());
        let mut take = |incarnation, first_sequence| {
            let header = BatchHeader {
                incarnation,
                first_sequence,
                ..BatchHeader::default()
            };
            let missing = stand_in.missing(&header);
            let now = Now { mono_ns: 1, utc_ns: 1 };
            let sample = [messages::Health::default()];
            stand_in.publish(&bus, (&header, 0), &sample, now, |_, _| {}).unwrap();
            stand_in.pass(&header, 1);
            missing
        };
        for sequence in 0..20 {
            assert_eq!(take(7, 100 + sequence), Some(0));
            assert_eq!(take(9, 5000 + sequence), Some(0));
        }
        assert_eq!(take(7, 125), Some(5), "a gap of one of them");
        assert_eq!(take(9, 5020), Some(0));
        assert_eq!(take(7, 125), None, "it repeats");
    }
}
