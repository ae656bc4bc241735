//! Reader of slices, with detection of lost samples.

use std::ops::Deref;
use std::os::fd::{AsFd, BorrowedFd};
use std::time::Duration;

use bus::{Payload, ReceiveOutcome, Root, Subscriber, WaitMode, Waiter, Woken};
use messages::{BatchHeader, SystemTrack, Topic};

use crate::clock::mono_ns;
use crate::connection::{Connection, LOOK_NS, Medium};
use crate::error::Error;

/// Reader of one topic; by default of system tracks.
#[derive(Debug)]
pub struct Subscription<T: Payload = SystemTrack> {
    subscriber: Subscriber<Medium, T>,
    waiter: Waiter<Medium>,
    // After the ports.
    connection: Connection,
    /// Lost samples already reported with a slice.
    told: u64,
}

/// A slice in shared memory: samples and their header. Its memory is not overwritten while the slice exists. A
/// subscription can have [`BORROWED_MAX`](crate::BORROWED_MAX) slices at a time.
#[derive(Debug)]
pub struct Slice<T: Payload> {
    inner: bus::Slice<Medium, T>,
    lost: u64,
    starts_epoch: bool,
}

/// Counts of a subscription since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Samples taken.
    pub taken: u64,
    /// Samples missing: the reader was too slow, or the samples were lost with their publisher.
    pub lost: u64,
    /// Samples dropped because they came from a fusion that has been replaced since.
    pub of_older_epochs: u64,
    /// Start-up number of the fusion that wrote the latest slice; 0 if none came yet, or fusion does not write it.
    pub epoch: u64,
}

impl Subscription<SystemTrack> {
    /// Reads the system tracks of the deployment called `instance`.
    ///
    /// # Errors
    /// If it does not run, was built from another version, or has no place left for a reader.
    pub fn open(instance: &str) -> Result<Self, Error> {
        Self::at(&Root::new(instance)?, &messages::system_tracks())
    }
}

impl<T: Payload> Subscription<T> {
    /// Reads `topic` of the deployment at `root`: [`messages`] has a function for each.
    ///
    /// # Errors
    /// As [`Subscription::open`]; also if the deployment has no such topic.
    pub fn at(root: &Root, topic: &Topic<T>) -> Result<Self, Error> {
        Self::with_queue(root, topic, topic.capacity.depth)
    }

    /// Reads like [`Self::at`], with a queue of `queue` slices in place of the topic's usual number
    /// (`topic.capacity.depth`): a reader that falls behind by more slices loses the oldest. The range is from 1 to the
    /// usual number; for `system/tracks`, to `[machine] queue_slices` of the deployment's configuration.
    ///
    /// # Errors
    /// As [`Self::at`]; also if the deployment permits no queue of this length.
    pub fn with_queue(root: &Root, topic: &Topic<T>, queue: usize) -> Result<Self, Error> {
        let connection = Connection::open(root)?;
        let mut waiter = connection.bus.waiter(WaitMode::Event);
        waiter.watch(&connection.bus, topic)?;
        Ok(Self {
            subscriber: connection.bus.subscriber_with_queue(topic, queue, mono_ns)?,
            waiter,
            connection,
            told: 0,
        })
    }

    /// The next slice; waits up to `timeout` for it, which may be zero. `None` if none came, or a signal did.
    ///
    /// # Errors
    /// If the deployment has ended, slices come from another version, or too many slices are kept.
    pub fn next(&mut self, timeout: Duration) -> Result<Option<Slice<T>>, Error> {
        let timeout_ns = u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX);
        let end_ns = mono_ns().saturating_add(timeout_ns);
        let (mut has_ended, mut is_drained) = (false, false);
        loop {
            let epoch = self.subscriber.epoch();
            match self.subscriber.receive()? {
                ReceiveOutcome::Slice(inner) => {
                    let lost = self.subscriber.counts().lost;
                    let next = Slice {
                        starts_epoch: inner.header().epoch != epoch,
                        inner,
                        lost: lost - self.told,
                    };
                    self.told = lost;
                    return Ok(Some(next));
                }
                ReceiveOutcome::OfOlderEpoch => continue,
                ReceiveOutcome::Rejected => {
                    let topic = self.subscriber.topic().to_owned();
                    return Err(Error::Schema { topic });
                }
                ReceiveOutcome::Nothing if has_ended => return Err(self.connection.ended()),
                ReceiveOutcome::Nothing => {}
            }
            // Samples sent before the end may have arrived since the check above, so it is repeated.
            has_ended = self.connection.has_ended()?;
            let left_ns = end_ns.saturating_sub(mono_ns());
            if left_ns == 0 && !is_drained {
                // The descriptor may become unreadable only if nothing is found afterwards.
                self.waiter.drain()?;
                is_drained = true;
            } else if left_ns == 0 && !has_ended {
                return Ok(None);
            } else if !has_ended {
                let time = Duration::from_nanos(left_ns.min(LOOK_NS));
                if self.waiter.wait(time, || self.subscriber.has_slices())? == Woken::Signal {
                    return Ok(None);
                }
            }
        }
    }

    /// Counts so far.
    pub fn counts(&self) -> Counts {
        let counts = self.subscriber.counts();
        Counts {
            taken: counts.taken,
            lost: counts.lost,
            of_older_epochs: counts.of_older_epochs,
            epoch: self.subscriber.epoch(),
        }
    }
}

/// A descriptor that becomes readable when there is something to read. Then call [`Subscription::next`] with no
/// time-out until it returns `None`; call it every tenth of a second all the same, since a wake-up can be lost.
impl<T: Payload> AsFd for Subscription<T> {
    fn as_fd(&self) -> BorrowedFd<'_> {
        let mut descriptors = self.waiter.descriptors();
        descriptors.next().expect("a topic is watched from the beginning")
    }
}

impl<T: Payload> Slice<T> {
    /// Header written by the publisher.
    pub fn header(&self) -> &BatchHeader {
        self.inner.header()
    }

    /// Samples lost between the previous slice and this slice.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Returns whether this is the first slice of a restarted fusion, or the first slice of all: earlier track
    /// numbers are void.
    pub fn starts_epoch(&self) -> bool {
        self.starts_epoch
    }
}

impl<T: Payload> Deref for Slice<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.inner.samples()
    }
}

impl<'a, T: Payload> IntoIterator for &'a Slice<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}
