//! One process's connection to an instance.
//!
//! The launcher *holds* every topic, all others only open them. That is not a matter of taste: a process that creates
//! a service and is killed at the wrong moment leaves one that nobody can open, and whoever opens first would decide
//! about sizes. With a holder, a topic exists before anybody needs it and as long as the instance runs.

use std::any::Any;
use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::listener::{Listener, ListenerCreateError};
use iceoryx2::port::notifier::{Notifier, NotifierCreateError};
use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::prelude::{NodeName, SignalHandlingMode};
use iceoryx2::service::builder::event::{EventCreateError, EventOpenError, EventOpenOrCreateError};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError, PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::port_factory::{event, publish_subscribe};
use iceoryx2::service::static_config::message_type_details::TypeDetail;
use messages::{Capacity, Topic, TopicName};

use crate::error::{BusError, Role};
use crate::publisher::{self, Publisher};
use crate::quality::{Header, LEAVERS_MAX, NODES_MAX, Octets, describe_slices, describe_wake_ups, samples_of};
use crate::root::{Root, tame_logging};
use crate::subscriber::{self, Subscriber};
use crate::transport::{Payload, Transport};
use crate::waiter::{WATCHED_MAX, WaitMode, Waiter};

type Slices<S> = publish_subscribe::PortFactory<S, Octets, Header>;

/// How long a topic that does not exist (yet) is asked for.
const OPEN_PATIENCE: Duration = Duration::from_millis(500);
/// The same for a topic with few publishers.
const FEW_LEAVERS: usize = 8;
/// Pause between two tries.
const OPEN_PAUSE: Duration = Duration::from_millis(10);

/// One process's connection to an instance. It may move to another thread; ports stay on the thread that made them.
/// Ports outlive it.
#[derive(Debug)]
pub struct Bus<S: Transport> {
    node: Node<S>,
    root: Root,
    patience: Duration,
}

impl<S: Transport> Bus<S> {
    /// Joins the instance as `process`; the name appears in errors and status displays. The program's own signal
    /// handling stays untouched. Takes some milliseconds.
    ///
    /// # Errors
    /// [`BusError::NotRunning`] if no process has claimed the instance (not asked [in process](crate::InProcess)).
    pub fn open(root: &Root, process: &str) -> Result<Self, BusError> {
        Self::open_keeping(root, process, LEAVERS_MAX)
    }

    /// The same for a process that reads topics of few publishers each, and often: at most eight of a topic may leave
    /// between two looks, else slices that they have left behind are lost (and counted). iceoryx2 looks at the places
    /// of all that may have left on every look, which is most of what a look costs.
    ///
    /// # Errors
    /// As [`Bus::open`].
    pub fn open_for_few(root: &Root, process: &str) -> Result<Self, BusError> {
        Self::open_keeping(root, process, FEW_LEAVERS)
    }

    fn open_keeping(root: &Root, process: &str, leavers: usize) -> Result<Self, BusError> {
        tame_logging();
        if S::CROSSES_PROCESSES && root.holder()?.is_none() {
            return Err(BusError::NotRunning {
                instance: root.instance().to_owned(),
            });
        }
        let refused = |reason: String| BusError::Join {
            process: process.to_owned(),
            instance: root.instance().to_owned(),
            path: root.path().to_owned(),
            reason,
        };
        let name = NodeName::new(process).map_err(|error| refused(format!("{error:?}")))?;
        let node = NodeBuilder::new()
            .name(&name)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .config(&root.config(leavers)?)
            .create::<S>()
            .map_err(|error| refused(error.to_string()))?;
        Ok(Self {
            node,
            root: root.clone(),
            patience: OPEN_PATIENCE,
        })
    }

    /// This bus, asking for topics that do not exist for `patience` instead of half a second.
    #[must_use]
    pub fn with_patience(mut self, patience: Duration) -> Self {
        self.patience = patience;
        self
    }

    pub(crate) fn node(&self) -> &Node<S> {
        &self.node
    }

    /// The instance.
    pub fn root(&self) -> &Root {
        &self.root
    }

