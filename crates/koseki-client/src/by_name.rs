//! Topics by name, with samples as bytes: for programs that choose their topics at run time.

use std::any::Any;
use std::fmt::Debug;
use std::os::fd::AsFd;
use std::time::Duration;

use bus::{BusError, Payload, Root};
use messages::admission::Admission;
use messages::layout::Layout;
use messages::{BatchHeader, Outgoing, PlatformState, SensorDetection, SensorTrack, Topic, Visitor, WideArea};

use crate::connection::Connection;
use crate::error::Error;
use crate::observation::{Detection, TrackReport};
use crate::publisher::{INPUT, Publisher};
use crate::subscription::{Counts, Slice, Subscription};

/// A [`Subscription`] to samples of any type.
pub trait AnySubscription: AsFd + Debug + Send {
    /// As [`Subscription::next`].
    ///
    /// # Errors
    /// The same.
    fn next(&mut self, timeout: Duration) -> Result<Option<Box<dyn AnySlice>>, Error>;

    /// As [`Subscription::counts`].
    fn counts(&self) -> Counts;

    /// Memory map of the samples.
    fn layout(&self) -> &'static Layout;
}

/// A [`Slice`] of samples of any type.
pub trait AnySlice: Debug + Send {
    /// As [`Slice::header`].
    fn header(&self) -> &BatchHeader;

    /// Samples, as they lie in memory.
    fn octets(&self) -> &[u8];

    /// As [`Slice::lost`].
    fn lost(&self) -> u64;

    /// As [`Slice::starts_epoch`].
    fn starts_epoch(&self) -> bool;
}

/// A [`Publisher`] of samples of any type.
pub trait AnyPublisher: Debug + Send {
    /// As [`Publisher::publish`], of the samples that `octets` are.
    ///
    /// # Errors
    /// The same; also if they are no whole number of samples.
    fn publish(&mut self, octets: &[u8]) -> Result<(), Error>;

    /// As [`Publisher::send`].
    ///
    /// # Errors
    /// The same; also if the topic takes no detections.
    fn send_detections(&mut self, detections: &[Detection]) -> Result<(), Error>;

    /// As [`Publisher::send`].
    ///
    /// # Errors
    /// The same; also if the topic takes no tracks.
    fn send_tracks(&mut self, reports: &[TrackReport]) -> Result<(), Error>;

    /// As [`Publisher::limit_clock`].
    fn limit_clock(&mut self, limit: Option<Duration>);

    /// As [`Publisher::sent`].
    fn sent(&self) -> u64;

    /// Memory map of the samples.
    fn layout(&self) -> &'static Layout;
}

/// Reads the topic called `topic`, such as `system/tracks`, of the deployment at `root`, with a queue of `queue`
/// slices: `None` is the topic's usual number.
///
/// # Errors
/// As [`Subscription::with_queue`]; also if no topic has such a name.
pub fn subscribe(root: &Root, topic: &str, queue: Option<usize>) -> Result<Box<dyn AnySubscription>, Error> {
    messages::visit(topic, Subscribe { root, queue })
        .unwrap_or_else(|| Err(Error::TopicName { name: topic.to_owned() }))
}

/// Writes the topic called `topic`, such as `sensor/NAME/tracks`, of the deployment at `root`.
///
/// # Errors
/// As [`Publisher::open`]; also if the topic is none that is fed from outside.
pub fn publisher(root: &Root, topic: &str) -> Result<Box<dyn AnyPublisher>, Error> {
    let unknown = || Error::TopicName { name: topic.to_owned() };
    messages::visit(topic, Publish { root, topic }).ok_or_else(unknown)?
}

/// Feeds the source called `source` of the deployment at `root` with what it takes: detections or sensor tracks. A
/// sensor of a tracker is called `tracker.sensor`.
///
/// # Errors
/// As [`publisher`].
pub fn feed(root: &Root, source: &str) -> Result<Box<dyn AnyPublisher>, Error> {
    let name = |topic: Topic<SensorDetection>| topic.name.as_str().to_owned();
    let detections = name(messages::sensor_detections(source));
    let input = name(messages::sensor_detections(&format!("{source}{INPUT}")));
    let tracks = messages::sensor_tracks(source).name.as_str().to_owned();
    let topics = Connection::open(root)?.bus.topics()?;
    let is_there = |topic: &String| topics.contains(topic);
    // The keeper creates the topic of the origin after those of all sources.
    let origin = messages::frame_origin().name.as_str().to_owned();
    let takes_detections = is_there(&input) || (is_there(&detections) && source.contains('.'));
    match [&origin, if takes_detections { &detections } else { &tracks }] {
        [origin, _] if !is_there(origin) => Err(no_such_topic(origin)),
        [_, tracks] if !takes_detections && !is_there(tracks) => Err(no_such_topic(tracks)),
        [_, topic] => publisher(root, topic),
    }
}

