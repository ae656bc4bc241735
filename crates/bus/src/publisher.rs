//! Publisher: sends slices on a topic.
//!
//! A publisher writes samples directly into shared memory, numbers the samples, and never waits: a full subscriber
//! loses its oldest slice, and detects the loss by the numbers ([`BatchHeader`]).
//!
//! Progress marks need care where a send is longer than a slice. "No later sample is older than this" is true of the
//! last slice only: the samples of the other slices are still followed by some of the same send. So all slices but the
//! last repeat the mark of the previous send, and only the last slice can end the source.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use messages::{BatchHeader, Topic};

use crate::error::BusError;
use crate::hint::Hint;
use crate::line::OwnLine;
use crate::loaned::LoanedSlice;
use crate::ports::{DropGuard, Sending, Transport};
use crate::sends::Word as _;
use crate::service::{PublisherPort, Slices};
use crate::transport::Payload;
use crate::wake_up::WakeUp;

/// Sends slices of samples `T` on a single topic.
#[derive(Debug)]
pub struct Publisher<S: Transport, T: Payload> {
    port: DropGuard<PublisherPort<S>>,
    slices: DropGuard<Slices<S>>,
    wake_up: WakeUp<S>,
    /// Dropped after the port: when the line is marked as ended, no further slice enters the queue.
    line: Option<OwnLine>,
    hint: Hint,
    samples: PhantomData<fn(T)>,
    topic: Arc<str>,
    slice_len: usize,
    /// Header of the next slice. The progress mark is the mark of the previous send.
    header: BatchHeader,
    counts: PublisherCounts,
    failed_connections: Arc<AtomicU64>,
}

/// Statements of a send besides the samples: see [`BatchHeader`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// No sample of a later send will have a time of measurement before this (UTC, ns); `i64::MIN` if unknown.
    pub progress_ns: i64,
    /// Monotonic time of the send, nanoseconds.
    pub sent_ns: i64,
    /// The source has ended, and nothing follows.
    pub end: bool,
}

/// Counts of a publisher since creation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PublisherCounts {
    /// Samples sent.
    pub samples: u64,
    /// Slices sent, empty slices included.
    pub slices: u64,
    /// Samples that could not be sent; subscribers count such samples as lost.
    pub not_sent: u64,
    /// Times a connection to a subscriber could not be made or was found damaged; others are not affected.
    pub failed_connections: u64,
}

impl<S: Transport, T: Payload> Publisher<S, T> {
    pub(crate) fn new(
        opened: Sending<S>,
        line: Option<OwnLine>,
        hint: Hint,
        topic: &Topic<T>,
        incarnation: u64,
    ) -> Self {
        Self {
            port: opened.port,
            slices: opened.slices,
            wake_up: WakeUp::new(opened.wake_ups),
            line,
            hint,
            samples: PhantomData,
            topic: topic.name.as_str().into(),
            slice_len: topic.capacity.slice_len,
            header: BatchHeader {
                schema: T::SCHEMA,
                incarnation,
                progress_ns: i64::MIN,
                ..BatchHeader::default()
            },
            counts: PublisherCounts::default(),
            failed_connections: opened.failed_connections,
        }
    }

    /// This publisher, stating in every slice the start-up number of fusion.
    #[must_use]
    pub fn with_epoch(mut self, epoch: u64) -> Self {
        self.header.epoch = epoch;
        self
    }

    /// This publisher, stating in every slice the identity of the boot of the machine from which the samples come.
    #[must_use]
    pub fn of_boot(mut self, boot: u16) -> Self {
        let flags = self.header.flags & !(u32::from(u16::MAX) << BatchHeader::BOOT_SHIFT);
        self.header.flags = flags | u32::from(boot) << BatchHeader::BOOT_SHIFT;
        self
    }

    /// States in every later slice that this epoch of fusion continues the tracks of the previous epoch.
    pub fn go_on(&mut self) {
        self.header.flags |= BatchHeader::GOES_ON;
    }

    /// States in every slice from now on the offset of the source's clock: see [`BatchHeader::clock_offset_ms`].
    pub fn set_clock_offset(&mut self, offset_ms: i32) {
        self.header.clock_offset_ms = offset_ms;
    }

    /// The start-up number of fusion that this publisher states; 0 if the publisher is no fusion.
    pub fn epoch(&self) -> u64 {
        self.header.epoch
    }

    /// This publisher, stating in every slice the identity of the sensor from which the samples come.
    #[must_use]
    pub fn of_sensor(mut self, sensor_uid: u32) -> Self {
        self.header.sensor_uid = sensor_uid;
        self
    }

    /// Returns this publisher, with the number of the samples' original deployment in every slice.
    #[must_use]
    pub fn of_origin(mut self, origin: u32) -> Self {
        self.header.origin = origin;
        self
    }

