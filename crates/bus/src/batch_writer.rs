//! Writer of batches: samples are collected in the slice that is sent next.
//!
//! The obvious way collects samples in a list, and loans a slice once the list is complete. Then a loan of some 900
//! instructions, and a second copy of each sample, stand between the last sample and the subscribers. Here the next
//! slice is loaned after a send, when no process waits, and each sample is written once, to the final place in the
//! slice.
//!
//! A slice has the length of the loan, and the length of the next batch is unknown. So the next slice is as long as the
//! previous batch: a steady stream has batches of equal length. A batch of another length is copied into a slice of
//! that length.

use crate::error::BusError;
use crate::loaned::LoanedSlice;
use crate::ports::Transport;
use crate::publisher::{Mark, Publisher};
use crate::transport::Payload;

/// Collects samples, and sends the batch as a single slice (as several, if the slice has too few places).
#[derive(Debug)]
pub struct BatchWriter<S: Transport, T: Payload> {
    /// The slice that was loaned ahead, if any.
    next: LoanedSlice<S, T>,
    /// Samples beyond the places of that slice.
    rest: Vec<T>,
    publisher: Publisher<S, T>,
}

impl<S: Transport, T: Payload> BatchWriter<S, T> {
    /// Creates a writer for `publisher`. Up to `room` samples of a batch need no further memory.
    pub fn new(publisher: Publisher<S, T>, room: usize) -> Self {
        Self {
            next: LoanedSlice::none(),
            rest: Vec::with_capacity(room),
            publisher,
        }
    }

    /// Returns the publisher.
    pub fn publisher(&self) -> &Publisher<S, T> {
        &self.publisher
    }

    /// Returns the publisher, to change the statements in every slice.
    pub fn publisher_mut(&mut self) -> &mut Publisher<S, T> {
        &mut self.publisher
    }

    /// Adds a sample to the batch.
    #[inline]
    pub fn push(&mut self, sample: &T) {
        if !self.rest.is_empty() || !self.next.push(sample) {
            self.push_to_rest(sample);
        }
    }

    #[inline(never)]
    fn push_to_rest(&mut self, sample: &T) {
        self.rest.push(*sample);
    }

    /// Number of samples in the batch.
    #[inline]
    pub fn len(&self) -> usize {
        self.next.len() + self.rest.len()
    }

    /// Whether the batch is empty.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sends the batch, also an empty batch: see [`Publisher::send`]. Each sample passes `finish` beside the sequence
    /// number. Afterwards the next slice is loaned.
    ///
    /// # Errors
    /// As [`Publisher::send`]. The batch is given up.
    #[inline]
    pub fn send(&mut self, mark: Mark, finish: impl FnMut(&mut T, u64)) -> Result<(), BusError> {
        if !self.rest.is_empty() || !self.next.is_full() {
            return self.send_copied(mark, finish);
        }
        let length = self.next.len();
        let result = self.publisher.send_written(mark, &mut self.next, finish);
        self.loan_ahead(length);
        result
    }

    /// Wakes readers that came lately and are of another language. To be called at times, and before a sleep.
    #[inline]
    pub fn settle(&mut self) {
        self.publisher.settle();
    }

    #[inline]
    fn loan_ahead(&mut self, length: usize) {
        // Without a slice, the next batch is copied, and that send returns the error.
        let _ = self.publisher.loan(&mut self.next, length);
    }

    /// Sends a batch of another length than that of the loaned slice.
    #[inline(never)]
    fn send_copied(&mut self, mark: Mark, mut finish: impl FnMut(&mut T, u64)) -> Result<(), BusError> {
        let count = self.len();
        let (written, rest) = (self.next.written(), &self.rest);
        let result = self.publisher.send(mark, count, |index, sequence| {
            let mut sample = written
                .get(index)
                .copied()
                .unwrap_or_else(|| rest[index - written.len()]);
            finish(&mut sample, sequence);
            sample
        });
        self.rest.clear();
        self.next.empty();
        let length = count.min(self.publisher.slice_len());
        if length > 0 && length != self.next.places() {
            self.loan_ahead(length);
        }
        result
    }
}

