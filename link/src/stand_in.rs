//! A publisher here that stands for one on another host.
//!
//! Slices are published as in the other deployment: with the same samples, watermarks and sequence gaps, so that
//! local readers count losses. When the other publisher is replaced, the endpoint is replaced as well. A topic of
//! many publishers has a single endpoint, which follows the numbers of each publisher.

use std::collections::BTreeMap;

use anyhow::Context as _;
use bus::{Bus, Mark, Payload, Publisher, SharedMemory};
use messages::{BatchHeader, Topic};
use runtime::Now;

use crate::history::ReaderPosition;
use crate::inbound::{Arrival, InboundCounts};
use crate::stamps;
use crate::wire::{self, Head, SliceCopy};

/// Index of samples outside the sequence.
pub(crate) const UNNUMBERED: u64 = u64::MAX;
/// Largest number of publishers of a topic with a publisher and its successor; a topic with more has many publishers
/// at a time.
const SUCCESSORS_MAX: usize = 8;
/// Largest number of followed publishers of a topic.
const FOLLOWED_MAX: usize = 256;

/// Bridge endpoint: local publishers in the place of the successive publishers of another host's topic.
pub(crate) struct StandIn<T: Payload> {
    pub(crate) topic: Topic<T>,
    open: Option<Publisher<SharedMemory, T>>,
    pub(crate) numbers: PublisherNumbers,
    /// Samples omitted, as last stated by the sender.
    conflated: u64,
}

/// Numbers of the publishers elsewhere that a stand-in stands for.
#[derive(Debug)]
pub(crate) struct PublisherNumbers {
    /// Whether the topic is one of many publishers at a time.
    is_of_many: bool,
    /// Incarnation and epoch that the stand-in stands for; of many publishers, 0 in place of the incarnation.
    present: Option<(u64, u64)>,
    /// Number that comes next of each publisher there, by its incarnation.
    next: BTreeMap<u64, u64>,
}

impl PublisherNumbers {
    /// Of a topic that has so many publishers at most.
    fn new(publishers: usize) -> Self {
        Self {
            is_of_many: publishers > SUCCESSORS_MAX,
            present: None,
            next: BTreeMap::new(),
        }
    }

    fn identity(&self, header: &BatchHeader) -> (u64, u64) {
        (if self.is_of_many { 0 } else { header.incarnation }, header.epoch)
    }

    /// Whether the stand-in stands for the publisher of a slice with this header.
    fn is_of(&self, header: &BatchHeader) -> bool {
        self.present == Some(self.identity(header))
    }

    /// From now on the stand-in stands for the publisher of a slice with this header.
    fn turn_to(&mut self, header: &BatchHeader) {
        self.present = Some(self.identity(header));
        self.next.clear();
    }

    /// Returns the number of samples missing before a slice with this header; `None` for a repeated slice.
    pub(crate) fn missing(&self, header: &BatchHeader) -> Option<u64> {
        let next = self.next.get(&header.incarnation).filter(|_| self.is_of(header));
        let next = next.copied().unwrap_or(header.first_sequence);
        header.first_sequence.checked_sub(next)
    }

    /// Whether samples are missing before a slice with this header, or may be: the end of a publisher that another one
    /// has followed. Many publishers at a time have no order among each other, and no gap to fill.
    pub(crate) fn has_gap(&self, header: &BatchHeader) -> bool {
        let has_other = !self.is_of_many && self.present.is_some() && !self.is_of(header);
        has_other || (!self.is_of_many && self.missing(header).is_some_and(|missing| missing > 0))
    }

    /// How far the samples of the present publisher have come; `None` before the first, and of many at a time.
    pub(crate) fn position(&self) -> Option<ReaderPosition> {
        let (publisher, _) = self.present.filter(|_| !self.is_of_many)?;
        let next = *self.next.get(&publisher)?;
        Some(ReaderPosition { publisher, next })
    }

