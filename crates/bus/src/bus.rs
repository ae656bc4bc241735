//! Connection of a process to an instance.
//!
//! A single process, the keeper, *holds* every topic; all other processes only open topics. If every process created
//! services, a kill at the wrong moment would leave a service that no process can open, and the first process would
//! decide about sizes. With a holder, a topic exists before its first use and during the whole run of the instance.

use std::sync::atomic::Ordering::{Release, SeqCst};
use std::sync::atomic::fence;
use std::time::Duration;

use iceoryx2::node::Node;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};
use messages::Topic;

use crate::error::BusError;
use crate::hint::Hint;
use crate::line::{self, Ends, Identity, LineReader, Lines, OwnLine, PublisherLine};
use crate::log::{self, LogReader, LogWriter};
use crate::membership::Membership;
use crate::ports::{DropGuard, Transport};
use crate::publisher::Publisher;
use crate::quality::LEAVERS_MAX;
use crate::root::{Root, close_to_others};
use crate::service::{DeadProcesses, Service, TopicHold};
use crate::subscriber::Subscriber;
use crate::transport::Payload;
use crate::waiter::{WATCHED_MAX, WaitMode, Waiter};

/// How long a topic that does not exist (yet) is asked for.
const OPEN_PATIENCE: Duration = Duration::from_millis(500);
/// Publishers of a topic with few publishers that may leave between two looks of a subscriber without loss.
const FEW_LEAVERS: usize = 8;
/// Start of names used within a process only.
const PREFIX_IN_PROCESS: &str = "k_";

/// Connection of a process to an instance. A connection may move to another thread; ports stay on the thread that
/// made them, and outlive the connection.
#[derive(Debug)]
pub struct Bus<S: Transport> {
    node: DropGuard<Node<S>>,
    // After the node.
    _membership: Option<Membership>,
    root: Root,
    /// Start of the names of the instance's memory.
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

    /// Joins like [`Self::open`], for a process that reads topics of few publishers often. At most eight publishers
    /// of a topic may leave between two reads; beyond that, unread slices are lost (and counted). iceoryx2 checks the
    /// places of all possible leavers on every read, which is most of the cost of a read.
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
                base: root.base().to_owned(),
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

    /// Returns whether the joined run of the instance continues: it has neither ended nor been replaced by another
    /// run of the same name. Always true [in process](crate::InProcess).
    ///
    /// # Errors
    /// If the instance's files cannot be read.
    pub fn goes_on(&self) -> Result<bool, BusError> {
        let is_same = || Ok(self.root.prefix()?.as_ref() == Some(&self.prefix));
        Ok(!S::CROSSES_PROCESSES || (self.root.holder()?.is_some() && is_same()?))
    }

    /// Returns the names of the instance's topics, in their order.
    ///
    /// # Errors
    /// If the instance's files cannot be read.
    pub fn topics(&self) -> Result<Vec<String>, BusError> {
        S::topics(&self.node)
    }

    /// Creates `topic`, or opens an existing topic, and keeps the topic in existence during the life of the result. A
    /// greater `depth` than the usual number permits longer queues to subscribers that request them.
    ///
    /// # Errors
    /// If the topic exists with another type or smaller sizes, or cannot be created.
    pub fn hold<T: Payload>(&self, topic: &Topic<T>) -> Result<TopicHold, BusError> {
        if S::CROSSES_PROCESSES {
            // Lines are created first, so that every process that finds the topic finds the lines.
            Lines::create(&self.prefix, &topic.name, topic.capacity.publishers)?;
        }
        S::hold(&self.node, &self.service(topic))
    }

    /// Makes the log of `topic`, at `created_ns` (monotonic, nanoseconds); the log exists as long as the instance.
    ///
    /// # Errors
    /// If the log cannot be made.
    pub fn hold_log<T: Payload>(&self, topic: &Topic<T>, created_ns: u64) -> Result<(), BusError> {
        if S::CROSSES_PROCESSES {
            log::create(&self.prefix, topic, created_ns)?;
        }
        Ok(())
    }

    /// Returns the writer of the log of `topic`; at most a single writer may exist at a time. [In
    /// process](crate::InProcess) the log has no reader.
    ///
    /// # Errors
    /// If no process holds the log.
    pub fn log_writer<T: Payload>(&self, topic: &Topic<T>) -> Result<LogWriter<T>, BusError> {
        LogWriter::open(S::CROSSES_PROCESSES.then_some(&self.prefix), topic)
    }

    /// A reader of the log of `topic`, from the oldest sample on.
    ///
    /// # Errors
    /// If no process holds the log.
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

