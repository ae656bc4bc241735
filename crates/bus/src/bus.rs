//! One process's connection to an instance.
//!
//! One process, the keeper, *holds* every topic, all others only open them. That is not a matter of taste: a process
//! that creates a service and is killed at the wrong moment leaves one that nobody can open, and whoever opens first
//! would decide about sizes. With a holder, a topic exists before anybody needs it and as long as the instance runs.

use std::time::Duration;

use iceoryx2::node::Node;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};
use messages::Topic;

use crate::error::BusError;
use crate::line::{self, Ends, Identity, Lines, OwnLine, PublisherLine};
use crate::log::{self, LogReader, LogWriter};
use crate::membership::Membership;
use crate::ports::{Kept, Transport};
use crate::publisher::Publisher;
use crate::quality::LEAVERS_MAX;
use crate::root::{Root, close_to_others};
use crate::service::{DeadProcesses, Held, Service};
use crate::subscriber::Subscriber;
use crate::transport::Payload;
use crate::waiter::{WATCHED_MAX, WaitMode, Waiter};

/// How long a topic that does not exist (yet) is asked for.
const OPEN_PATIENCE: Duration = Duration::from_millis(500);
/// Publishers of a topic with few of them that may leave between two looks of a subscriber without loss.
const FEW_LEAVERS: usize = 8;
/// With what names begin that no other process sees.
const PREFIX_IN_PROCESS: &str = "k_";