    /// Creates `topic`, or opens it if it exists, and keeps it in existence as long as the result lives.
    ///
    /// # Errors
    /// If it exists with another type or smaller sizes, or cannot be created.
    pub fn hold<T: Payload>(&self, topic: &Topic<T>) -> Result<Held, BusError> {
        let slices = describe_slices(&self.node, &topic.name, topic.capacity, &samples_of(topic))?
            .open_or_create()
            .map_err(|error| held_slices_error(error, &topic.name))?;
        let wake_ups = describe_wake_ups(&self.node, &topic.name, topic.capacity)?
            .open_or_create()
            .map_err(|error| held_wake_ups_error(error, &topic.name))?;
        Ok(Held {
            topic: topic.name.as_str().into(),
            _services: Box::new((slices, wake_ups)),
        })
    }

    /// A publisher on `topic`. `incarnation` is the monotonic time at which the publisher started, in nanoseconds: it
    /// tells a restarted publisher from its predecessor.
    ///
    /// # Errors
    /// [`BusError::NoSuchTopic`] if nobody holds the topic; [`BusError::Full`] if it has no place left, even after
    /// dead processes were removed.
    pub fn publisher<T: Payload>(&self, topic: &Topic<T>, incarnation: u64) -> Result<Publisher<S, T>, BusError> {
        let slices = self.open_slices(&topic.name, topic.capacity, &samples_of(topic))?;
        let full = |role| full_error(&topic.name, role, topic.capacity.publishers);
        let (port, failed_connections) = self.in_place(
            || publisher::port(&slices, topic.capacity),
            |error| match error {
                PublisherCreateError::ExceedsMaxSupportedPublishers => full(Role::Publisher),
                error => topic_error(&topic.name, "make a publisher", error),
            },
        )?;
        // After the port: making the notifier wakes subscribers, which then connect to the port.
        let notifier = self.notifier(&topic.name, topic.capacity)?;
        Ok(Publisher::new(port, notifier, failed_connections, topic, incarnation))
    }

    /// A subscriber to `topic`. `now_ns` reads the same monotonic clock from which publishers have their incarnation;
    /// it is called once, when the subscriber is in place: what publishers that started later sent must arrive, and is
    /// lost if it does not, while of older publishers only what follows their first slice taken is expected.
    ///
    /// # Errors
    /// [`BusError::NoSuchTopic`] if nobody holds the topic; [`BusError::Full`] if it has no place left, even after
    /// dead processes were removed.
    pub fn subscriber<T: Payload>(
        &self,
        topic: &Topic<T>,
        now_ns: impl FnOnce() -> u64,
    ) -> Result<Subscriber<S, T>, BusError> {
        let slices = self.open_slices(&topic.name, topic.capacity, &samples_of(topic))?;
        let (port, failed_connections) = self.in_place(
            || subscriber::port(&slices),
            |error| match error {
                SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                    full_error(&topic.name, Role::Subscriber, topic.capacity.subscribers)
                }
                error => topic_error(&topic.name, "make a subscriber", error),
            },
        )?;
        let joined_ns = now_ns();
        Ok(Subscriber::new(port, failed_connections, topic, joined_ns))
    }

    /// A waiter that watches nothing yet: see [`Waiter::watch`].
    pub fn waiter(&self, mode: WaitMode) -> Waiter<S> {
        Waiter::new(mode)
    }

    /// Takes back the memory and the places of processes that died without leaving. One process of an instance should
    /// call this whenever a process has died, and before it starts a successor.
    pub fn remove_dead(&self) -> DeadProcesses {
        let state = self.node.try_cleanup_dead_nodes();
        DeadProcesses {
            removed: state.cleanups,
            failed: state.failed_cleanups,
        }
    }

    fn notifier(&self, name: &TopicName, capacity: Capacity) -> Result<Notifier<S>, BusError> {
        let wake_ups = self.open_wake_ups(name, capacity)?;
        self.in_place(
            || wake_ups.notifier_builder().create(),
            |error| match error {
                NotifierCreateError::ExceedsMaxSupportedNotifiers => {
                    full_error(name, Role::Publisher, capacity.publishers)
                }
                error => topic_error(name, "make a notifier", error),
            },
        )
    }

    fn listener(&self, name: &TopicName, capacity: Capacity) -> Result<Listener<S>, BusError> {
        let wake_ups = self.open_wake_ups(name, capacity)?;
        self.in_place(
            || wake_ups.listener_builder().create(),
            |error| match error {
                ListenerCreateError::ExceedsMaxSupportedListeners => {
                    full_error(name, Role::Listener, capacity.subscribers)
                }
                error => topic_error(name, "make a listener", error),
            },
        )
    }

    fn open_slices(&self, name: &TopicName, capacity: Capacity, samples: &TypeDetail) -> Result<Slices<S>, BusError> {
        self.patiently(|| {
            let opened = describe_slices(&self.node, name, capacity, samples)?.open();
            opened.map_err(|error| slices_error(error, name))
        })
    }

    fn open_wake_ups(&self, name: &TopicName, capacity: Capacity) -> Result<event::PortFactory<S>, BusError> {
        self.patiently(|| {
            let opened = describe_wake_ups(&self.node, name, capacity)?.open();
            opened.map_err(|error| wake_ups_error(error, name))
        })
    }

    /// Tries until it works, fails for good, or has lasted too long.
    fn patiently<R>(&self, attempt: impl Fn() -> Result<R, BusError>) -> Result<R, BusError> {
        let start = Instant::now();
        loop {
            match attempt() {
                Err(BusError::NoSuchTopic { topic, .. }) => {
                    let waited = start.elapsed();
                    if waited >= self.patience {
                        let waited_ms = waited.as_millis();
                        return Err(BusError::NoSuchTopic { topic, waited_ms });
                    }
                    std::thread::sleep(OPEN_PAUSE);
                }
                result => return result,
            }
        }
    }

    /// Makes a port. If all places are taken, dead processes may have them: removes those, and tries once more.
    fn in_place<P, E>(&self, make: impl Fn() -> Result<P, E>, explain: impl Fn(E) -> BusError) -> Result<P, BusError> {
        match make().map_err(&explain) {
            Err(BusError::Full { .. }) => {
                self.remove_dead();
                make().map_err(&explain)
            }
            result => result,
        }
    }
}