fn no_such_topic(topic: &str) -> Error {
    Error::Bus(BusError::NoSuchTopic {
        topic: topic.into(),
        waited_ms: 0,
    })
}

/// Returns a limit for [`Publisher::limit_clock`] from seconds above 0; infinity is no limit.
///
/// # Errors
/// If the number is not above 0.
pub fn clock_limit(limit_s: f64) -> Result<Option<Duration>, Error> {
    match limit_s {
        limit_s if limit_s > 0.0 => Ok(Duration::try_from_secs_f64(limit_s).ok()),
        limit_s => Err(Error::ClockLimit { limit_s }),
    }
}

struct Subscribe<'a> {
    root: &'a Root,
    queue: Option<usize>,
}

impl Visitor for Subscribe<'_> {
    type Output = Result<Box<dyn AnySubscription>, Error>;

    fn visit<T: Payload>(self, topic: Topic<T>) -> Self::Output {
        let queue = self.queue.unwrap_or(topic.capacity.depth);
        Ok(Box::new(Subscription::with_queue(self.root, &topic, queue)?))
    }
}

struct Publish<'a> {
    root: &'a Root,
    topic: &'a str,
}

impl Visitor for Publish<'_> {
    type Output = Result<Box<dyn AnyPublisher>, Error>;

    fn visit<T: Payload>(self, topic: Topic<T>) -> Self::Output {
        let topic: &dyn Any = &topic;
        if topic.is::<Topic<SensorTrack>>() {
            self.open::<SensorTrack>()
        } else if topic.is::<Topic<WideArea>>() {
            self.open::<WideArea>()
        } else if topic.is::<Topic<SensorDetection>>() {
            self.open::<SensorDetection>()
        } else if topic.is::<Topic<PlatformState>>() {
            self.open::<PlatformState>()
        } else {
            Err(Error::NotFed {
                topic: self.topic.to_owned(),
            })
        }
    }
}

impl Publish<'_> {
    fn open<T: Outgoing + Admission>(&self) -> Result<Box<dyn AnyPublisher>, Error> {
        let name = self.topic.split('/').nth(1).unwrap_or_default();
        debug_assert_eq!(T::topic(name).name.as_str(), self.topic);
        Ok(Box::new(Publisher::<T>::at(self.root, name)?))
    }
}

impl<T: Payload> AnySubscription for Subscription<T> {
    fn next(&mut self, timeout: Duration) -> Result<Option<Box<dyn AnySlice>>, Error> {
        let slice = self.next(timeout)?;
        Ok(slice.map(|slice| Box::new(slice) as Box<dyn AnySlice>))
    }

    fn counts(&self) -> Counts {
        self.counts()
    }

    fn layout(&self) -> &'static Layout {
        &T::LAYOUT
    }
}

impl<T: Payload> AnySlice for Slice<T> {
    fn header(&self) -> &BatchHeader {
        self.header()
    }

    fn octets(&self) -> &[u8] {
        T::octets(self)
    }

    fn lost(&self) -> u64 {
        self.lost()
    }

    fn starts_epoch(&self) -> bool {
        self.starts_epoch()
    }
}

impl<T: Outgoing + Admission> AnyPublisher for Publisher<T> {
    fn publish(&mut self, octets: &[u8]) -> Result<(), Error> {
        let size = T::LAYOUT.size;
        let samples: Option<Vec<T>> = octets.chunks(size).map(T::of_octets).collect();
        let samples = samples.ok_or_else(|| Error::Octets {
            topic: T::LAYOUT.name.to_owned(),
            octets: octets.len(),
            size,
        })?;
        self.publish(&samples)
    }

    fn send_detections(&mut self, detections: &[Detection]) -> Result<(), Error> {
        let of_kind = (self as &mut dyn Any).downcast_mut::<Publisher<SensorDetection>>();
        of_kind.ok_or_else(|| other_kind::<T>("detections"))?.send(detections)
    }

    fn send_tracks(&mut self, reports: &[TrackReport]) -> Result<(), Error> {
        let of_kind = (self as &mut dyn Any).downcast_mut::<Publisher<SensorTrack>>();
        of_kind
            .ok_or_else(|| other_kind::<T>("reports of tracks"))?
            .send(reports)
    }

    fn limit_clock(&mut self, limit: Option<Duration>) {
        self.limit_clock(limit);
    }

    fn sent(&self) -> u64 {
        self.sent()
    }

    fn layout(&self) -> &'static Layout {
        &T::LAYOUT
    }
}

/// Error of a publisher of the samples `T` that was given observations of another kind.
fn other_kind<T: Outgoing>(given: &'static str) -> Error {
    Error::OtherKind {
        takes: T::STREAM.word(),
        given,
    }
}
