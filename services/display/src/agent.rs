//! Duty cycle of the display: receives samples from the topics and puts them into the world.
//!
//! The agent polls every few milliseconds instead of waiting for events, so no publisher ever has to wake the
//! display.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use bus::{Bus, BusError, Subscriber, Transport};
use deployment::Deployment;
use messages::{Counter, FrameOrigin, Health, Stream, SystemTrack};
use runtime::{Agent, HealthEntry, LookPause, Now, Turn};
use web::RequestCounts;

use crate::feed::Feed;
use crate::layers::{DisplayedSample, ForDisplayed, for_displayed};
use crate::orders::OrderAgent;
use crate::shared::SharedState;
use crate::world::World;

/// Slices taken from one topic in one turn: the capacity of its queue.
const SLICES_PER_TURN: usize = 256;
/// Time between two polls: at the highest rates, a queue holds the slices of several polls. The time grows while no
/// stream has anything: then a queue holds what 2,500 slices a second bring during a poll.
const LOOK_EVERY: Duration = Duration::from_millis(5);
const LOOK_EVERY_IDLE: Duration = Duration::from_millis(100);

/// Display agent; generic over the transport, so that tests drive it in process.
pub(crate) struct DisplayAgent<S: Transport> {
    shared: Arc<SharedState>,
    /// Requests that the server refused.
    refused: Arc<RequestCounts>,
    health: Subscriber<S, Health>,
    origins: Subscriber<S, FrameOrigin>,
    /// Streams apart from the system tracks.
    layers: Vec<Box<dyn Layer>>,
    /// System tracks: counted, and taken last, since reports come before the states that result from them.
    states: FedSubscriber<S, SystemTrack>,
    /// Port for orders, if operators are configured.
    operators: Option<OrderAgent<S>>,
    pause: LookPause,
}

impl<S: Transport> DisplayAgent<S> {
    /// Creates the display agent of the deployment `config`, which may have operators; it fills `shared`.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(crate) fn new(
        config: &Deployment,
        has_operators: bool,
        bus: &Bus<S>,
        incarnation: u64,
        sight: (Arc<SharedState>, Arc<RequestCounts>),
    ) -> anyhow::Result<Self> {
        let mut agent = Self::of_system_tracks(bus, incarnation, sight)?;
        agent.operators = has_operators.then(|| OrderAgent::open(bus, incarnation)).transpose()?;
        let streams = config.streams();
        agent.subscribe(streams.map(|(id, name)| (id.stream, name)), bus, incarnation)?;
        Ok(agent)
    }

    /// Creates the display agent of an instance without its configuration: it has the system tracks alone.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(crate) fn of_system_tracks(
        bus: &Bus<S>,
        incarnation: u64,
        (shared, refused): (Arc<SharedState>, Arc<RequestCounts>),
    ) -> anyhow::Result<Self> {
        let now_ns = || incarnation;
        let states = bus.subscriber(&messages::system_tracks(), now_ns)?;
        let states = FedSubscriber::new(states, &shared.feed);
        Ok(Self {
            shared,
            refused,
            health: bus.subscriber(&messages::health(), now_ns)?,
            origins: bus.subscriber(&messages::frame_origin(), now_ns)?,
            layers: Vec::new(),
            states,
            pause: LookPause::between(LOOK_EVERY, LOOK_EVERY_IDLE),
            operators: None,
        })
    }

    /// Subscribes to further streams, each with the name of its source or sensor.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(crate) fn subscribe<'a>(
        &mut self,
        streams: impl Iterator<Item = (Stream, &'a str)>,
        bus: &Bus<S>,
        incarnation: u64,
    ) -> anyhow::Result<()> {
        for (stream, name) in streams.filter(|(stream, _)| *stream != Stream::SystemTracks) {
            let feed = &self.shared.feed;
            let subscription = Subscription {
                bus,
                name,
                incarnation,
                feed,
            };
            self.layers.extend(for_displayed(stream, subscription).transpose()?);
        }
        Ok(())
    }
}

/// Subscriber of one displayed stream.
trait Layer {
    /// Puts the waiting slices into `world`, and hands them to the readers of `feed`. Returns their number.
    fn take(&mut self, world: &mut World, feed: &Feed, now: Now) -> Result<usize, BusError>;
}

/// Subscriber whose slices also have readers of the feed.
struct FedSubscriber<S: Transport, T: DisplayedSample> {
    subscriber: Subscriber<S, T>,
    /// Place of the topic in the feed; `None`: the feed does not have the topic.
    place: Option<usize>,
}

impl<S: Transport, T: DisplayedSample> FedSubscriber<S, T> {
    fn new(subscriber: Subscriber<S, T>, feed: &Feed) -> Self {
        let place = feed.place_of(subscriber.topic());
        Self { subscriber, place }
    }
}

impl<S: Transport, T: DisplayedSample> Layer for FedSubscriber<S, T> {
    fn take(&mut self, world: &mut World, feed: &Feed, now: Now) -> Result<usize, BusError> {
        let place = self.place;
        self.subscriber.take(SLICES_PER_TURN, |header, samples| {
            T::put(world, (header, samples), now);
            if let Some(place) = place {
                feed.publish(place, T::octets(samples), now.utc_ns);
            }
        })
    }
}

/// Subscription to the topic of one source, by kind of stream.
struct Subscription<'a, S: Transport> {
    bus: &'a Bus<S>,
    name: &'a str,
    incarnation: u64,
    feed: &'a Feed,
}

impl<S: Transport> ForDisplayed for Subscription<'_, S> {
    type Done = Result<Box<dyn Layer>, BusError>;

    fn of<T: DisplayedSample>(self) -> Self::Done {
        let subscriber = self.bus.subscriber(&T::topic(self.name), || self.incarnation)?;
        Ok(Box::new(FedSubscriber::new(subscriber, self.feed)))
    }
}

impl<S: Transport> Agent for DisplayAgent<S> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        if let Some(operators) = &mut self.operators {
            operators.turn(&self.shared.orders, now)?;
        }
        let (mut world, feed) = (self.shared.world(), &self.shared.feed);
        let world = &mut *world;
        self.origins.take(SLICES_PER_TURN, |_, said| {
            said.iter().for_each(|origin| world.place(origin))
        })?;
        self.health.take(SLICES_PER_TURN, |_, said| {
            said.iter().for_each(|health| world.observed.take_health(health))
        })?;
        let mut taken = 0;
        for layer in &mut self.layers {
            taken += layer.take(world, feed, now)?;
        }
        taken += self.states.take(world, feed, now)?;
        world.clean_up(now);
        Ok(Turn::Idle(self.pause.after(taken > 0)))
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let (taken, traffic) = (self.states.subscriber.counts(), &self.shared.traffic);
        let mut entry = HealthEntry::default();
        entry.set(Counter::Taken, taken.taken);
        entry.set(Counter::Lost, taken.lost);
        entry.set(Counter::RejectedSchema, taken.schema_mismatch);
        entry.set(Counter::RejectedEpoch, taken.of_older_epochs);
        entry.set(Counter::PicturesSent, traffic.sent.load(Ordering::Relaxed));
        entry.set(Counter::PicturesSkipped, traffic.skipped.load(Ordering::Relaxed));
        let rejected = self.refused.total() + traffic.refused.load(Ordering::Relaxed);
        entry.set(Counter::RequestsRejected, rejected);
        entries.push(entry);
    }
}
