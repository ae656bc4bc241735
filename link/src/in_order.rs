//! Topics published without gaps, as far as the sender still has the lost samples.
//!
//! A gap in the sequence numbers indicates an interrupted connection. Samples after the gap are held, and the missing
//! samples are requested from the sender ([`history`](crate::history)). After the answer, or without an answer in
//! time, the held samples are published; samples still missing count as lost.
//!
//! An answer may hold a minute of reports. Readers here have short queues: a recovery publishes full slices, and pauses
//! after each [`BURST_SLICES`] slices or [`BURST_SAMPLES`] samples.

use std::collections::VecDeque;
use std::thread;
use std::time::Duration;

use bus::{Bus, Payload, SharedMemory};
use messages::BatchHeader;
use runtime::Now;

use crate::inbound::{Arrival, InboundCounts, Inlet, Question, WAITING_OCTETS};
use crate::stand_in::PublisherNumbers;
use crate::wire::{Head, SliceCopy};

/// Largest number of requests for a gap without an answer.
const QUESTIONS_MAX: u32 = 4;
/// Time after a recovery in which samples may come twice: once in the answer and once on their own, nanoseconds.
const TWICE_NS: i64 = 10_000_000_000;

/// Slices that a recovery publishes without a pause: a quarter of the shortest queue of a source's reader.
const BURST_SLICES: usize = 64;
/// Samples that a recovery publishes without a pause: with the pause, 50,000 a second.
const BURST_SAMPLES: usize = 512;
/// Pause of a recovery between two bursts.
const PAUSE: Duration = Duration::from_millis(10);

/// Publishes slices of one topic here.
pub(crate) trait SlicePublisher {
    /// Type of the samples that come.
    type Came: Payload;

    /// Reads a message; `None` if it is none, which is counted.
    fn read(&mut self, arrival: &Arrival<'_>, counts: &mut InboundCounts)
    -> Option<(Head, Vec<SliceCopy<Self::Came>>)>;

    /// The numbers of the publishers elsewhere.
    fn numbers(&self) -> &PublisherNumbers;

    /// Maximum number of samples in a slice of the topic here.
    fn slice_len(&self) -> usize;

    /// Publishes a slice that comes next, or after a gap.
    ///
    /// # Errors
    /// If shared memory fails.
    fn publish(
        &mut self,
        bus: &Bus<SharedMemory>,
        now: Now,
        came: (&Head, &SliceCopy<Self::Came>),
        counts: &mut InboundCounts,
    ) -> anyhow::Result<()>;
}

/// A topic with repair of gaps.
pub(crate) struct InOrder<O: SlicePublisher> {
    outlet: O,
    /// Key at which the sender answers; `None`: the topic has no history, since newer samples replace older ones.
    key: Option<String>,
    /// Slices after a gap, in their order; empty unless a gap is open.
    held: VecDeque<(Head, SliceCopy<O::Came>)>,
    held_bytes: usize,
    /// Questions asked about the open gap.
    questions: u32,
    /// Whether the answer to the latest of them may still come.
    is_asked: bool,
    has_answer: bool,
    /// When the latest gap was closed, monotonic, nanoseconds.
    closed_ns: i64,
    /// Slices and samples that the recovery has published since its last pause.
    burst: (usize, usize),
}

impl<O: SlicePublisher> InOrder<O> {
    pub(crate) fn new(outlet: O, key: Option<String>) -> Self {
        Self {
            outlet,
            key,
            held: VecDeque::new(),
            held_bytes: 0,
            questions: 0,
            is_asked: false,
            has_answer: false,
            closed_ns: i64::MIN,
            burst: (0, 0),
        }
    }

    fn hold(&mut self, head: &Head, slice: SliceCopy<O::Came>) {
        self.held_bytes += size_of_val(&slice) + size_of_val(&slice.1[..]);
        self.held.push_back((*head, slice));
    }

    fn publish(
        &mut self,
        arrival: &Arrival<'_>,
        (head, slice): (&Head, &SliceCopy<O::Came>),
        counts: &mut InboundCounts,
    ) -> anyhow::Result<()> {
        match self.outlet.numbers().missing(&slice.0) {
            Some(missing) => {
                counts.missing += missing;
                counts.came += slice.1.len() as u64;
                self.outlet.publish(arrival.bus, arrival.now, (head, slice), counts)
            }
            None => {
                let is_recovering = !self.held.is_empty() || arrival.is_answer;
                let may_repeat = is_recovering || arrival.now.mono_ns.saturating_sub(self.closed_ns) < TWICE_NS;
                counts.rejected += u64::from(!may_repeat);
                Ok(())
            }
        }
    }

    /// Publishes the held samples, after the answer or without hope of an answer.
    fn close(&mut self, arrival: &Arrival<'_>, counts: &mut InboundCounts) -> anyhow::Result<()> {
        self.closed_ns = arrival.now.mono_ns;
        (self.held_bytes, self.questions, self.is_asked, self.has_answer) = (0, 0, false, false);
        let held = std::mem::take(&mut self.held);
        self.recover(arrival, held, counts)
    }

