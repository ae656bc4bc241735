//! Subscriber: takes slices, and counts missing samples.
//!
//! Overflow in shared memory is silent: the oldest slice disappears. But every slice states how many samples the
//! publisher had sent before, so that a subscriber can expect the next number of each publisher. Skipped numbers are
//! lost; smaller numbers are out of order.
//!
//! The difficult case is the *first* expected number. Counting from 0 would count samples sent before the subscriber
//! existed; counting from the first taken slice would overlook an overflow before the first take. Publishers state the
//! time of the start, and the subscriber stores the time of the connection. Of a later publisher, all samples are
//! expected; of an older publisher, samples after the first taken slice. Limit: an overflow between the connection to
//! an older publisher and the first take is not detected; therefore take soon.
//!
//! A subscriber connects to a new publisher at the next check ([`Subscriber::take`], [`Subscriber::has_slices`]; a
//! waiter is woken). From then on, slices survive the publisher's end. But slices of a publisher that started and ended
//! between two checks are lost: a recorded source must remain until the readers have confirmed everything
//! (`messages::Progress`). Lost samples are counted in all cases, also samples that died with a killed publisher: each
//! publisher leaves a [line](crate::line) with the last number, and a subscriber with an empty queue reads the lines of
//! ended publishers.
//!
//! For a topic with *epochs* (see `messages::Epochs`), the latest received epoch is the present epoch: slices of
//! older epochs, of a replaced fusion process, are dropped and counted, unless requested.
//!
//! Slices of a publisher arrive in the order of sending. Between publishers there is no order, and all waiting slices
//! of a publisher precede the next publisher's: sources that must not displace each other have separate topics.

use std::marker::PhantomData;
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use iceoryx2::port::ReceiveError;
use iceoryx2::prelude::PayloadHeader as _;
use messages::{BatchHeader, Epochs, Topic};

use crate::error::BusError;
use crate::hint::Hint;
use crate::line::{Ends, PublisherLine, fold};
use crate::ports::{DropGuard, Receiving, Transport};
use crate::quality::BORROWED_MAX;
use crate::sends::{ReceivedSends, Word as _};
use crate::service::{SubscriberPort, TakenSlice};
use crate::transport::Payload;

/// No publisher gets as far as this number in a hundred years: a greater one is damaged, and sums with such a number
/// may overflow.
const SEQUENCE_MAX: u64 = u64::MAX >> 2;

/// Takes slices of samples `T` from a single topic.
#[derive(Debug)]
pub struct Subscriber<S: Transport, T: Payload> {
    port: Arc<DropGuard<SubscriberPort<S>>>,
    samples: PhantomData<fn() -> T>,
    topic: Arc<str>,
    slice_len: usize,
    joined_ns: u64,
    publishers: Publishers,
    ends: Option<Ends>,
    hint: Hint,
    received: ReceivedSends,
    counts: SubscriberCounts,
    /// Epoch of the latest slice.
    epochs: Epochs,
    takes_older: bool,
    failed_connections: Arc<AtomicU64>,
}

/// Outcome of [`Subscriber::receive`].
#[derive(Debug)]
pub enum ReceiveOutcome<S: Transport, T: Payload> {
    /// The next slice.
    Slice(Slice<S, T>),
    /// A slice of another layout, or a damaged slice: counted, and given back.
    Rejected,
    /// A slice of an older epoch: counted, and given back.
    OfOlderEpoch,
    /// The queue is empty.
    Nothing,
}

/// A slice in shared memory, kept from being overwritten during the life of this value, also without the subscriber.
#[derive(Debug)]
pub struct Slice<S: Transport, T: Payload> {
    taken: DropGuard<TakenSlice<S>>,
    /// A publisher takes back all slices of a port that is gone, kept slices included. Dropped after `taken`.
    _port: Arc<DropGuard<SubscriberPort<S>>>,
    /// The samples of `taken`. The count was read once: in shared memory the count may change.
    first: NonNull<T>,
    count: usize,
}

// SAFETY: the samples are numbers that nobody writes as long as `taken` lives, so a holder of `taken` may hold the
// samples. The port may be dropped here while the subscriber uses the port elsewhere.
unsafe impl<S: Transport, T: Payload> Send for Slice<S, T>
where
    DropGuard<TakenSlice<S>>: Send,
    Arc<DropGuard<SubscriberPort<S>>>: Send,
{
}

// SAFETY: likewise.
unsafe impl<S: Transport, T: Payload> Sync for Slice<S, T>
where
    DropGuard<TakenSlice<S>>: Sync,
    Arc<DropGuard<SubscriberPort<S>>>: Sync,
{
}

