//! Plain iceoryx2 ports: the lower bound for everything built on iceoryx2.
//!
//! A measurement of the time added by Koseki's processes needs the transport alone, with the same payload and the same
//! number of hops. These ports have no header, no sequence numbers and no counters: samples are written and read in
//! place. These ports serve measurements only; losses are not counted.

use std::marker::PhantomData;
use std::time::Duration;

use iceoryx2::node::Node;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, EventId, PayloadHeader as _, ServiceName};
use iceoryx2::service::port_factory::{event, publish_subscribe};
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};

use crate::bus::Bus;
use crate::error::BusError;
use crate::ports::{DropGuard, Ports as _};
use crate::quality::{Header, Octets};
use crate::service::{PublisherPort, SubscriberPort, with_open_files};
use crate::transport::{Payload, SharedMemory};
use crate::waiter::BACKSTOP;

type BareSlices = publish_subscribe::PortFactory<SharedMemory, Octets, Header>;
type WakeUps = event::PortFactory<SharedMemory>;

/// Places of a service: a process at each end, and the successor of each.
const ENDS: usize = 2;

/// Settings that both ends must agree upon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BareSettings {
    /// Slices that wait before the oldest is dropped.
    pub depth: usize,
    /// Most samples in a slice.
    pub slice_len: usize,
    /// Whether receivers are woken by events; otherwise receivers poll continually.
    pub events: bool,
}

/// Sends slices, and nothing else.
#[derive(Debug)]
pub struct BareSender<T: Payload> {
    port: DropGuard<PublisherPort<SharedMemory>>,
    notifier: Option<DropGuard<Notifier<SharedMemory>>>,
    service: String,
    samples: PhantomData<fn(T)>,
}

impl<T: Payload> BareSender<T> {
    /// Opens `service`, or creates the service.
    ///
    /// # Errors
    /// If the service exists with other sizes, or cannot be created.
    pub fn open(bus: &Bus<SharedMemory>, service: &str, settings: BareSettings) -> Result<Self, BusError> {
        let (port, notifier) = sender(bus.node(), service, settings, &detail::<T>())?;
        Ok(Self {
            port,
            notifier,
            service: service.to_owned(),
            samples: PhantomData,
        })
    }

    /// Sends a slice of `count` samples, each written in place by `fill`, which receives the sample's index in the
    /// slice.
    ///
    /// # Errors
    /// If iceoryx2 refuses.
    pub fn send(&self, count: usize, mut fill: impl FnMut(usize) -> T) -> Result<(), BusError> {
        let refused = |error: &str| failed(&self.service, "send", error.to_owned());
        let mut place = None;
        SharedMemory::loan(&self.port, count, &mut place).map_err(refused)?;
        let Some(slice) = &mut place else {
            return Err(refused("there is no slice"));
        };
        let first = slice.payload_mut().as_mut_ptr().cast::<T>();
        for index in 0..count {
            let sample = fill(index);
            // SAFETY: the slice has `count` places of the size and alignment of `T`, with which the service was opened.
            unsafe { first.add(index).write(sample) };
        }
        // SAFETY: every sample was written, and the header is empty.
        unsafe { SharedMemory::send(&mut place) }.map_err(refused)?;
        if let Some(notifier) = &self.notifier {
            let _ = notifier.notify();
        }
        Ok(())
    }
}

/// Receives slices, and nothing else.
#[derive(Debug)]
pub struct BareReceiver<T: Payload> {
    port: DropGuard<SubscriberPort<SharedMemory>>,
    listener: Option<DropGuard<Listener<SharedMemory>>>,
    service: String,
    slice_len: usize,
    samples: PhantomData<fn() -> T>,
}

impl<T: Payload> BareReceiver<T> {
    /// Opens `service`, or creates the service.
    ///
    /// # Errors
    /// If the service exists with other sizes, or cannot be created.
    pub fn open(bus: &Bus<SharedMemory>, service: &str, settings: BareSettings) -> Result<Self, BusError> {
        let (port, listener) = receiver(bus.node(), service, settings, &detail::<T>())?;
        Ok(Self {
            port,
            listener,
            service: service.to_owned(),
            slice_len: settings.slice_len,
            samples: PhantomData,
        })
    }

    /// Shows the oldest slice that waits to `visit`; `false` if none does.
    ///
    /// # Errors
    /// If iceoryx2 refuses, or the slice is longer than any.
    pub fn receive(&self, visit: impl FnOnce(&[T])) -> Result<bool, BusError> {
        let received = SharedMemory::receive(&self.port);
        let slice = received.map_err(|error| failed(&self.service, "receive", error.to_string()))?;
        let Some(slice) = slice else { return Ok(false) };
        // Read once: in shared memory the count may change.
        let count = slice.header().number_of_elements() as usize;
        if count > self.slice_len {
            return Err(failed(&self.service, "receive", format!("a slice of {count} samples")));
        }
        // SAFETY: the service was opened with the size and alignment of `T`, each slice has room for `slice_len`
        // samples, and any bits are a valid `T`.
        visit(unsafe { std::slice::from_raw_parts(slice.payload().as_ptr().cast(), count) });
        Ok(true)
    }