impl<S: Transport, T: Payload> Drop for BatchWriter<S, T> {
    /// The last slice of a topic often announces the end: a reader must not sleep past this slice.
    fn drop(&mut self) {
        self.settle();
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use messages::SensorTrack;

    use super::*;
    use crate::bus::Bus;
    use crate::root::Root;
    use crate::transport::InProcess;
    use crate::waiter::WaitMode;

    fn mark(sent_ns: i64) -> Mark {
        Mark {
            progress_ns: i64::MIN,
            sent_ns,
            end: false,
        }
    }

    fn track(number: u32) -> SensorTrack {
        SensorTrack {
            track_number: number,
            ..SensorTrack::default()
        }
    }

    fn bus(folder: &tempfile::TempDir) -> Bus<InProcess> {
        Bus::open(&Root::in_base(folder.path(), "written").unwrap(), "test").unwrap()
    }

    #[test]
    fn batches_of_any_length_arrive_whole_in_order_and_finished() {
        let folder = tempfile::tempdir().unwrap();
        let bus = bus(&folder);
        let topic = messages::sensor_tracks("a");
        let _held = bus.hold(&topic).unwrap();
        let mut subscriber = bus.subscriber(&topic, || 0).unwrap();
        let mut writer = BatchWriter::new(bus.publisher(&topic, 1).unwrap(), 200);
        let mut number = 0;
        // Equal lengths are written in place; others, and more than a slice has places for, are copied.
        for length in [1, 1, 3, 3, 0, 2, 2, 150, 150, 1, 0, 1] {
            let first = number;
            for _ in 0..length {
                writer.push(&track(number));
                number += 1;
            }
            assert_eq!((writer.len(), writer.is_empty()), (length, length == 0));
            writer
                .send(mark(5), |track, sequence| track.sequence = 1000 + sequence)
                .unwrap();
            assert!(writer.is_empty());
            let mut arrived = Vec::new();
            let slices = subscriber
                .take(9, |header, tracks| {
                    assert_eq!((header.sent_ns, header.incarnation), (5, 1));
                    arrived.extend(tracks.iter().map(|track| (track.track_number, track.sequence)));
                })
                .unwrap();
            assert_eq!(slices, length.div_ceil(topic.capacity.slice_len).max(1));
            let sent = (first..number).map(|number| (number, 1000 + u64::from(number)));
            assert!(arrived.into_iter().eq(sent), "{length} from {first}");
        }
        let counts = writer.publisher().counts();
        assert_eq!((counts.samples, counts.not_sent), (u64::from(number), 0));
        assert_eq!(subscriber.counts().lost, 0);
    }

    #[test]
    fn a_slice_loaned_ahead_takes_no_place_of_those_that_readers_keep() {
        let folder = tempfile::tempdir().unwrap();
        let bus = bus(&folder);
        let topic = messages::sensor_tracks("a");
        let _held = bus.hold(&topic).unwrap();
        let _stopped: Vec<_> = (0..topic.capacity.subscribers)
            .map(|_| bus.subscriber(&topic, || 0).unwrap())
            .collect();
        let mut writer = BatchWriter::new(bus.publisher(&topic, 1).unwrap(), 1);
        for number in 0..3 * topic.capacity.depth as u32 {
            for _ in 0..1 + number % 7 / 6 {
                writer.push(&track(number));
            }
            writer.send(mark(0), |_, _| ()).unwrap();
        }
        assert_eq!(writer.publisher().counts().not_sent, 0);
    }

    #[test]
    fn a_listener_of_this_crate_is_woken_at_once_and_a_foreign_one_when_the_writer_settles() {
        let folder = tempfile::tempdir().unwrap();
        let bus = bus(&folder);
        let topic = messages::sensor_tracks("a");
        let _held = bus.hold(&topic).unwrap();
        let mut writer = BatchWriter::new(bus.publisher(&topic, 1).unwrap(), 1);
        let send = |writer: &mut BatchWriter<InProcess, SensorTrack>| {
            writer.push(&track(1));
            writer.send(mark(0), |_, _| ()).unwrap();
        };
        // The first batch is copied; the others find no listener, and record this.
        (0..3).for_each(|_| send(&mut writer));
        let name = iceoryx2::prelude::ServiceName::new(topic.name.as_str()).unwrap();
        let events = bus.node().service_builder(&name).event().open().unwrap();
        let foreign = events.listener_builder().create().unwrap();
        let notified = || foreign.try_wait(|_| ()).unwrap() > 0;
        send(&mut writer);
        assert!(!notified());
        writer.settle();
        assert!(notified());
        writer.settle();
        assert!(!notified(), "once");
        drop(foreign);
        // Again nobody, by the clock of the slices a while later.
        writer.push(&track(1));
        writer.send(mark(1_000_000_000), |_, _| ()).unwrap();
        let mut waiter = bus.waiter(WaitMode::Event);
        waiter.watch(&bus, &topic).unwrap();
        writer.push(&track(1));
        writer.send(mark(1_000_000_000), |_, _| ()).unwrap();
        let mut looks = 0;
        let day = Duration::from_secs(86_400);
        waiter
            .wait(day, || {
                looks += 1;
                looks > 1
            })
            .unwrap();
        assert_eq!(waiter.missed_wake_ups(), 0);
    }

    #[test]
    fn a_foreign_listener_that_came_lately_is_woken_for_the_last_slice() {
        let folder = tempfile::tempdir().unwrap();
        let bus = bus(&folder);
        let topic = messages::sensor_tracks("a");
        let _held = bus.hold(&topic).unwrap();
        let mut writer = BatchWriter::new(bus.publisher(&topic, 1).unwrap(), 1);
        // The first batch is copied; the second finds no listener, and records this.
        for number in 0..2 {
            writer.push(&track(number));
            writer.send(mark(0), |_, _| ()).unwrap();
        }
        let name = iceoryx2::prelude::ServiceName::new(topic.name.as_str()).unwrap();
        let events = bus.node().service_builder(&name).event().open().unwrap();
        let foreign = events.listener_builder().create().unwrap();
        let end = Mark { end: true, ..mark(0) };
        writer.push(&track(2));
        writer.send(end, |_, _| ()).unwrap();
        assert_eq!(foreign.try_wait(|_| ()).unwrap(), 0);
        drop(writer);
        assert!(foreign.try_wait(|_| ()).unwrap() > 0);
    }
}