impl<S: Transport, T: Payload> Slice<S, T> {
    /// Of a topic whose slices have `slice_len` samples at most; `None` if the memory states more.
    #[inline]
    fn of(taken: DropGuard<TakenSlice<S>>, port: &Arc<DropGuard<SubscriberPort<S>>>, slice_len: usize) -> Option<Self> {
        let count = usize::try_from(taken.header().number_of_elements()).ok()?;
        (count <= slice_len).then(|| Self {
            first: NonNull::from(taken.payload()).cast(),
            count,
            taken,
            _port: Arc::clone(port),
        })
    }

    /// Header written by the publisher.
    pub fn header(&self) -> &BatchHeader {
        // SAFETY: the topic was opened with the size and alignment of a `BatchHeader` for this place, and any bits are
        // a valid header.
        unsafe { &*std::ptr::from_ref(self.taken.user_header()).cast() }
    }

    /// Samples of the slice.
    #[inline]
    pub fn samples(&self) -> &[T] {
        // SAFETY: the topic was opened with the size and alignment of `T`; the publishers of this crate reserve
        // `slice_len` samples for each slice, which are not fewer than `count`; any bits are a valid `T`.
        unsafe { NonNull::slice_from_raw_parts(self.first, self.count).as_ref() }
    }
}

/// Counts of a subscriber since creation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SubscriberCounts {
    /// Samples taken, samples of older epochs aside.
    pub taken: u64,
    /// Slices taken, empty slices included.
    pub slices: u64,
    /// Samples that are missing from the publishers' sequences: dropped because this subscriber fell behind, or lost
    /// with the publisher.
    pub lost: u64,
    /// Part of the lost samples that followed the last slice of an ended or killed publisher.
    pub lost_at_end: u64,
    /// Samples with a sequence number that had been passed already.
    pub out_of_order: u64,
    /// Samples dropped because of their origin in a fusion that has been replaced since.
    pub of_older_epochs: u64,
    /// Slices refused because of a publisher built with another layout, or a length or number that no publisher of the
    /// topic writes.
    pub schema_mismatch: u64,
    /// Times a connection to a publisher could not be made; others are not affected.
    pub failed_connections: u64,
}

/// A publisher with received slices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PublisherRecord {
    /// Start of the publisher, as stated by the publisher.
    pub incarnation: u64,
    /// Sequence number that must come next: all smaller numbers have been taken or are lost.
    pub next_sequence: u64,
}

impl<S: Transport, T: Payload> Subscriber<S, T> {
    pub(crate) fn new(opened: Receiving<S>, ends: Option<Ends>, hint: Hint, topic: &Topic<T>, joined_ns: u64) -> Self {
        Self {
            port: Arc::new(opened.port),
            samples: PhantomData,
            topic: topic.name.as_str().into(),
            slice_len: topic.capacity.slice_len,
            joined_ns,
            publishers: Publishers::with_room_for(topic.capacity.publishers),
            ends,
            hint,
            received: ReceivedSends::default(),
            counts: SubscriberCounts::default(),
            epochs: Epochs::default(),
            takes_older: false,
            failed_connections: opened.failed_connections,
        }
    }

    /// Includes slices of older epochs, for recorders and judges.
    #[must_use]
    pub fn of_all_epochs(mut self) -> Self {
        self.takes_older = true;
        self
    }

    /// Takes up to `budget` slices and passes each to `visit`, in each publisher's order. Returns the number of
    /// slices taken: fewer than `budget` means an empty queue.
    ///
    /// Slices of another layout or an older epoch count towards the budget, but are not shown.
    ///
    /// # Errors
    /// [`BusError::Take`] if the memory of a publisher cannot be reached. Slices taken before that were shown.
    pub fn take(&mut self, budget: usize, mut visit: impl FnMut(&BatchHeader, &[T])) -> Result<usize, BusError> {
        for count in 0..budget {
            match self.receive()? {
                ReceiveOutcome::Slice(slice) => visit(slice.header(), slice.samples()),
                ReceiveOutcome::Rejected | ReceiveOutcome::OfOlderEpoch => {}
                ReceiveOutcome::Nothing => return Ok(count),
            }
        }
        Ok(budget)
    }