    /// Returns a publisher on `topic`. `incarnation` is the monotonic time of the publisher's start, nanoseconds, and
    /// distinguishes a restarted publisher from its predecessor.
    ///
    /// # Errors
    /// [`BusError::NoSuchTopic`] if no process holds the topic; [`BusError::Full`] if the topic has no free place,
    /// even after the removal of dead processes.
    pub fn publisher<T: Payload>(&self, topic: &Topic<T>, incarnation: u64) -> Result<Publisher<S, T>, BusError> {
        let opened = S::publish(&self.node, &self.service(topic))?;
        let who = Identity {
            node: opened.node,
            origin: opened.origin,
            incarnation,
            schema: T::SCHEMA,
        };
        let line = self.lines(topic)?.and_then(|lines| OwnLine::begin(lines, &who));
        Ok(Publisher::new(opened, line, self.hint(topic)?, topic, incarnation))
    }

    /// Returns a subscriber to `topic`. `now_ns` reads the monotonic clock of the publishers' incarnations, once, when
    /// the subscriber is connected. Samples of publishers started later must arrive, and count as lost otherwise; of
    /// older publishers, only samples after the first taken slice are expected.
    ///
    /// # Errors
    /// [`BusError::NoSuchTopic`] if no process holds the topic; [`BusError::Full`] if the topic has no free place,
    /// even after the removal of dead processes.
    pub fn subscriber<T: Payload>(
        &self,
        topic: &Topic<T>,
        now_ns: impl FnOnce() -> u64,
    ) -> Result<Subscriber<S, T>, BusError> {
        self.subscriber_with_queue(topic, topic.capacity.depth, now_ns)
    }

    /// Returns a subscriber as [`Self::subscriber`] does, with a queue of `queue` slices in place of the topic's usual
    /// number: from 1 to the number with which the topic is [held](Self::hold).
    ///
    /// # Errors
    /// As [`Self::subscriber`]; [`BusError::Queue`] if the topic permits no queue of this length.
    pub fn subscriber_with_queue<T: Payload>(
        &self,
        topic: &Topic<T>,
        queue: usize,
        now_ns: impl FnOnce() -> u64,
    ) -> Result<Subscriber<S, T>, BusError> {
        let opened = S::subscribe(&self.node, &self.service(topic), queue)?;
        let ends = self.lines(topic)?.map(|lines| Ends::from_now_on(lines, T::SCHEMA));
        let joined_ns = now_ns();
        Ok(Subscriber::new(opened, ends, self.hint(topic)?, topic, joined_ns))
    }

    /// Last words of the publishers of `topic`, the dead ones included until the lines are needed for others: see
    /// [`PublisherLine`]. None [in process](crate::InProcess), where publishers end with all others.
    ///
    /// # Errors
    /// If no process holds the topic.
    pub fn publisher_lines<T: Payload>(&self, topic: &Topic<T>) -> Result<Vec<PublisherLine>, BusError> {
        Ok(self.line_reader(topic)?.read())
    }

    /// Reader of the same lines, for a process that looks again and again.
    ///
    /// # Errors
    /// If no process holds the topic.
    pub fn line_reader<T: Payload>(&self, topic: &Topic<T>) -> Result<LineReader, BusError> {
        Ok(LineReader::new(self.lines(topic)?, T::SCHEMA))
    }

