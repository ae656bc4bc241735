//! Publisher: sends slices on a topic.
//!
//! A publisher writes samples directly into shared memory, numbers the samples, and never waits: a full subscriber
//! loses its oldest slice, and detects the loss by the numbers ([`BatchHeader`]).
//!
//! Progress marks need care where a send is longer than a slice. "No later sample is older than this" is true of the
//! last of its slices only: the samples of the others are still followed by some of the same send. So all slices but
//! the last repeat the mark of the previous send, and only the last one can end the source.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::Ordering::{self, SeqCst};
use std::sync::atomic::{AtomicU64, fence};

use messages::{BatchHeader, Topic};

use crate::error::BusError;
use crate::hint::Hint;
use crate::line::OwnLine;
use crate::ports::{DropGuard, Sending, Transport};
use crate::sends::Word as _;
use crate::service::{PublisherPort, WakeUps};
use crate::transport::Payload;

/// Sends slices of samples `T` on one topic.
#[derive(Debug)]
pub struct Publisher<S: Transport, T: Payload> {
    port: DropGuard<PublisherPort<S>>,
    wake_ups: DropGuard<WakeUps<S>>,
    /// Dropped after the port: when the line is marked as ended, no further slice enters the queue.
    line: Option<OwnLine>,
    hint: Hint,
    samples: PhantomData<fn(T)>,
    topic: Arc<str>,
    slice_len: usize,
    /// Header of the next slice. Its progress mark is that of the previous send.
    header: BatchHeader,
    counts: PublisherCounts,
    failed_connections: Arc<AtomicU64>,
}

/// Statements of a send besides its samples: see [`BatchHeader`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// No sample of a later send will have a time of measurement before this (UTC, ns); `i64::MIN` if unknown.
    pub progress_ns: i64,
    /// Monotonic time of the send, nanoseconds.
    pub sent_ns: i64,
    /// The source has ended, and nothing follows.
    pub end: bool,
}

/// Counts of a publisher since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PublisherCounts {
    /// Samples sent.
    pub samples: u64,
    /// Slices sent, the empty ones included.
    pub slices: u64,
    /// Samples that could not be sent; subscribers count them as lost.
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
            wake_ups: opened.wake_ups,
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

    /// This publisher, stating in every slice the identity of the boot of the machine that its samples come from.
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

    /// The start-up number of fusion that this publisher states; 0 if it is none.
    pub fn epoch(&self) -> u64 {
        self.header.epoch
    }

    /// This publisher, stating in every slice the identity of the sensor that its samples come from.
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
    /// `fill` is called once per sample, in order, with its index in this send (from 0) and its sequence number; the
    /// result is written to the place read by subscribers. Waiting subscribers are woken.
    ///
    /// # Errors
    /// [`BusError::Send`] if a slice could not be sent; those before it were. The samples that were not sent are
    /// counted here, keep their numbers, and so are counted as lost by subscribers. Sending may be tried again.
    pub fn send(&mut self, mark: Mark, count: usize, mut fill: impl FnMut(usize, u64) -> T) -> Result<(), BusError> {
        let first_sequence = self.header.first_sequence;
        if let Some(line) = &self.line {
            line.number(first_sequence + count as u64);
        }
        let mut done = 0;
        loop {
            let length = (count - done).min(self.slice_len);
            let last = done + length == count;
            let header = BatchHeader {
                progress_ns: if last {
                    mark.progress_ns
                } else {
                    self.header.progress_ns
                },
                sent_ns: mark.sent_ns,
                flags: self.header.flags | if last && mark.end { BatchHeader::END } else { 0 },
                ..self.header
            };
            let fill_one = |index| fill(done + index, header.first_sequence + index as u64);
            if let Err(reason) = self.send_slice(header, length, fill_one) {
                self.header.first_sequence = first_sequence + count as u64;
                self.counts.not_sent += (count - done) as u64;
                return Err(BusError::Send {
                    topic: self.topic.clone(),
                    samples: count - done,
                    reason,
                });
            }
            self.header.first_sequence += length as u64;
            self.counts.samples += length as u64;
            self.counts.slices += 1;
            done += length;
            if last {
                self.header.progress_ns = mark.progress_ns;
                if let Some(line) = &self.line {
                    line.beat(mark.sent_ns);
                }
                return Ok(());
            }
        }
    }

    /// Passes over the next `count` sequence numbers: of samples that were lost before they got here, which subscribers
    /// count as lost with the next slice.
    pub fn pass_over(&mut self, count: u64) {
        self.header.first_sequence += count;
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

    /// Most samples in one slice.
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
        &self,
        header: BatchHeader,
        length: usize,
        mut fill: impl FnMut(usize) -> T,
    ) -> Result<(), &'static str> {
        let mut slice = S::loan(&self.port, length)?;
        let place = std::ptr::from_mut(slice.user_header_mut()).cast::<BatchHeader>();
        // SAFETY: the topic was opened with the size and alignment of a `BatchHeader` for this place.
        unsafe { place.write(header) };
        let octets = slice.payload_mut();
        debug_assert_eq!(octets.len(), length * size_of::<T>());
        let first = octets.as_mut_ptr().cast::<T>();
        for index in 0..length {
            let sample = fill(index);
            // SAFETY: the slice has `length` places of the size and alignment of `T`, with which the topic was opened.
            unsafe { first.add(index).write(sample) };
        }
        // SAFETY: every sample was written, and the header.
        unsafe { S::send(slice) }?;
        self.hint.word().raise();
        // The slice is in the queues before the listeners are counted, and a new listener is counted before its owner
        // looks into the queues: one of the two sees the other.
        fence(SeqCst);
        S::wake(&self.wake_ups);
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
