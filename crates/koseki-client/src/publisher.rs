//! Feeds a source, a sensor of a tracker, a wide-area sensor or a platform that the configuration calls `external`.

use std::time::Duration;

use bus::{Mark, Root};
use frames::SystemFrame;
use messages::admission::{self, Admission, CLOCK_LIMIT_NS};
use messages::{Outgoing, Stream, sensor_uid};

use crate::claim::Claim;
use crate::clock::{mono_ns, utc_ns};
use crate::connection::{Connection, Medium};
use crate::error::Error;
use crate::observation::{Observation, Scans};

/// Writer of the topic of one source (`SensorTrack`), sensor of a tracker (`SensorDetection`, called
/// `tracker.sensor`), wide-area sensor (`WideArea`) or platform (`PlatformState`).
#[derive(Debug)]
pub struct Publisher<T: Outgoing> {
    publisher: bus::Publisher<Medium, T>,
    /// Largest distance of a sample's time from this machine's clock, nanoseconds.
    clock_limit_ns: Option<i64>,
    /// The system frame, from the first observation on.
    frame: Option<SystemFrame>,
    scans: Scans,
    // After the port.
    connection: Connection,
    // After the port, so that a successor finds no living line.
    _claim: Claim,
}

impl<T: Outgoing + Admission> Publisher<T> {
    /// Publishes the samples of the source, sensor or platform called `name`, in the deployment called `instance`. A
    /// source with `input = "detections"` is called by its own name.
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
        let name = &own_input::<T>(&connection, name)?;
        let (topic, incarnation) = (T::topic(name), mono_ns());
        let claim = Claim::take(root, &connection, &topic, incarnation)?;
        let publisher = connection.bus.publisher(&topic, incarnation)?;
        Ok(Self {
            publisher: publisher.of_sensor(sensor_uid(name)),
            clock_limit_ns: Some(CLOCK_LIMIT_NS),
            frame: None,
            scans: Scans::default(),
            connection,
            _claim: claim,
        })
    }

    /// Sets the largest distance of a sample's time from this machine's clock, by default ten minutes; `None`: there is
    /// no limit.
    pub fn limit_clock(&mut self, limit: Option<Duration>) {
        self.clock_limit_ns = limit.map(|limit| i64::try_from(limit.as_nanos()).unwrap_or(i64::MAX));
    }

    /// Publishes `observations`, in the order in which they are to be worked off: as [`publish`](Self::publish) their
    /// samples. The first call waits up to a fifth of a second for the origin of the system frame.
    ///
    /// ```no_run
    /// # use koseki_client::{Detection, Publisher};
    /// # fn main() -> Result<(), koseki_client::Error> {
    /// let mut source = Publisher::open("feed", "own")?;
    /// source.send(&[Detection::at(41.40, 2.10).sigma_m(20.0), Detection::at(41.43, 2.11).sigma_m(20.0)])?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`Error::Observation`] if an observation has a fault: then none is published. Also as
    /// [`publish`](Self::publish), and if the deployment publishes no origin.
    pub fn send<O: Observation<Sample = T>>(&mut self, observations: &[O]) -> Result<(), Error> {
        let frame = match self.frame {
            Some(frame) => frame,
            None => *self.frame.insert(crate::frame(self.connection.bus.root())?),
        };
        let (now_ns, mut scans) = (utc_ns(), self.scans);
        let sampled = observations.iter().enumerate().map(|(index, observation)| {
            let mut sample = observation.sample(&frame, now_ns).map_err(|fault| Error::Observation {
                index,
                fault: Box::new(fault),
            })?;
            observation.count(&mut sample, &mut scans);
            Ok(sample)
        });
        self.publish(&sampled.collect::<Result<Vec<T>, Error>>()?)?;
        self.scans = scans;
        Ok(())
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

/// Suffix of the sensor of a source that is fed with detections, and has a tracker.
pub(crate) const INPUT: &str = ".input";

/// Returns the name in the topic of the samples with which `name` is fed.
fn own_input<T: Outgoing>(connection: &Connection, name: &str) -> Result<String, Error> {
    let input = format!("{name}{INPUT}");
    let topic = T::topic(&input);
    // The topic of the source's own name has what its tracker publishes.
    let is_there = T::STREAM == Stream::Detections
        && connection
            .bus
            .topics()?
            .iter()
            .any(|other| other == topic.name.as_str());
    Ok(if is_there { input } else { name.to_owned() })
}