    /// Takes the next slice out of the queue, for as long as the reader needs the slice: the memory is not reused
    /// before the slice is dropped. A subscriber can keep [`BORROWED_MAX`](crate::BORROWED_MAX) at a time.
    ///
    /// # Errors
    /// [`BusError::Borrowed`] if too many slices are kept; [`BusError::Take`] if the memory of a publisher cannot be
    /// reached.
    pub fn receive(&mut self) -> Result<ReceiveOutcome<S, T>, BusError> {
        let before = self.hint.word().value();
        let received = self.receive_any()?;
        self.received.note(before, received.is_none());
        let Some(sample) = received else {
            return Ok(ReceiveOutcome::Nothing);
        };
        let Some(slice) = Slice::<S, T>::of(sample, &self.port, self.slice_len).filter(|slice| {
            let header = slice.header();
            header.schema == T::SCHEMA && header.first_sequence <= SEQUENCE_MAX
        }) else {
            self.counts.schema_mismatch += 1;
            return Ok(ReceiveOutcome::Rejected);
        };
        let header = slice.header();
        let (count, standing) = (slice.count, self.epochs.compare(header));
        match self
            .publishers
            .follow(slice.taken.origin().value(), header, count, self.joined_ns)
        {
            Step::Next { skipped } => self.counts.lost = self.counts.lost.saturating_add(skipped),
            Step::Passed => self.counts.out_of_order += count as u64,
        }
        if standing.is_lt() && !self.takes_older {
            self.counts.of_older_epochs += count as u64;
            return Ok(ReceiveOutcome::OfOlderEpoch);
        }
        if standing.is_gt() {
            self.epochs.follow(header);
        }
        self.counts.slices += 1;
        self.counts.taken += count as u64;
        Ok(ReceiveOutcome::Slice(slice))
    }

    /// Returns the next slice. With an empty queue, the missing samples of ended publishers are counted as lost.
    fn receive_any(&mut self) -> Result<Option<DropGuard<TakenSlice<S>>>, BusError> {
        let topic = &self.topic;
        let failed = |error| match error {
            ReceiveError::ExceedsMaxBorrows => BusError::Borrowed {
                topic: topic.clone(),
                limit: BORROWED_MAX,
            },
            ReceiveError::ConnectionFailure(_) => BusError::Take {
                topic: topic.clone(),
                reason: "a publisher's memory cannot be reached",
            },
        };
        if let Some(slice) = S::receive(&self.port).map_err(failed)? {
            return Ok(Some(slice));
        }
        let Some(ends) = &mut self.ends else {
            return Ok(None);
        };
        if !ends.news() && !ends.are_waiting() {
            return Ok(None);
        }
        // Last slices of ended publishers may have arrived since the first check.
        let slice = S::receive(&self.port).map_err(failed)?;
        if slice.is_none() {
            ends.settle(|ended| {
                let lost = self.publishers.settle(ended, self.joined_ns);
                self.counts.lost = self.counts.lost.saturating_add(lost);
                self.counts.lost_at_end = self.counts.lost_at_end.saturating_add(lost);
            });
        }
        Ok(slice)
    }

    /// Returns whether a slice may wait: `false` if everything sent by publishers of this crate has been received.
    /// Costs one load. Publishers in other languages, and publishers killed during a send, give no hint: look fully at
    /// times all the same, and after each wake-up, until [`receive`](Self::receive) finds nothing.
    #[inline]
    pub fn may_have_slices(&self) -> bool {
        !self.received.are_all(self.hint.word())
    }

    /// From now on a slice may wait, whatever publishers hint, until [`receive`](Self::receive) finds nothing.
    #[inline]
    pub fn disregard_hints(&mut self) {
        self.received = ReceivedSends::default();
    }

    /// Returns whether a slice waits (or a take would return an error). Costs some hundred nanoseconds.
    pub fn has_slices(&self) -> bool {
        S::has_slices(&self.port)
    }

    /// Returns the known publishers, including dead publishers until their places are needed.
    pub fn heard(&self) -> impl Iterator<Item = PublisherRecord> + '_ {
        self.publishers.list.iter().map(|each| PublisherRecord {
            incarnation: each.incarnation,
            next_sequence: each.next_sequence,
        })
    }

    /// Name of the topic.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// Epoch of the latest slice; 0 before the first slice, and on topics without epochs.
    pub fn epoch(&self) -> u64 {
        self.epochs.epoch()
    }

    /// Counts so far.
    pub fn counts(&self) -> SubscriberCounts {
        SubscriberCounts {
            failed_connections: self.failed_connections.load(Ordering::Relaxed),
            ..self.counts
        }
    }
}

/// Where each publisher's sequence stands.
///
/// Twice as many as can live at a time: a place is given up only when its publisher has long been dead, in the order of
/// last slices.
#[derive(Debug)]
struct Publishers {
    list: Vec<FollowedPublisher>,
    room: usize,
    /// Index of the last slice's publisher: most often, the next slice is from the same publisher.
    recent: usize,
    /// Count of slices at the last slice; the smallest belongs to the oldest.
    age: u64,
}

