//! Topics as iceoryx2 services: creation, opening, sending, taking and waking.
//!
//! These functions are generic over iceoryx2's media, and a caller compiles all the iceoryx2 code needed. Therefore
//! only [`ports`](crate::ports) calls them, once for each medium.

use std::any::Any;
use std::io;
use std::mem::MaybeUninit;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::listener::{Listener, ListenerCreateError, ListenerWaitError};
use iceoryx2::port::notifier::{Notifier, NotifierCreateError};
use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::port::{DegradationAction, LoanError, ReceiveError, SendError};
use iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, CallbackProgression, NodeName, PortFactory as _, SignalHandlingMode,
};
use iceoryx2::sample_mut_uninit::SampleMutUninit;
use iceoryx2::service::Service as Medium;
use iceoryx2::service::builder::event::{EventCreateError, EventOpenError, EventOpenOrCreateError};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError, PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::marker::CustomPayloadMarker;
use iceoryx2::service::port_factory::{event, publish_subscribe};
use iceoryx2::service::static_config::message_type_details::TypeDetail;
use messages::{TopicCapacity, TopicName};

use crate::error::{BusError, PortRole};
use crate::quality::{Header, LOANED_MAX, NODES_MAX, Octets, describe_slices, describe_wake_ups, reserved_slices};
use crate::root::{Root, tame_logging};

/// Sends slices of bytes.
pub(crate) type PublisherPort<S> = iceoryx2::port::publisher::Publisher<S, Octets, Header>;
/// Takes slices of bytes.
pub(crate) type SubscriberPort<S> = iceoryx2::port::subscriber::Subscriber<S, Octets, Header>;
/// Wakes the waiting readers of a topic.
#[derive(Debug)]
pub struct WakeUps<S: Medium> {
    notifier: Notifier<S>,
    service: event::PortFactory<S>,
}

/// A slice that has been taken.
pub(crate) type TakenSlice<S> = iceoryx2::sample::Sample<S, Octets, Header>;
/// A slice that is to be written.
pub(crate) type Loan<S> = SampleMutUninit<S, [MaybeUninit<CustomPayloadMarker>], Header>;
/// The topic itself, with its readers.
pub(crate) type Slices<S> = publish_subscribe::PortFactory<S, Octets, Header>;
/// Port of a publisher, the topic, and a counter of failed connections.
type OpenedPublisher<S> = (PublisherPort<S>, Slices<S>, Arc<AtomicU64>);

/// Pause between two tries.
const OPEN_PAUSE: Duration = Duration::from_millis(10);
/// Largest number of attempts to drain a listener: a publisher without pauses must not block the reader.
const DRAIN_MAX: usize = 16;

/// Joins the instance as `process`; subscribers keep the unread slices of `leavers` ended publishers. Names of memory
/// begin with `prefix`.
///
/// # Errors
/// As [`Bus::open`](crate::Bus::open).
pub(crate) fn join<S: Medium>(root: &Root, process: &str, prefix: &str, leavers: usize) -> Result<Node<S>, BusError> {
    tame_logging();
    let refused = |reason: String| BusError::Join {
        process: process.to_owned(),
        instance: root.instance().to_owned(),
        path: root.path().to_owned(),
        reason,
    };
    let name = NodeName::new(process).map_err(|error| refused(format!("{error:?}")))?;
    NodeBuilder::new()
        .name(&name)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .config(&root.config(prefix, leavers)?)
        .create::<S>()
        .map_err(|error| refused(error.to_string()))
}

/// Names of the topics that exist, in order.
///
/// # Errors
/// If the instance's files cannot be read.
pub(crate) fn topics<S: Medium>(node: &Node<S>) -> Result<Vec<String>, BusError> {
    let mut names = Vec::new();
    let listed = S::list(node.config(), |service| {
        names.push(service.static_details.name().to_string());
        CallbackProgression::Continue
    });
    listed.map_err(|error| BusError::Topic {
        topic: "*".into(),
        action: "list the topics",
        reason: format!("{error:?}"),
    })?;
    // A topic is a service of slices and a service of wake-ups.
    names.sort_unstable();
    names.dedup();
    Ok(names)
}

/// Takes back the memory and the places of processes that died without leaving.
pub(crate) fn remove_dead<S: Medium>(node: &Node<S>) -> DeadProcesses {
    let state = node.try_cleanup_dead_nodes();
    DeadProcesses {
        removed: state.cleanups,
        failed: state.failed_cleanups,
    }
}

/// A topic in iceoryx2's view: bytes, and the sample type.
#[derive(Debug)]
pub struct Service<'a> {
    pub(crate) name: &'a TopicName,
    pub(crate) capacity: TopicCapacity,
    pub(crate) samples: TypeDetail,
    /// Duration of the attempts to open a topic that does not exist (yet).
    pub(crate) patience: Duration,
}