/// One process's connection to an instance. It may move to another thread; ports stay on the thread that made them.
/// Ports outlive it.
#[derive(Debug)]
pub struct Bus<S: Transport> {
    node: Kept<Node<S>>,
    // After the node.
    _membership: Option<Membership>,
    root: Root,
    /// With what names of its memory begin.
    prefix: String,
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
        let (membership, prefix) = if S::CROSSES_PROCESSES {
            let joined = Membership::begin(root)?.ok_or_else(|| BusError::NotRunning {
                instance: root.instance().to_owned(),
            })?;
            (Some(joined.0), joined.1)
        } else {
            (None, PREFIX_IN_PROCESS.to_owned())
        };
        let node = S::join(root, process, &prefix, leavers)?;
        if S::CROSSES_PROCESSES {
            close_to_others(&prefix)?;
        }
        Ok(Self {
            node,
            _membership: membership,
            root: root.clone(),
            prefix,
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

    /// Whether the run of the instance that this process has joined goes on: it has neither ended nor been replaced by
    /// another of the same name. Always [in process](crate::InProcess).
    ///
    /// # Errors
    /// If the instance's files cannot be read.
    pub fn goes_on(&self) -> Result<bool, BusError> {
        let is_same = || Ok(self.root.prefix()?.as_ref() == Some(&self.prefix));
        Ok(!S::CROSSES_PROCESSES || (self.root.holder()?.is_some() && is_same()?))
    }

    /// Creates `topic`, or opens it if it exists, and keeps it in existence as long as the result lives.
    ///
    /// # Errors
    /// If it exists with another type or smaller sizes, or cannot be created.
    pub fn hold<T: Payload>(&self, topic: &Topic<T>) -> Result<Held, BusError> {
        if S::CROSSES_PROCESSES {
            // Before the topic: whoever finds that finds its lines.
            Lines::create(&self.prefix, &topic.name, topic.capacity.publishers)?;
        }
        S::hold(&self.node, &self.service(topic))
    }

    /// Makes the log of `topic`, at `created_ns` (monotonic, nanoseconds); it exists as long as the instance does.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn hold_log<T: Payload>(&self, topic: &Topic<T>, created_ns: u64) -> Result<(), BusError> {
        if S::CROSSES_PROCESSES {
            log::create(&self.prefix, topic, created_ns)?;
        }
        Ok(())
    }

    /// The writer of the log of `topic`: there must be one at a time. [In process](crate::InProcess) nobody reads what
    /// it writes.
    ///
    /// # Errors
    /// If nobody holds the log.
    pub fn log_writer<T: Payload>(&self, topic: &Topic<T>) -> Result<LogWriter<T>, BusError> {
        LogWriter::open(S::CROSSES_PROCESSES.then_some(&self.prefix), topic)
    }

    /// A reader of the log of `topic`, from the oldest sample on.
    ///
    /// # Errors
    /// If nobody holds the log.
    pub fn log_reader<T: Payload>(&self, topic: &Topic<T>) -> Result<LogReader<T>, BusError> {
        LogReader::open(S::CROSSES_PROCESSES.then_some(&self.prefix), topic)
    }

    fn service<'a, T: Payload>(&self, topic: &'a Topic<T>) -> Service<'a> {
        Service {
            name: &topic.name,
            capacity: topic.capacity,
            // By which iceoryx2 keeps readers of another type away.
            samples: TypeDetail::new::<T>(TypeVariant::Dynamic),
            patience: self.patience,
        }
    }

    /// A publisher on `topic`. `incarnation` is the monotonic time at which the publisher started, in nanoseconds: it
    /// tells a restarted publisher from its predecessor.
    ///
    /// # Errors
    /// [`BusError::NoSuchTopic`] if nobody holds the topic; [`BusError::Full`] if it has no place left, even after
    /// dead processes were removed.
    pub fn publisher<T: Payload>(&self, topic: &Topic<T>, incarnation: u64) -> Result<Publisher<S, T>, BusError> {
        let opened = S::publish(&self.node, &self.service(topic))?;
        let who = Identity {
            node: opened.node,
            origin: opened.origin,
            incarnation,
            schema: T::SCHEMA,
        };
        let line = self.lines(topic)?.and_then(|lines| OwnLine::begin(lines, &who));
        Ok(Publisher::new(opened, line, topic, incarnation))
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
        let opened = S::subscribe(&self.node, &self.service(topic))?;
        let ends = self.lines(topic)?.map(|lines| Ends::from_now_on(lines, T::SCHEMA));
        let joined_ns = now_ns();
        Ok(Subscriber::new(opened, ends, topic, joined_ns))
    }

    /// Last words of the publishers of `topic`, the dead ones included until their lines are needed for others: see
    /// [`PublisherLine`]. None [in process](crate::InProcess), where publishers end with all others.
    ///
    /// # Errors
    /// If nobody holds the topic.
    pub fn publisher_lines<T: Payload>(&self, topic: &Topic<T>) -> Result<Vec<PublisherLine>, BusError> {
        let lines = self.lines(topic)?;
        let of_schema = |line: &PublisherLine| line.schema == T::SCHEMA;
        Ok(lines.map_or_else(Vec::new, |lines| lines.read().filter(of_schema).collect()))
    }

    fn lines<T: Payload>(&self, topic: &Topic<T>) -> Result<Option<Lines>, BusError> {
        let open = || Lines::open(&self.prefix, &topic.name);
        S::CROSSES_PROCESSES.then(open).transpose()
    }

    /// A waiter that watches nothing yet: see [`Waiter::watch`].
    pub fn waiter(&self, mode: WaitMode) -> Waiter<S> {
        Waiter::new(mode)
    }

    /// Takes back the memory and the places of processes that died without leaving. One process of an instance should
    /// call this whenever a process has died, and before it starts a successor.
    pub fn remove_dead(&self) -> DeadProcesses {
        let dead = S::remove_dead(&self.node);
        if S::CROSSES_PROCESSES {
            // What cannot be removed now is found again the next time.
            let _ = self.root.remove_remains(&self.prefix);
            line::mark_dead(&self.prefix, || self.root.nodes());
        }
        dead
    }
}

impl<S: Transport> Waiter<S> {
    /// Watches `topic` too. A waiter that only spins needs no notifications, and asks the publishers for none.
    ///
    /// # Errors
    /// If the topic does not exist, has no place left for a listener, or too many are watched.
    pub fn watch<T: Payload>(&mut self, bus: &Bus<S>, topic: &Topic<T>) -> Result<(), BusError> {
        if self.mode() == WaitMode::Spin {
            return Ok(());
        }
        if !self.has_room() {
            return Err(BusError::WatchedTooMany {
                topic: topic.name.as_str().into(),
                limit: WATCHED_MAX,
            });
        }
        self.listen(S::listen(&bus.node, &bus.service(topic))?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
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