    /// Number that comes next of the publisher of a slice with this header, which begins there if it is new; `None` if
    /// the stand-in does not stand for it.
    fn follow(&mut self, header: &BatchHeader) -> Option<&mut u64> {
        if !self.is_of(header) {
            return None;
        }
        if self.next.len() >= FOLLOWED_MAX && !self.next.contains_key(&header.incarnation) {
            // The oldest: incarnations are times.
            self.next.pop_first();
        }
        Some(self.next.entry(header.incarnation).or_insert(header.first_sequence))
    }
}

impl<T: Payload> StandIn<T> {
    pub(crate) fn new(topic: Topic<T>) -> Self {
        Self {
            numbers: PublisherNumbers::new(topic.capacity.publishers),
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
        counts: &mut InboundCounts,
    ) -> Option<(Head, Vec<SliceCopy<R>>)> {
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
        }
        for sample in slices.iter_mut().flat_map(|(_, samples)| samples) {
            stamps::bring_here(sample, arrival.offset_ns, arrival.now);
        }
        Some((head, slices))
    }

    /// Returns the number of samples missing before a slice with this header; `None` for a repeated slice.
    pub(crate) fn missing(&self, header: &BatchHeader) -> Option<u64> {
        self.numbers.missing(header)
    }

    /// Publishes samples of a slice with this header, of the deployment with the number `origin`. `last` is called
    /// for each sample with its local number.
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
        if !self.numbers.is_of(header) {
            // The previous publisher is closed first: a topic has room for a publisher and its successor.
            self.open = None;
            let publisher = bus.publisher(&self.topic, now.mono_ns as u64)?;
            let publisher = publisher.of_sensor(header.sensor_uid).of_origin(origin);
            self.open = Some(publisher.with_epoch(header.epoch).of_boot(header.boot()));
            self.numbers.turn_to(header);
        }
        let publisher = self.open.as_mut().context("it was just opened")?;
        publisher.pass_over(missing);
        let mark = Mark {
            progress_ns: header.progress_ns,
            sent_ns: now.mono_ns,
            end: header.flags & BatchHeader::END != 0,
        };
        publisher.send(mark, samples.len(), |index, sequence| {
            let mut sample = samples[index];
            last(&mut sample, sequence);
            sample
        })?;
        Ok(())
    }

    /// All samples of the other publisher up to the end of a slice of so many have been published, or never will be.
    pub(crate) fn pass(&mut self, header: &BatchHeader, count: usize) {
        if let Some(next) = self.numbers.follow(header) {
            *next = (*next).max(header.first_sequence + count as u64);
        }
    }

    /// Sets the position of the other publisher before its first slice, or leaves a known position: samples outside
    /// the sequence do not close gaps.
    pub(crate) fn begin(&mut self, header: &BatchHeader) {
        self.numbers.follow(header);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes slices of one sample each, given by incarnation and number; returns the number missing before each.
    fn missing(publishers: usize, slices: &[(u64, u64)]) -> Vec<Option<u64>> {
        let mut numbers = PublisherNumbers::new(publishers);
        let take = |(incarnation, first_sequence): &(u64, u64)| {
            let header = BatchHeader {
                incarnation: *incarnation,
                first_sequence: *first_sequence,
                ..BatchHeader::default()
            };
            let missing = numbers.missing(&header);
            if !numbers.is_of(&header) {
                numbers.turn_to(&header);
            }
            if let Some(next) = numbers.follow(&header) {
                *next = (*next).max(first_sequence + 1);
            }
            missing
        };
        slices.iter().map(take).collect()
    }

    #[test]
    fn the_numbers_of_many_publishers_are_followed_one_by_one() {
        let slices = [(7, 100), (9, 5000), (7, 101), (9, 5001), (7, 107), (9, 5002), (7, 107)];
        let expected = [0, 0, 0, 0, 5, 0].map(Some);
        let found = missing(messages::health().capacity.publishers, &slices);
        assert_eq!((&found[..6], found[6]), (&expected[..], None), "the last one repeats");
    }

    #[test]
    fn a_publisher_and_its_successor_follow_one_another() {
        let slices = [(7, 100), (7, 103), (8, 0), (8, 1)];
        let found = missing(messages::system_tracks().capacity.publishers, &slices);
        assert_eq!(found, [0, 2, 0, 0].map(Some));
    }
}
