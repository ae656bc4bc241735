//! Feeds a source, a sensor of a tracker, a wide-area sensor or a platform that the configuration calls `external`.

use std::time::Duration;

use bus::{Mark, Root};
use messages::admission::{self, Admission, CLOCK_LIMIT_NS};
use messages::{Outgoing, sensor_uid};

use crate::claim::Claim;
use crate::clock::{mono_ns, utc_ns};
use crate::connection::{Connection, Medium};
use crate::error::Error;

/// Writer of the topic of one source (`SensorTrack`), sensor of a tracker (`SensorDetection`, called
/// `tracker.sensor`), wide-area sensor (`WideArea`) or platform (`PlatformState`).
#[derive(Debug)]
pub struct Publisher<T: Outgoing> {
    publisher: bus::Publisher<Medium, T>,
    /// Largest distance of a sample's time from this machine's clock, nanoseconds.
    clock_limit_ns: Option<i64>,
    // After the port.
    connection: Connection,
    // After the port, so that a successor finds no living line.
    _claim: Claim,
}

impl<T: Outgoing + Admission> Publisher<T> {
    /// Publishes the samples of the source, sensor or platform called `name`, in the deployment called `instance`.
    ///
    /// # Errors
    /// If the deployment does not run or has no such topic, was built from another version, or has no place left; also
    /// [`Error::Fed`] if another process publishes the samples.
    pub fn open(instance: &str, name: &str) -> Result<Self, Error> {
        Self::at(&Root::new(instance)?, name)
    }

    /// The same in the deployment at `root`.
    ///
    /// # Errors
    /// As [`Publisher::open`].
    pub fn at(root: &Root, name: &str) -> Result<Self, Error> {
        let connection = Connection::open(root)?;
        let (topic, incarnation) = (T::topic(name), mono_ns());
        let claim = Claim::take(root, &connection, &topic, incarnation)?;
        let publisher = connection.bus.publisher(&topic, incarnation)?;
        Ok(Self {
            publisher: publisher.of_sensor(sensor_uid(name)),
            clock_limit_ns: Some(CLOCK_LIMIT_NS),
            connection,
            _claim: claim,
        })
    }

    /// Sets the largest distance of a sample's time from this machine's clock, by default ten minutes; `None`: there is
    /// no limit.
    pub fn limit_clock(&mut self, limit: Option<Duration>) {
        self.clock_limit_ns = limit.map(|limit| i64::try_from(limit.as_nanos()).unwrap_or(i64::MAX));
    }

    /// Publishes `samples`, in the order in which they are to be worked off. Sequence numbers and the times of arrival
    /// and of publishing are filled in.
    ///
    /// # Errors
    /// [`Error::Refused`] if a sample has a fault ([`admission`]): then none of the samples is published. Also if the
    /// deployment has ended, or the samples could not be sent.
    pub fn publish(&mut self, samples: &[T]) -> Result<(), Error> {
        if self.connection.has_ended()? {
            return Err(self.connection.ended());
        }
        let now_ns = utc_ns();
        for (index, sample) in samples.iter().enumerate() {
            if let Some(fault) = admission::fault(sample, now_ns, self.clock_limit_ns) {
                return Err(Error::Refused {
                    index,
                    fault: Box::new(fault),
                });
            }
        }
        let sent_ns = mono_ns().cast_signed();
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns,
            end: false,
        };
        self.publisher.send(mark, samples.len(), |index, sequence| {
            let mut sample = samples[index];
            sample.came_in(sent_ns);
            sample.leave(sequence, sent_ns);
            sample
        })?;
        Ok(())
    }

    /// Samples published so far.
    pub fn sent(&self) -> u64 {
        self.publisher.counts().samples
    }
}