impl Service<'_> {
    /// Creates the topic, or opens an existing topic, and keeps the topic in existence during the life of the result.
    pub(crate) fn hold<S: Medium + 'static>(&self, node: &Node<S>) -> Result<TopicHold, BusError> {
        let slices = describe_slices(node, self.name, self.capacity, &self.samples)?
            .open_or_create()
            .map_err(|error| held_slices_error(error, self.name))?;
        let wake_ups = describe_wake_ups(node, self.name, self.capacity)?
            .open_or_create()
            .map_err(|error| held_wake_ups_error(error, self.name))?;
        Ok(TopicHold {
            topic: self.name.as_str().into(),
            _services: Box::new((slices, wake_ups)),
        })
    }

    /// The port of a publisher, the topic, and a counter of failed connections.
    pub(crate) fn publisher<S: Medium>(&self, node: &Node<S>) -> Result<OpenedPublisher<S>, BusError> {
        let slices = self.open_slices(node)?;
        let failed_connections = Arc::new(AtomicU64::new(0));
        // The topic's creator may have permitted longer queues than this process.
        let reserved = reserved_slices(TopicCapacity {
            depth: longest_queue(&slices),
            ..self.capacity
        });
        let make = || {
            let counter = Arc::clone(&failed_connections);
            slices
                .publisher_builder()
                .initial_max_slice_len(self.capacity.slice_len)
                .allocation_strategy(AllocationStrategy::Static)
                .max_loaned_samples(LOANED_MAX)
                .override_sample_preallocation(move |_| reserved)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                // A damaged subscriber must not affect the others: the failure is counted, and sending continues.
                .set_degradation_handler(move |_, _| {
                    counter.fetch_add(1, Ordering::Relaxed);
                    DegradationAction::Ignore
                })
                .create()
        };
        let port = in_place(node, make, |error| match error {
            PublisherCreateError::ExceedsMaxSupportedPublishers => self.full(PortRole::Publisher),
            error => topic_error(self.name, "make a publisher", error),
        })?;
        Ok((port, slices, failed_connections))
    }

    /// The port of a subscriber with a queue of `queue` slices, and a counter of failed connections.
    pub(crate) fn subscriber<S: Medium>(
        &self,
        node: &Node<S>,
        queue: usize,
    ) -> Result<(SubscriberPort<S>, Arc<AtomicU64>), BusError> {
        let slices = self.open_slices(node)?;
        let limit = longest_queue(&slices);
        if !(1..=limit).contains(&queue) {
            return Err(BusError::Queue {
                topic: self.name.as_str().into(),
                queue,
                limit,
            });
        }
        let failed_connections = Arc::new(AtomicU64::new(0));
        let make = || {
            let counter = Arc::clone(&failed_connections);
            slices
                .subscriber_builder()
                .buffer_size(queue)
                // A publisher that died during connection must not affect the others: the failure is counted, and
                // reading continues.
                .set_degradation_handler(move |_, _| {
                    counter.fetch_add(1, Ordering::Relaxed);
                    DegradationAction::Ignore
                })
                .create()
        };
        let port = in_place(node, make, |error| match error {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => self.full(PortRole::Subscriber),
            error => topic_error(self.name, "make a subscriber", error),
        })?;
        Ok((port, failed_connections))
    }

    pub(crate) fn wake_ups<S: Medium>(&self, node: &Node<S>) -> Result<WakeUps<S>, BusError> {
        let service = self.open_wake_ups(node)?;
        let notifier = in_place(
            node,
            || service.notifier_builder().create(),
            |error| match error {
                NotifierCreateError::ExceedsMaxSupportedNotifiers => self.full(PortRole::Publisher),
                error => topic_error(self.name, "make a notifier", error),
            },
        )?;
        Ok(WakeUps { notifier, service })
    }

    pub(crate) fn listener<S: Medium>(&self, node: &Node<S>) -> Result<Listener<S>, BusError> {
        let wake_ups = self.open_wake_ups(node)?;
        in_place(
            node,
            || wake_ups.listener_builder().create(),
            |error| match error {
                ListenerCreateError::ExceedsMaxSupportedListeners => self.full(PortRole::Listener),
                error => topic_error(self.name, "make a listener", error),
            },
        )
    }

    fn open_slices<S: Medium>(&self, node: &Node<S>) -> Result<Slices<S>, BusError> {
        self.patiently(|| {
            let opened = describe_slices(node, self.name, self.capacity, &self.samples)?.open();
            opened.map_err(|error| slices_error(error, self.name))
        })
    }

    fn open_wake_ups<S: Medium>(&self, node: &Node<S>) -> Result<event::PortFactory<S>, BusError> {
        self.patiently(|| {
            let opened = describe_wake_ups(node, self.name, self.capacity)?.open();
            opened.map_err(|error| wake_ups_error(error, self.name))
        })
    }

    fn full(&self, role: PortRole) -> BusError {
        let limit = match role {
            PortRole::Publisher => self.capacity.publishers,
            _ => self.capacity.subscribers,
        };
        full_error(self.name, role, limit)
    }

    /// Tries until success, a final failure, or the end of the patience.
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
}

