//! Sends slices.
//!
//! A publisher writes samples straight into shared memory, numbers them, and never waits: where a subscriber has no
//! room left, its oldest slice gives way. That the subscriber missed it shows in the numbers ([`BatchHeader`]).
//!
//! Progress marks need care where a send is longer than a slice. "No later sample is older than this" is true of the
//! last of its slices only: the samples of the others are still followed by some of the same send. So all slices but
//! the last repeat the mark of the previous send, and only the last one can end the source.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::port::{DegradationAction, LoanError, SendError};
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use messages::{BatchHeader, Capacity, Topic};

use crate::error::BusError;
use crate::quality::{Header, LOANED_MAX, Octets, reserved_slices};
use crate::transport::{Payload, Transport};

type Port<S> = iceoryx2::port::publisher::Publisher<S, Octets, Header>;

/// Sends slices of samples `T` on one topic.
#[derive(Debug)]
pub struct Publisher<S: Transport, T: Payload> {
    port: Port<S>,
    notifier: Notifier<S>,
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
        port: Port<S>,
        notifier: Notifier<S>,
        failed_connections: Arc<AtomicU64>,
        topic: &Topic<T>,
        incarnation: u64,
    ) -> Self {
        Self {
            port,
            notifier,
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
            failed_connections,
        }
    }

    /// This publisher, stating in every slice the start-up number of fusion.
    #[must_use]
    pub fn with_epoch(mut self, epoch: u64) -> Self {
        self.header.epoch = epoch;
        self
    }

    /// This publisher, stating in every slice the identity of the sensor that its samples come from.
    #[must_use]
    pub fn of_sensor(mut self, sensor_uid: u32) -> Self {
        self.header.sensor_uid = sensor_uid;
        self
    }

    /// Sends `count` samples, in as many slices as they need; with none, one empty slice that carries the mark.
    ///
    /// `fill` is called once per sample, in order, with its place in this send (from 0) and its sequence number, and
    /// its result is written where subscribers read it. Subscribers that wait are woken.
    ///
    /// # Errors
    /// [`BusError::Send`] if a slice could not be sent; those before it were. The samples that were not sent are
    /// counted here, keep their numbers, and so are counted as lost by subscribers. Sending may be tried again.
    pub fn send(&mut self, mark: Mark, count: usize, mut fill: impl FnMut(usize, u64) -> T) -> Result<(), BusError> {
        let first_sequence = self.header.first_sequence;
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
                flags: if last && mark.end { BatchHeader::END } else { 0 },
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
                return Ok(());
            }
        }
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
        // SAFETY: samples travel as slices, so any number of them may be asked for.
        let mut slice = unsafe { self.port.loan_custom_payload(length) }.map_err(loan_reason)?;
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
        // SAFETY: every sample was written.
        let slice = unsafe { slice.assume_init() };
        slice.send().map_err(send_reason)?;
        // Notifying fails only for services with deadlines, which ours are not. A wake-up that does not arrive delays
        // a subscriber (see the waiter), but loses nothing.
        let _ = self.notifier.notify();
        Ok(())
    }

    /// Makes the next slices state another schema, as a publisher of another build would.
    #[doc(hidden)]
    pub fn pretend_schema(&mut self, schema: u64) {
        self.header.schema = schema;
    }
}

/// The port behind a publisher, and a counter of its failed connections.
pub(crate) fn port<S: Transport>(
    slices: &PortFactory<S, Octets, Header>,
    capacity: Capacity,
) -> Result<(Port<S>, Arc<AtomicU64>), PublisherCreateError> {
    let failed_connections = Arc::new(AtomicU64::new(0));
    let counter = Arc::clone(&failed_connections);
    let reserved = reserved_slices(capacity);
    let port = slices
        .publisher_builder()
        .initial_max_slice_len(capacity.slice_len)
        .allocation_strategy(AllocationStrategy::Static)
        .max_loaned_samples(LOANED_MAX)
        .override_sample_preallocation(move |_| reserved)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        // One damaged subscriber must not keep the others from their slices: count it, and go on.
        .set_degradation_handler(move |_, _| {
            counter.fetch_add(1, Ordering::Relaxed);
            DegradationAction::Ignore
        })
        .create()?;
    Ok((port, failed_connections))
}

fn loan_reason(error: LoanError) -> &'static str {
    match error {
        LoanError::OutOfMemory => "the memory reserved for the topic is used up",
        LoanError::ExceedsMaxLoans => "too many slices are being written",
        LoanError::ExceedsMaxLoanSize => "the slice is too long",
        LoanError::InternalFailure => "no memory for the slice (internal failure)",
    }
}

fn send_reason(error: SendError) -> &'static str {
    match error {
        SendError::ConnectionBrokenSinceSenderNoLongerExists => "the publisher was removed",
        SendError::ConnectionCorrupted => "a connection is damaged",
        SendError::LoanError(error) => loan_reason(error),
        SendError::ConnectionError(_) => "a connection could not be made",
        SendError::UnableToDeliver => "a subscriber could not be reached",
        SendError::InternalError => "internal failure",
    }
}