impl<S: Transport> Waiter<S> {
    /// Watches `topic` too. A waiter that only spins needs no notifications, and asks the publishers for none.
    ///
    /// # Errors
    /// If the topic does not exist, has no place left for a listener, or too many are watched.
    pub fn watch<T: Payload>(&mut self, bus: &Bus<S>, topic: &Topic<T>) -> Result<(), BusError> {
        self.watch_wake_ups(bus, &topic.name, topic.capacity)
    }

    fn watch_wake_ups(&mut self, bus: &Bus<S>, name: &TopicName, capacity: Capacity) -> Result<(), BusError> {
        if self.mode() == WaitMode::Spin {
            return Ok(());
        }
        if !self.has_room() {
            return Err(BusError::WatchedTooMany {
                topic: name.as_str().into(),
                limit: WATCHED_MAX,
            });
        }
        self.listen(bus.listener(name, capacity)?);
        Ok(())
    }
}

/// Keeps a topic in existence.
#[derive(Debug)]
#[must_use = "the topic is held only as long as this lives"]
pub struct Held {
    topic: Arc<str>,
    _services: Box<dyn Any + Send>,
}

impl Held {
    /// Name of the topic.
    pub fn topic(&self) -> &str {
        &self.topic
    }
}

/// Outcome of [`Bus::remove_dead`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeadProcesses {
    /// Dead processes whose memory and places were taken back.
    pub removed: u64,
    /// Dead processes of which something could not be removed; another process may be at it. Try again.
    pub failed: u64,
}

fn topic_error(topic: &TopicName, action: &'static str, error: impl ToString) -> BusError {
    BusError::Topic {
        topic: topic.as_str().into(),
        action,
        reason: error.to_string(),
    }
}

fn full_error(topic: &TopicName, role: Role, limit: usize) -> BusError {
    BusError::Full {
        topic: topic.as_str().into(),
        role,
        limit,
    }
}

fn missing_error(topic: &TopicName) -> BusError {
    BusError::NoSuchTopic {
        topic: topic.as_str().into(),
        waited_ms: 0,
    }
}