#[derive(Debug)]
struct FollowedPublisher {
    /// iceoryx2's number of the port, unique on the machine.
    origin: u128,
    incarnation: u64,
    next_sequence: u64,
    last_age: u64,
}

/// Place of a slice in a publisher's sequence.
#[derive(Debug, PartialEq, Eq)]
enum Step {
    /// After the previous slice, perhaps with a gap.
    Next { skipped: u64 },
    /// Before a place that had been passed already.
    Passed,
}

impl Publishers {
    fn with_room_for(live: usize) -> Self {
        let room = 2 * live.max(1);
        Self {
            list: Vec::with_capacity(room),
            room,
            recent: 0,
            age: 0,
        }
    }

    fn follow(&mut self, origin: u128, header: &BatchHeader, count: usize, joined_ns: u64) -> Step {
        self.age += 1;
        let index = self.index_of(origin, header, joined_ns);
        self.recent = index;
        let publisher = &mut self.list[index];
        publisher.last_age = self.age;
        match header.first_sequence.checked_sub(publisher.next_sequence) {
            Some(skipped) => {
                publisher.next_sequence = header.first_sequence.saturating_add(count as u64);
                Step::Next { skipped }
            }
            None => Step::Passed,
        }
    }

    /// How many samples of a publisher that has ended never came, although expected.
    fn settle(&mut self, ended: &PublisherLine, joined_ns: u64) -> u64 {
        let matches =
            |each: &&mut FollowedPublisher| fold(each.origin) == ended.origin && each.incarnation == ended.incarnation;
        let mut none = 0;
        let next_sequence = match self.list.iter_mut().find(matches) {
            Some(followed) => &mut followed.next_sequence,
            None if ended.incarnation >= joined_ns => &mut none,
            None => return 0,
        };
        let lost = ended.next_sequence.saturating_sub(*next_sequence);
        *next_sequence += lost;
        lost
    }