    fn hint<T: Payload>(&self, topic: &Topic<T>) -> Result<Hint, BusError> {
        let lines = self.lines(topic)?;
        Ok(lines.map_or_else(|| Hint::in_process(self.root.path(), &topic.name), Hint::Shared))
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
            // Files that cannot be removed now are found again at the next removal.
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
        bus.hint(topic)?.listeners().fetch_add(1, Release);
        // A publisher that does not see this listener yet does not wake the listener, but has written its slice before:
        // the first question of the wait finds the slice (see the module `wake_up`).
        fence(SeqCst);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
    use messages::{BatchHeader, SensorTrack, SystemTrack};

    use super::*;
    use crate::publisher::Mark;
    use crate::transport::InProcess;
    use crate::waiter::{Look, Woken};

    #[test]
    fn a_topic_is_of_its_type_to_every_reader() {
        let bus: Bus<InProcess> = Bus::open(&Root::new("typed").unwrap(), "test").unwrap();
        let topic = messages::sensor_tracks("a");
        let _held = bus.hold(&topic).unwrap();
        let service = || {
            let name = iceoryx2::prelude::ServiceName::new(topic.name.as_str()).unwrap();
            bus.node().service_builder(&name)
        };
        // As in other languages: by the name, size and alignment of the samples.
        let tracks = service().publish_subscribe::<[SensorTrack]>();
        tracks.user_header::<BatchHeader>().open().unwrap();
        let others = service().publish_subscribe::<[SystemTrack]>();
        let refused = others.user_header::<BatchHeader>().open().unwrap_err();
        assert_eq!(refused, PublishSubscribeOpenError::IncompatibleTypes);
        let without_header = service().publish_subscribe::<[SensorTrack]>();
        assert!(without_header.open().is_err());
    }

    #[test]
    fn a_glance_sees_what_was_sent_and_only_a_look_sees_what_came_without_a_hint() {
        let folder = tempfile::tempdir().unwrap();
        let root = Root::in_base(folder.path(), "hinted").unwrap();
        let bus: Bus<InProcess> = Bus::open(&root, "test").unwrap();
        let topic = messages::sensor_tracks("a");
        let _held = bus.hold(&topic).unwrap();
        let mut subscriber = bus.subscriber(&topic, || 0).unwrap();
        let mark = Mark {
            progress_ns: 0,
            sent_ns: 0,
            end: false,
        };
        let mut look = || {
            let glance = subscriber.may_have_slices();
            (glance, subscriber.take(1, |_, _| ()).unwrap())
        };
        assert_eq!(look(), (true, 0), "before the first look");
        assert_eq!(look(), (false, 0));
        let mut publishers = [1, 2].map(|incarnation| bus.publisher(&topic, incarnation).unwrap());
        for publisher in &mut publishers {
            publisher.send(mark, 1, |_, _| SensorTrack::default()).unwrap();
        }
        assert_eq!([look(), look(), look()], [(true, 1), (true, 1), (false, 0)]);
        // As a publisher in another language does.
        let name = iceoryx2::prelude::ServiceName::new(topic.name.as_str()).unwrap();
        let service = bus.node().service_builder(&name);
        let service = service
            .publish_subscribe::<[SensorTrack]>()
            .user_header::<BatchHeader>();
        let foreign = service
            .open()
            .unwrap()
            .publisher_builder()
            .initial_max_slice_len(1)
            .create()
            .unwrap();
        let mut slice = foreign.loan_slice_uninit(1).unwrap();
        *slice.user_header_mut() = BatchHeader {
            schema: <SensorTrack as messages::layout::Sample>::SCHEMA,
            ..BatchHeader::default()
        };
        slice.write_from_fn(|_| SensorTrack::default()).send().unwrap();
        assert_eq!(look(), (false, 1), "without a hint");
        assert_eq!([look(), look()], [(true, 0), (false, 0)]);
        // A publisher that comes and goes between two looks.
        let mut brief = bus.publisher(&topic, 3).unwrap();
        assert_eq!(look(), (false, 0), "connects");
        brief.send(mark, 1, |_, _| SensorTrack::default()).unwrap();
        drop(brief);
        assert_eq!([look(), look()], [(true, 1), (false, 0)]);
    }

    #[test]
    fn a_listener_that_comes_later_is_woken_and_finds_what_was_sent_before() {
        let folder = tempfile::tempdir().unwrap();
        let root = Root::in_base(folder.path(), "woken").unwrap();
        let bus: Bus<InProcess> = Bus::open(&root, "test").unwrap();
        let topic = messages::sensor_tracks("a");
        let _held = bus.hold(&topic).unwrap();
        let mut subscriber = bus.subscriber(&topic, || 0).unwrap();
        let mut publisher = bus.publisher(&topic, 1).unwrap();
        let mark = Mark {
            progress_ns: 0,
            sent_ns: 0,
            end: false,
        };
        let mut send = || publisher.send(mark, 1, |_, _| SensorTrack::default()).unwrap();
        send();
        let mut waiter = bus.waiter(WaitMode::Event);
        waiter.watch(&bus, &topic).unwrap();
        let day = Duration::from_secs(86_400);
        let woken = waiter
            .wait_at_a_glance((day, None), |_| subscriber.may_have_slices())
            .unwrap();
        assert_eq!((woken, subscriber.take(9, |_, _| ()).unwrap()), (Woken::Work, 1));
        send();
        // Readable: the publisher has notified.
        let mut looks = Vec::new();
        let woken = waiter.wait_at_a_glance((day, None), |look| {
            looks.push(look);
            look == Look::Full
        });
        assert_eq!((woken.unwrap(), looks), (Woken::Work, vec![Look::Glance, Look::Full]));
        assert_eq!(waiter.missed_wake_ups(), 0);
    }
}