    /// Sends `count` samples in as many slices as needed; for 0 samples, an empty slice with the watermark.
    ///
    /// `fill` is called once per sample, in order, with the index in this send (from 0) and the sequence number; the
    /// result is written to the place read by subscribers. Waiting subscribers are woken.
    ///
    /// # Errors
    /// [`BusError::Send`] if a slice could not be sent; all slices before that slice were. The samples that were not
    /// sent are counted here, keep the numbers, and so are counted as lost by subscribers. Sending may be tried again.
    pub fn send(&mut self, mark: Mark, count: usize, mut fill: impl FnMut(usize, u64) -> T) -> Result<(), BusError> {
        self.number(count);
        let mut done = 0;
        loop {
            let length = (count - done).min(self.slice_len);
            let last = done + length == count;
            let first_sequence = self.header.first_sequence;
            let fill_one = |index| fill(done + index, first_sequence + index as u64);
            if let Err(reason) = self.send_slice(self.header_of(&mark, last), length, fill_one) {
                return Err(self.give_up(count - done, reason));
            }
            self.count_slice(length);
            done += length;
            if last {
                self.end_send(&mark);
                return Ok(());
            }
        }
    }

    /// Sends a slice that has been written ahead, as a whole send. Each sample passes `finish` beside the sequence
    /// number. To be [settled](Self::settle).
    ///
    /// # Errors
    /// As [`send`](Self::send).
    #[inline]
    pub(crate) fn send_written(
        &mut self,
        mark: Mark,
        slice: &mut LoanedSlice<S, T>,
        mut finish: impl FnMut(&mut T, u64),
    ) -> Result<(), BusError> {
        let count = slice.len();
        self.number(count);
        for (sequence, sample) in (self.header.first_sequence..).zip(slice.written()) {
            finish(sample, sequence);
        }
        if let Err(reason) = slice.send(&self.header_of(&mark, true)) {
            return Err(self.give_up(count, reason));
        }
        self.hint.word().raise();
        self.wake_up.wake_at(&self.hint, mark.sent_ns);
        self.count_slice(count);
        self.end_send(&mark);
        Ok(())
    }

    /// Wakes readers that came lately and are of another language: to be called when there is nothing to send.
    #[inline]
    pub(crate) fn settle(&mut self) {
        self.wake_up.settle();
    }

    /// Loans a slice of `length` samples.
    ///
    /// # Errors
    /// Why there is none.
    #[inline]
    pub(crate) fn loan(&self, slice: &mut LoanedSlice<S, T>, length: usize) -> Result<(), &'static str> {
        slice.loan(&self.port, length)
    }

    /// States in the line, before a send, that the next `count` numbers are given to samples.
    #[inline]
    fn number(&self, count: usize) {
        if let Some(line) = &self.line {
            line.number(self.header.first_sequence + count as u64);
        }
    }

    /// Header of the next slice; the `last` slice of a send has the send's mark.
    #[inline]
    fn header_of(&self, mark: &Mark, last: bool) -> BatchHeader {
        BatchHeader {
            progress_ns: if last {
                mark.progress_ns
            } else {
                self.header.progress_ns
            },
            sent_ns: mark.sent_ns,
            flags: self.header.flags | if last && mark.end { BatchHeader::END } else { 0 },
            ..self.header
        }
    }

    #[inline]
    fn count_slice(&mut self, length: usize) {
        self.header.first_sequence += length as u64;
        self.counts.samples += length as u64;
        self.counts.slices += 1;
    }

    #[inline]
    fn end_send(&mut self, mark: &Mark) {
        self.header.progress_ns = mark.progress_ns;
        if let Some(line) = &self.line {
            line.beat(mark.sent_ns);
        }
    }

    /// Gives up the last `samples` of a send.
    #[cold]
    fn give_up(&mut self, samples: usize, reason: &'static str) -> BusError {
        self.header.first_sequence += samples as u64;
        self.counts.not_sent += samples as u64;
        BusError::Send {
            topic: self.topic.clone(),
            samples,
            reason,
        }
    }

    /// Passes over the next `count` sequence numbers: of samples that were lost upstream, which subscribers count as
    /// lost with the next slice.
    pub fn pass_over(&mut self, count: u64) {
        self.header.first_sequence += count;
    }

    /// Whether the topic has subscribers: without a receiver, nothing need be computed. A subscriber that ended without
    /// leaving counts until [removed](crate::Bus::remove_dead).
    pub fn has_subscribers(&self) -> bool {
        S::has_subscribers(&self.slices)
    }

    /// Name of the topic.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// The incarnation that this publisher states.
    pub fn incarnation(&self) -> u64 {
        self.header.incarnation
    }

    /// Sequence number of the next sample.
    pub fn next_sequence(&self) -> u64 {
        self.header.first_sequence
    }

    /// Most samples in a slice.
    pub fn slice_len(&self) -> usize {
        self.slice_len
    }

    /// Counts so far.
    pub fn counts(&self) -> PublisherCounts {
        PublisherCounts {
            failed_connections: self.failed_connections.load(Ordering::Relaxed),
            ..self.counts
        }
    }

    fn send_slice(
        &mut self,
        header: BatchHeader,
        length: usize,
        mut fill: impl FnMut(usize) -> T,
    ) -> Result<(), &'static str> {
        let mut slice = LoanedSlice::none();
        self.loan(&mut slice, length)?;
        for index in 0..length {
            slice.push(&fill(index));
        }
        slice.send(&header)?;
        self.hint.word().raise();
        self.wake_up.wake();
        Ok(())
    }

    /// Sends without hints from now on, as a publisher in another language does.
    #[doc(hidden)]
    pub fn pretend_foreign(&mut self) {
        self.hint = Hint::InProcess(Arc::default());
    }

    /// Makes the next slices state another schema, as a publisher of another build would.
    #[doc(hidden)]
    pub fn pretend_schema(&mut self, schema: u64) {
        self.header.schema = schema;
    }
}