/// Slices that the queue of a subscriber may have: set by the creator of the topic.
fn longest_queue<S: Medium>(slices: &Slices<S>) -> usize {
    slices.static_config().subscriber_max_buffer_size()
}

/// Creates a port. If all places are taken, removes dead processes, and tries once more.
fn in_place<S: Medium, P, E>(
    node: &Node<S>,
    make: impl Fn() -> Result<P, E>,
    explain: impl Fn(E) -> BusError,
) -> Result<P, BusError> {
    match make().map_err(&explain) {
        Err(BusError::Full { .. }) => {
            remove_dead(node);
            make().map_err(&explain)
        }
        result => result,
    }
}

/// Keeps a topic in existence.
#[derive(Debug)]
#[must_use = "the topic is held only as long as this lives"]
pub struct TopicHold {
    topic: Arc<str>,
    _services: Box<dyn Any + Send>,
}

impl TopicHold {
    /// Name of the topic.
    pub fn topic(&self) -> &str {
        &self.topic
    }
}

/// Outcome of [`crate::Bus::remove_dead`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeadProcesses {
    /// Number of removed dead processes.
    pub removed: u64,
    /// Dead processes with remains that could not be removed; another process may be removing the same. Try again.
    pub failed: u64,
}

/// A slice of `length` samples, to be written.
pub(crate) fn loan<S: Medium>(port: &PublisherPort<S>, length: usize) -> Result<Loan<S>, &'static str> {
    // SAFETY: samples travel as slices, so any number of samples may be requested.
    unsafe { port.loan_custom_payload(length) }.map_err(loan_reason)
}

/// Sends a slice.
///
/// # Safety
/// Every sample and the header must have been written.
pub(crate) unsafe fn send<S: Medium>(slice: Loan<S>) -> Result<(), &'static str> {
    // SAFETY: as asked for.
    let slice = unsafe { slice.assume_init() };
    slice.send().map(|_| ()).map_err(send_reason)
}

/// Wakes the waiting readers. Returns whether there are any.
pub(crate) fn wake<S: Medium>(wake_ups: &WakeUps<S>) -> bool {
    let has_listeners = wake_ups.service.dynamic_config().number_of_listeners() > 0;
    if has_listeners {
        // Notifying fails only for services with deadlines, which ours are not. A wake-up that does not arrive delays a
        // subscriber (see the waiter), but loses nothing.
        let _ = wake_ups.notifier.notify();
    }
    has_listeners
}

/// Whether a topic has subscribers.
pub(crate) fn has_subscribers<S: Medium>(slices: &Slices<S>) -> bool {
    slices.dynamic_config().number_of_subscribers() > 0
}

/// The next slice of the queue.
pub(crate) fn receive<S: Medium>(port: &SubscriberPort<S>) -> Result<Option<TakenSlice<S>>, ReceiveError> {
    port.receive()
}

/// Removes all notifications: until two attempts in a row find none (see the head of `waiter`).
pub(crate) fn drain<S: Medium>(listener: &Listener<S>) -> Result<(), io::Error> {
    let mut in_a_row = 0;
    for _ in 0..DRAIN_MAX {
        match listener.try_wait(|_| ()) {
            Ok(0) if in_a_row == 1 => return Ok(()),
            Ok(0) => in_a_row = 1,
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => in_a_row = 0,
            Err(error) => return Err(io::Error::other(format!("{error:?}"))),
        }
    }
    Ok(())
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

fn topic_error(topic: &TopicName, action: &'static str, error: impl ToString) -> BusError {
    BusError::Topic {
        topic: topic.as_str().into(),
        action,
        reason: with_open_files(error.to_string()),
    }
}

/// Descriptors of which a process needs some more for any port.
const SPARE_FILES: u64 = 32;

/// Adds to `reason` that the process has hardly a descriptor left, if so: iceoryx2 reports an internal failure.
pub(crate) fn with_open_files(reason: String) -> String {
    let Some(limit) = rustix::process::getrlimit(rustix::process::Resource::Nofile).current else {
        return reason;
    };
    // Without any descriptor left, the folder cannot be read.
    let open = std::fs::read_dir("/proc/self/fd").map_or(limit, |open| open.count() as u64);
    match open + SPARE_FILES > limit {
        true => format!(
            "{reason} (this process may have {limit} files open, and has {open}: raise `ulimit -n`, or LimitNOFILE of a \
             unit)"
        ),
        false => reason,
    }
}

fn full_error(topic: &TopicName, role: PortRole, limit: usize) -> BusError {
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
        E::ExceedsMaxNumberOfNodes => full_error(topic, PortRole::Process, NODES_MAX),
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
        E::ExceedsMaxNumberOfNodes => full_error(topic, PortRole::Process, NODES_MAX),
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
