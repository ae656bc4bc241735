//! iceoryx2 as it is: the floor that nothing built on top of it can go below.
//!
//! Whoever measures what Koseki's processes add to the transport needs the transport alone, with the same payload, in
//! the same number of hops. So these ports have no header, no sequence numbers and no counters: what is sent is written
//! in place, what is received is looked at in place, and that is all. They are for measuring; nothing counts what they
//! lose.

use std::time::Duration;

use iceoryx2::node::Node;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, EventId, ServiceName};

use crate::bus::Bus;
use crate::error::BusError;
use crate::transport::{Payload, SharedMemory};
use crate::waiter::BACKSTOP;

/// Places of a service: one process at each end, and their successors.
const ENDS: usize = 2;

/// Settings that both ends must agree upon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BareSettings {
    /// Slices that wait before the oldest is dropped.
    pub depth: usize,
    /// Most samples in a slice.
    pub slice_len: usize,
    /// Whether receivers are woken by events; else they ask again and again.
    pub events: bool,
}

/// Sends slices, and nothing else.
#[derive(Debug)]
pub struct BareSender<T: Payload> {
    port: Publisher<SharedMemory, [T], ()>,
    notifier: Option<Notifier<SharedMemory>>,
    service: String,
}

impl<T: Payload> BareSender<T> {
    /// Opens `service`, or creates it.
    ///
    /// # Errors
    /// If it exists with other sizes, or cannot be created.
    pub fn open(bus: &Bus<SharedMemory>, service: &str, settings: BareSettings) -> Result<Self, BusError> {
        let port = slices::<T>(bus.node(), service, settings)?
            .publisher_builder()
            .initial_max_slice_len(settings.slice_len)
            .allocation_strategy(AllocationStrategy::Static)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|error| failed(service, "make a publisher", error.to_string()))?;
        let notifier = || {
            let made = wake_ups(bus.node(), service)?.notifier_builder().create();
            made.map_err(|error| failed(service, "make a notifier", error.to_string()))
        };
        Ok(Self {
            port,
            notifier: settings.events.then(notifier).transpose()?,
            service: service.to_owned(),
        })
    }

    /// Sends one slice of `count` samples, each written in place by `fill`, which is told its place in the slice.
    ///
    /// # Errors
    /// If iceoryx2 refuses.
    pub fn send(&self, count: usize, fill: impl FnMut(usize) -> T) -> Result<(), BusError> {
        let refused = |error: String| failed(&self.service, "send", error);
        let slice = self.port.loan_slice_uninit(count);
        let slice = slice.map_err(|error| refused(error.to_string()))?;
        let sent = slice.write_from_fn(fill).send();
        sent.map_err(|error| refused(error.to_string()))?;
        if let Some(notifier) = &self.notifier {
            // As in `Publisher::send`: it fails only for services with deadlines.
            let _ = notifier.notify();
        }
        Ok(())
    }
}

/// Receives slices, and nothing else.
#[derive(Debug)]
pub struct BareReceiver<T: Payload> {
    port: Subscriber<SharedMemory, [T], ()>,
    listener: Option<Listener<SharedMemory>>,
    service: String,
}

impl<T: Payload> BareReceiver<T> {
    /// Opens `service`, or creates it.
    ///
    /// # Errors
    /// If it exists with other sizes, or cannot be created.
    pub fn open(bus: &Bus<SharedMemory>, service: &str, settings: BareSettings) -> Result<Self, BusError> {
        let port = slices::<T>(bus.node(), service, settings)?
            .subscriber_builder()
            .create()
            .map_err(|error| failed(service, "make a subscriber", error.to_string()))?;
        let listener = || {
            let made = wake_ups(bus.node(), service)?.listener_builder().create();
            made.map_err(|error| failed(service, "make a listener", error.to_string()))
        };
        Ok(Self {
            port,
            listener: settings.events.then(listener).transpose()?,
            service: service.to_owned(),
        })
    }

    /// Shows the oldest slice that waits to `visit`; `false` if none does.
    ///
    /// # Errors
    /// If iceoryx2 refuses.
    pub fn receive(&self, visit: impl FnOnce(&[T])) -> Result<bool, BusError> {
        let received = self.port.receive();
        let slice = received.map_err(|error| failed(&self.service, "receive", error.to_string()))?;
        Ok(slice.map(|slice| visit(slice.payload())).is_some())
    }

    /// Sleeps until something has been sent, at most `time`; without events, returns at once.
    ///
    /// # Errors
    /// If the system refuses to wait.
    pub fn wait(&self, time: Duration) -> Result<(), BusError> {
        let Some(listener) = &self.listener else {
            return Ok(());
        };
        match listener.timed_wait(|_| (), time.min(BACKSTOP)) {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(error) => Err(failed(&self.service, "wait", format!("{error:?}"))),
        }
    }
}

fn failed(service: &str, action: &'static str, reason: String) -> BusError {
    BusError::Topic {
        topic: service.into(),
        action,
        reason,
    }
}

type Slices<T> = iceoryx2::service::port_factory::publish_subscribe::PortFactory<SharedMemory, [T], ()>;
type WakeUps = iceoryx2::service::port_factory::event::PortFactory<SharedMemory>;

fn slices<T: Payload>(node: &Node<SharedMemory>, name: &str, settings: BareSettings) -> Result<Slices<T>, BusError> {
    node.service_builder(&service_name(name)?)
        .publish_subscribe::<[T]>()
        .max_nodes(2 * ENDS)
        .max_publishers(ENDS)
        .max_subscribers(ENDS)
        .subscriber_max_buffer_size(settings.depth)
        .subscriber_max_borrowed_samples(1)
        .enable_safe_overflow(true)
        .history_size(0)
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