    fn index_of(&mut self, origin: u128, header: &BatchHeader, joined_ns: u64) -> usize {
        let matches = |each: &FollowedPublisher| each.origin == origin && each.incarnation == header.incarnation;
        if self.list.get(self.recent).is_some_and(matches) {
            return self.recent;
        }
        if let Some(index) = self.list.iter().position(matches) {
            return index;
        }
        let started_later = header.incarnation >= joined_ns;
        let newcomer = FollowedPublisher {
            origin,
            incarnation: header.incarnation,
            next_sequence: if started_later { 0 } else { header.first_sequence },
            last_age: 0,
        };
        if self.list.len() < self.room {
            self.list.push(newcomer);
            return self.list.len() - 1;
        }
        let oldest = (0..self.room).min_by_key(|index| self.list[*index].last_age);
        let oldest = oldest.unwrap_or(0);
        self.list[oldest] = newcomer;
        oldest
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use messages::SensorTrack;

    use super::*;
    use crate::bus::Bus;
    use crate::mapping::Mapping;
    use crate::publisher::Mark;
    use crate::root::Root;
    use crate::seal::SHARED_MEMORY_DIR;
    use crate::transport::SharedMemory;

    fn header(incarnation: u64, first_sequence: u64) -> BatchHeader {
        BatchHeader {
            incarnation,
            first_sequence,
            ..BatchHeader::default()
        }
    }

    #[test]
    fn a_place_is_given_up_in_the_order_of_last_slices() {
        let mut publishers = Publishers::with_room_for(1);
        publishers.follow(1, &header(10, 0), 5, 0);
        publishers.follow(2, &header(20, 0), 5, 0);
        publishers.follow(1, &header(10, 5), 5, 0);
        publishers.follow(3, &header(30, 0), 5, 0);
        let heard: Vec<_> = publishers.list.iter().map(|each| each.origin).collect();
        assert_eq!(heard, [1, 3]);
        assert_eq!(publishers.follow(1, &header(10, 10), 1, 0), Step::Next { skipped: 0 });
    }

    #[test]
    fn repeated_numbers_are_passed_and_do_not_move_the_sequence_back() {
        let mut publishers = Publishers::with_room_for(1);
        publishers.follow(1, &header(10, 0), 5, 0);
        assert_eq!(publishers.follow(1, &header(10, 2), 2, 0), Step::Passed);
        assert_eq!(publishers.follow(1, &header(10, 7), 1, 0), Step::Next { skipped: 2 });
    }

    #[test]
    fn only_publishers_that_started_later_are_expected_from_their_first_sample() {
        let mut publishers = Publishers::with_room_for(2);
        assert_eq!(publishers.follow(1, &header(99, 7), 1, 100), Step::Next { skipped: 0 });
        assert_eq!(publishers.follow(2, &header(100, 7), 1, 100), Step::Next { skipped: 7 });
    }

    /// Words of a slice in front of the samples, counted from the first word of the header.
    const SLICE_COUNT: isize = -2;
    const FIRST_SEQUENCE: isize = 2;

    /// Writes a word of the slice that begins with number `first`, as a fault of the memory would.
    fn damage(root: &Root, first: u64, place: isize, word: u64) {
        let prefix = root.prefix().unwrap().unwrap();
        let mut found = 0;
        for entry in fs::read_dir(SHARED_MEMORY_DIR).unwrap().flatten() {
            if !entry.file_name().to_str().is_some_and(|name| name.starts_with(&prefix)) {
                continue;
            }
            let Ok(mapping) = Mapping::open(&entry.path()) else {
                continue;
            };
            let count = mapping.bytes() / size_of::<u64>();
            // SAFETY: the mapping is aligned to a page and has so many words, and any bits are a valid atomic word.
            let words: &[AtomicU64] = unsafe { std::slice::from_raw_parts(mapping.start().cast().as_ptr(), count) };
            let is = |place: usize, value| {
                words
                    .get(place)
                    .is_some_and(|word| word.load(Ordering::Relaxed) == value)
            };
            let is_header = |schema: &usize| {
                is(*schema, <SensorTrack as messages::layout::Sample>::SCHEMA)
                    && is(*schema + FIRST_SEQUENCE as usize, first)
            };
            for header in (0..count).filter(is_header) {
                words[header.checked_add_signed(place).unwrap()].store(word, Ordering::Relaxed);
                found += 1;
            }
        }
        assert_eq!(found, 1, "not the slice");
    }

    #[test]
    fn a_slice_of_absurd_length_or_number_is_counted_and_refused() {
        const SAMPLES: usize = 11;
        let folder = tempfile::tempdir().unwrap();
        let root = Root::in_base(folder.path(), "damaged").unwrap();
        let claim = root.claim().unwrap();
        let bus: Bus<SharedMemory> = Bus::open(&root, "test").unwrap();
        let topic = messages::sensor_tracks("a");
        let held = bus.hold(&topic).unwrap();
        let mut subscriber = bus.subscriber(&topic, || 0).unwrap();
        let mut publisher = bus.publisher(&topic, 1).unwrap();
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: 0,
            end: false,
        };
        let (samples, longest) = (SAMPLES as u64, topic.capacity.slice_len as u64);
        let absurd = [longest + 1, samples ^ 1 << 20, samples ^ 1 << 58, 1 << 63, u64::MAX];
        let mut next = 0;
        for (place, is_length) in [(SLICE_COUNT, true), (FIRST_SEQUENCE, false)] {
            for word in absurd.into_iter().filter(|word| is_length || *word > SEQUENCE_MAX) {
                // An intact slice, so that no number is missing when the damaged slice is.
                for is_damaged in [false, true] {
                    publisher.send(mark, SAMPLES, |_, _| SensorTrack::default()).unwrap();
                    if is_damaged {
                        damage(&root, next, place, word);
                    }
                    next += samples;
                    let before = subscriber.counts();
                    let mut taken = 0;
                    assert_eq!(subscriber.take(2, |_, samples| taken += samples.len()).unwrap(), 1);
                    let refused = subscriber.counts().schema_mismatch - before.schema_mismatch;
                    assert_eq!((taken, refused), if is_damaged { (0, 1) } else { (SAMPLES, 0) });
                }
            }
        }
        let counts = subscriber.counts();
        assert_eq!(
            counts.lost + counts.taken,
            next - samples,
            "the last refused slice is not missed yet"
        );
        drop((publisher, subscriber, held, bus));
        claim.remove().unwrap();
    }

    #[test]
    fn absurd_numbers_of_ended_publishers_are_counted() {
        let mut publishers = Publishers::with_room_for(1);
        assert_eq!(publishers.follow(1, &header(10, 0), 5, 0), Step::Next { skipped: 0 });
        let ended = PublisherLine {
            incarnation: 10,
            next_sequence: u64::MAX,
            heartbeat_ns: i64::MIN,
            life: crate::line::PublisherState::Died,
            origin: fold(1),
            schema: 0,
            check: 1,
        };
        assert_eq!(publishers.settle(&ended, 0), u64::MAX - 5);
        assert_eq!(publishers.settle(&ended, 0), 0);
        assert_eq!(
            publishers.follow(1, &header(10, u64::MAX), 5, 0),
            Step::Next { skipped: 0 }
        );
    }
}