    /// Sleeps until something has been sent, at most `time`; without events, returns at once.
    ///
    /// # Errors
    /// If the system refuses to wait.
    pub fn wait(&self, time: Duration) -> Result<(), BusError> {
        self.listener
            .as_deref()
            .map_or(Ok(()), |listener| sleep(listener, time, &self.service))
    }
}

/// Type of the samples, by which iceoryx2 keeps readers of another type away.
fn detail<T: Payload>() -> TypeDetail {
    TypeDetail::new::<T>(TypeVariant::Dynamic)
}

type BareSendPort = (
    DropGuard<PublisherPort<SharedMemory>>,
    Option<DropGuard<Notifier<SharedMemory>>>,
);
type BareReceivePort = (
    DropGuard<SubscriberPort<SharedMemory>>,
    Option<DropGuard<Listener<SharedMemory>>>,
);

fn sender(
    node: &Node<SharedMemory>,
    service: &str,
    settings: BareSettings,
    samples: &TypeDetail,
) -> Result<BareSendPort, BusError> {
    let port = slices(node, service, settings, samples)?
        .publisher_builder()
        .initial_max_slice_len(settings.slice_len)
        .allocation_strategy(AllocationStrategy::Static)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(|error| failed(service, "make a publisher", error.to_string()))?;
    let notifier = || {
        let made = wake_ups(node, service)?.notifier_builder().create();
        made.map(DropGuard::new)
            .map_err(|error| failed(service, "make a notifier", error.to_string()))
    };
    Ok((DropGuard::new(port), settings.events.then(notifier).transpose()?))
}

fn receiver(
    node: &Node<SharedMemory>,
    service: &str,
    settings: BareSettings,
    samples: &TypeDetail,
) -> Result<BareReceivePort, BusError> {
    let port = slices(node, service, settings, samples)?
        .subscriber_builder()
        .create()
        .map_err(|error| failed(service, "make a subscriber", error.to_string()))?;
    let listener = || {
        let made = wake_ups(node, service)?.listener_builder().create();
        made.map(DropGuard::new)
            .map_err(|error| failed(service, "make a listener", error.to_string()))
    };
    Ok((DropGuard::new(port), settings.events.then(listener).transpose()?))
}

fn sleep(listener: &Listener<SharedMemory>, time: Duration, service: &str) -> Result<(), BusError> {
    match listener.timed_wait(|_| (), time.min(BACKSTOP)) {
        Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
        Err(error) => Err(failed(service, "wait", format!("{error:?}"))),
    }
}

fn failed(service: &str, action: &'static str, reason: String) -> BusError {
    BusError::Topic {
        topic: service.into(),
        action,
        reason: with_open_files(reason),
    }
}

fn slices(
    node: &Node<SharedMemory>,
    name: &str,
    settings: BareSettings,
    samples: &TypeDetail,
) -> Result<BareSlices, BusError> {
    let described = node
        .service_builder(&service_name(name)?)
        .publish_subscribe::<Octets>()
        .user_header::<Header>()
        .max_nodes(2 * ENDS)
        .max_publishers(ENDS)
        .max_subscribers(ENDS)
        .subscriber_max_buffer_size(settings.depth)
        .subscriber_max_borrowed_samples(1)
        .enable_safe_overflow(true)
        .history_size(0);
    // SAFETY: both details belong to the types as which both ends write and read these bytes; there is no header.
    let described = unsafe {
        described
            .__internal_set_payload_type_details(samples)
            .__internal_set_user_header_type_details(&TypeDetail::new::<()>(TypeVariant::FixedSize))
    };
    described
        .open_or_create()
        .map_err(|error| failed(name, "open it", error.to_string()))
}

fn wake_ups(node: &Node<SharedMemory>, name: &str) -> Result<WakeUps, BusError> {
    node.service_builder(&service_name(name)?)
        .event()
        .max_nodes(2 * ENDS)
        .max_notifiers(ENDS)
        .max_listeners(ENDS)
        .event_id_max_value(0)
        .disable_deadline()
        .notifier_created_event(EventId::new(0))
        .disable_notifier_dropped_event()
        .disable_notifier_dead_event()
        .open_or_create()
        .map_err(|error| failed(name, "open its wake-ups", error.to_string()))
}

fn service_name(name: &str) -> Result<ServiceName, BusError> {
    ServiceName::new(name).map_err(|error| failed(name, "use its name", format!("{error:?}")))
}