    /// Publishes slices of the past in full slices, at a rate that readers can follow.
    fn recover(
        &mut self,
        arrival: &Arrival<'_>,
        slices: impl IntoIterator<Item = (Head, SliceCopy<O::Came>)>,
        counts: &mut InboundCounts,
    ) -> anyhow::Result<()> {
        let mut full: Option<(Head, SliceCopy<O::Came>)> = None;
        for (head, slice) in slices {
            if let Some((of, slices)) = &mut full {
                if (of.frame, of.origin) == (head.frame, head.origin)
                    && is_joined(slices, &slice, self.outlet.slice_len())
                {
                    join(slices, slice);
                    continue;
                }
                let (of, slices) = full.take().expect("it was just there");
                self.publish_paced(arrival, (&of, &slices), counts)?;
            }
            match self.outlet.numbers().missing(&slice.0) {
                // A repeated slice is rejected alone: a slice after it may be new.
                None => self.publish(arrival, (&head, &slice), counts)?,
                Some(_) => full = Some((head, slice)),
            }
        }
        full.map_or(Ok(()), |(head, slice)| {
            self.publish_paced(arrival, (&head, &slice), counts)
        })
    }

    fn publish_paced(
        &mut self,
        arrival: &Arrival<'_>,
        came: (&Head, &SliceCopy<O::Came>),
        counts: &mut InboundCounts,
    ) -> anyhow::Result<()> {
        let (slices, samples) = self.burst;
        self.burst = (slices + 1, samples + came.1.1.len());
        if self.burst.0 > BURST_SLICES || self.burst.1 > BURST_SAMPLES {
            thread::sleep(PAUSE);
            self.burst = (1, came.1.1.len());
        }
        self.publish(arrival, came, counts)
    }
}

/// Whether `next` continues `slice` and both fit in a slice of `slice_len` samples.
fn is_joined<T>((header, samples): &SliceCopy<T>, next: &SliceCopy<T>, slice_len: usize) -> bool {
    let of = |header: &BatchHeader| (header.incarnation, header.epoch, header.boot(), header.sensor_uid);
    of(header) == of(&next.0)
        && header.flags & BatchHeader::END == 0
        && header.first_sequence + samples.len() as u64 == next.0.first_sequence
        && samples.len() + next.1.len() <= slice_len
}

/// Appends `next` to `slice`; the progress of the joined slice is that of `next`.
fn join<T>((header, samples): &mut SliceCopy<T>, (next, more): SliceCopy<T>) {
    *header = BatchHeader {
        first_sequence: header.first_sequence,
        ..next
    };
    samples.extend(more);
}

impl<O: SlicePublisher> Inlet for InOrder<O> {
    fn take(&mut self, arrival: Arrival<'_>, counts: &mut InboundCounts) -> anyhow::Result<()> {
        let Some((head, slices)) = self.outlet.read(&arrival, counts) else {
            return Ok(());
        };
        if arrival.is_answer {
            self.has_answer = true;
            return self.recover(&arrival, slices.into_iter().map(|slice| (head, slice)), counts);
        }
        for slice in slices {
            let has_gap = || self.key.is_some() && self.outlet.numbers().has_gap(&slice.0);
            match !self.held.is_empty() || has_gap() {
                true => self.hold(&head, slice),
                false => self.publish(&arrival, (&head, &slice), counts)?,
            }
        }
        match self.held_bytes > WAITING_OCTETS {
            true => self.close(&arrival, counts),
            false => Ok(()),
        }
    }

    fn lacks(&self) -> Option<Question> {
        let is_due = !self.held.is_empty() && !self.is_asked;
        let key = self.key.clone().filter(|_| is_due)?;
        let payload = self.outlet.numbers().position()?.to_bytes();
        Some(Question { key, payload })
    }

    fn asked(&mut self) {
        self.is_asked = true;
        self.questions += 1;
    }

    fn answered(&mut self, arrival: Arrival<'_>, counts: &mut InboundCounts) -> anyhow::Result<()> {
        self.is_asked = false;
        if !self.held.is_empty() && (self.has_answer || self.questions >= QUESTIONS_MAX) {
            return self.close(&arrival, counts);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slice(first_sequence: u64, count: usize) -> SliceCopy<u8> {
        let header = BatchHeader {
            first_sequence,
            progress_ns: first_sequence.cast_signed(),
            ..BatchHeader::default()
        };
        (header, vec![0; count])
    }

    #[test]
    fn slices_without_a_gap_are_joined_up_to_the_length_of_a_slice() {
        let mut joined = slice(5, 3);
        assert!(is_joined(&joined, &slice(8, 5), 8));
        assert!(!is_joined(&joined, &slice(8, 6), 8), "too long");
        assert!(!is_joined(&joined, &slice(9, 1), 8), "a gap");
        assert!(!is_joined(&joined, &slice(7, 1), 8), "repeated");
        let mut successor = slice(8, 1);
        successor.0.incarnation = 1;
        assert!(!is_joined(&joined, &successor, 8), "another publisher");
        join(&mut joined, slice(8, 5));
        assert_eq!(
            (joined.0.first_sequence, joined.0.progress_ns, joined.1.len()),
            (5, 8, 8)
        );
        joined.0.flags |= BatchHeader::END;
        assert!(!is_joined(&joined, &slice(13, 1), 64), "after the end");
    }
}