fn incompatible_error(topic: &TopicName, error: impl ToString) -> BusError {
    BusError::Incompatible {
        topic: topic.as_str().into(),
        reason: error.to_string(),
    }
}

fn slices_error(error: PublishSubscribeOpenError, topic: &TopicName) -> BusError {
    use PublishSubscribeOpenError as E;
    match error {
        E::DoesNotExist | E::IsMarkedForDestruction => missing_error(topic),
        E::ExceedsMaxNumberOfNodes => full_error(topic, Role::Process, NODES_MAX),
        E::IncompatibleTypes
        | E::IncompatibleMessagingPattern
        | E::IncompatibleAttributes
        | E::IncompatibleOverflowBehavior
        | E::VersionMismatch
        | E::DoesNotSupportRequestedMinBufferSize
        | E::DoesNotSupportRequestedMinHistorySize
        | E::DoesNotSupportRequestedMinSubscriberBorrowedSamples
        | E::DoesNotSupportRequestedAmountOfPublishers
        | E::DoesNotSupportRequestedAmountOfSubscribers
        | E::DoesNotSupportRequestedAmountOfNodes => incompatible_error(topic, error),
        error => topic_error(topic, "open it", error),
    }
}

fn wake_ups_error(error: EventOpenError, topic: &TopicName) -> BusError {
    use EventOpenError as E;
    match error {
        E::DoesNotExist | E::IsMarkedForDestruction => missing_error(topic),
        E::ExceedsMaxNumberOfNodes => full_error(topic, Role::Process, NODES_MAX),
        E::IncompatibleMessagingPattern
        | E::IncompatibleAttributes
        | E::IncompatibleDeadline
        | E::IncompatibleNotifierCreatedEvent
        | E::IncompatibleNotifierDroppedEvent
        | E::IncompatibleNotifierDeadEvent
        | E::DoesNotSupportRequestedAmountOfNotifiers
        | E::DoesNotSupportRequestedAmountOfListeners
        | E::DoesNotSupportRequestedMaxEventId
        | E::DoesNotSupportRequestedAmountOfNodes
        | E::VersionMismatch => incompatible_error(topic, error),
        error => topic_error(topic, "open its wake-ups", error),
    }
}

fn held_slices_error(error: PublishSubscribeOpenOrCreateError, topic: &TopicName) -> BusError {
    use PublishSubscribeOpenOrCreateError as E;
    match error {
        E::PublishSubscribeOpenError(error) => slices_error(error, topic),
        E::PublishSubscribeCreateError(error @ PublishSubscribeCreateError::AlreadyExists) => {
            incompatible_error(topic, error)
        }
        error => topic_error(topic, "create it", error),
    }
}

fn held_wake_ups_error(error: EventOpenOrCreateError, topic: &TopicName) -> BusError {
    use EventOpenOrCreateError as E;
    match error {
        E::EventOpenError(error) => wake_ups_error(error, topic),
        E::EventCreateError(error @ EventCreateError::AlreadyExists) => incompatible_error(topic, error),
        error => topic_error(topic, "create its wake-ups", error),
    }
}

#[cfg(test)]
mod tests {
    use messages::{BatchHeader, SensorTrack, SystemTrack};

    use super::*;
    use crate::transport::InProcess;

    #[test]
    fn a_topic_is_of_its_type_to_every_reader() {
        let bus: Bus<InProcess> = Bus::open(&Root::new("typed").unwrap(), "test").unwrap();
        let topic = messages::sensor_tracks("a");
        let _held = bus.hold(&topic).unwrap();
        let service = || {
            let name = iceoryx2::prelude::ServiceName::new(topic.name.as_str()).unwrap();
            bus.node().service_builder(&name)
        };
        // As programs in other languages open it, by the name, size and alignment of its samples.
        let tracks = service().publish_subscribe::<[SensorTrack]>();
        tracks.user_header::<BatchHeader>().open().unwrap();
        let others = service().publish_subscribe::<[SystemTrack]>();
        let refused = others.user_header::<BatchHeader>().open().unwrap_err();
        assert_eq!(refused, PublishSubscribeOpenError::IncompatibleTypes);
        let without_header = service().publish_subscribe::<[SensorTrack]>();
        assert!(without_header.open().is_err());
    }
}
