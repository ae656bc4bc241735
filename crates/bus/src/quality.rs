//! iceoryx2 settings of every topic.
//!
//! iceoryx2 refuses to open a service with larger demands than the creator's, and the defaults (two publishers, buffers
//! of two, a waiting publisher) are unsuitable. Every process that creates or opens a topic therefore uses
//! [`describe_slices`] and [`describe_wake_ups`], with the topic's own [`TopicCapacity`]; no setting has a default
//! value.
//!
//! A topic is two iceoryx2 services of the same name: *slices* (publish-subscribe of `[T]` with a [`BatchHeader`] as
//! user header) and *wake-ups* (events). The services are separate so that spinning and polling readers cost a
//! publisher nothing.

use iceoryx2::node::Node;
use iceoryx2::prelude::{EventId, ServiceName};
use iceoryx2::service::Service as Medium;
use iceoryx2::service::builder::{event, publish_subscribe};
use iceoryx2::service::marker::{CustomHeaderMarker, CustomPayloadMarker};
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};
use messages::{BatchHeader, TopicCapacity, TopicName};

use crate::error::BusError;

/// Type of the samples of a slice in iceoryx2's ports, for all sample types. Ports of this single type are compiled
/// once instead of once per sample type, which was half of each service's compile time. The name, size and alignment
/// of the sample type are checked all the same, and are visible to readers in other languages.
pub(crate) type Octets = [CustomPayloadMarker];

/// Header of a slice, likewise: a [`BatchHeader`].
pub(crate) type Header = CustomHeaderMarker;

/// Most processes that have a topic open at a time: 128 sources, the services, each perhaps twice, and spares.
pub(crate) const NODES_MAX: usize = 384;

/// Publishers of a topic that may leave between two looks of a subscriber without loss: all that there can be.
pub(crate) const LEAVERS_MAX: usize = 192;

/// Slices that a subscriber may keep at a time.
pub const BORROWED_MAX: usize = 2;

/// Slices that a publisher writes at a time.
pub(crate) const LOANED_MAX: usize = 2;

/// Describes the slices of the topic `name` with samples of the type `samples`.
pub(crate) fn describe_slices<S: Medium>(
    node: &Node<S>,
    name: &TopicName,
    capacity: TopicCapacity,
    samples: &TypeDetail,
) -> Result<publish_subscribe::Builder<Octets, Header, S>, BusError> {
    let TopicCapacity {
        depth,
        slice_len: _, // of the publisher, not of the topic
        publishers,
        subscribers,
    } = capacity;
    let header = TypeDetail::new::<BatchHeader>(TypeVariant::FixedSize);
    let described = node
        .service_builder(&service_name(name)?)
        .publish_subscribe::<Octets>()
        .user_header::<Header>()
        .max_nodes(NODES_MAX)
        .max_publishers(publishers)
        .max_subscribers(subscribers)
        .subscriber_max_buffer_size(depth)
        .subscriber_max_borrowed_samples(BORROWED_MAX)
        .enable_safe_overflow(true)
        .history_size(0);
    // SAFETY: both details belong to the types as which `publisher` and `subscriber` write and read these bytes.
    Ok(unsafe {
        described
            .__internal_set_payload_type_details(samples)
            .__internal_set_user_header_type_details(&header)
    })
}

/// Everything about the wake-ups of the topic called `name`.
pub(crate) fn describe_wake_ups<S: Medium>(
    node: &Node<S>,
    name: &TopicName,
    capacity: TopicCapacity,
) -> Result<event::Builder<S>, BusError> {
    Ok(node
        .service_builder(&service_name(name)?)
        .event()
        .max_nodes(NODES_MAX)
        .max_notifiers(capacity.publishers)
        .max_listeners(capacity.subscribers)
        .event_id_max_value(0)
        .disable_deadline()
        // A new publisher wakes waiting readers, so that readers connect before the first slice.
        .notifier_created_event(EventId::new(0))
        .disable_notifier_dropped_event()
        .disable_notifier_dead_event())
}

fn service_name(name: &TopicName) -> Result<ServiceName, BusError> {
    ServiceName::new(name.as_str()).map_err(|error| BusError::Topic {
        topic: name.as_str().into(),
        action: "use its name",
        reason: format!("{error:?}"),
    })
}

/// Slices for which a publisher reserves memory. `capacity.depth` is the longest queue that the topic permits.
///
/// iceoryx2 would reserve `subscribers × (depth + borrowed)`, for subscribers that all hold different slices. Here this
/// is impossible: the waiting slices of a subscriber are always among the last `depth` slices sent, because overflow
/// drops the oldest. Therefore at most `depth` slices wait for all subscribers together, and each subscriber borrows a
/// few more. The second `depth` is for a dead subscriber with an unchanged queue during the removal.
pub(crate) fn reserved_slices(capacity: TopicCapacity) -> usize {
    let shared = 2 * capacity.depth + capacity.subscribers * BORROWED_MAX + LOANED_MAX;
    shared.min(worst_case_slices(capacity))
}

fn worst_case_slices(capacity: TopicCapacity) -> usize {
    capacity.subscribers * (capacity.depth + BORROWED_MAX) + LOANED_MAX
}
