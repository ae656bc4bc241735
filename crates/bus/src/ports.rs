//! Ports of both transports, compiled once.
//!
//! A function generic over the transport is compiled again in every calling crate, with all the iceoryx2 code needed:
//! this was more than half of a service's compile time. A method of a concrete type is compiled with the type.
//! Therefore all iceoryx2 code is called through methods of [`Ports`], and iceoryx2's values are dropped here, too
//! ([`DropGuard`]).

use std::io;
use std::mem::ManuallyDrop;
use std::ops::{Deref, DerefMut};
use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use iceoryx2::node::Node;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::FileDescriptorBased;
use iceoryx2::service::Service as Medium;

use crate::error::BusError;
use crate::root::Root;
use crate::service::{
    self, DeadProcesses, Loan, PublisherPort, Service, Slices, SubscriberPort, TakenSlice, TopicHold, WakeUps,
};
use crate::transport::{InProcess, SharedMemory};

/// The medium of a [`Bus`](crate::Bus). Implemented by the media of this crate, and by nothing else.
pub trait Transport: Ports {
    /// Whether the topics are visible to other processes, so that a process must hold the instance's claim.
    const CROSSES_PROCESSES: bool;
}

/// Operations of iceoryx2, compiled in this crate for both transports.
pub trait Ports: Medium + Sized + 'static {
    #[doc(hidden)]
    fn descriptor(listener: &Listener<Self>) -> BorrowedFd<'_>;
    #[doc(hidden)]
    fn drain(listener: &Listener<Self>) -> io::Result<()>;
    #[doc(hidden)]
    fn join(root: &Root, process: &str, prefix: &str, leavers: usize) -> Result<DropGuard<Node<Self>>, BusError>;
    #[doc(hidden)]
    fn remove_dead(node: &Node<Self>) -> DeadProcesses;
    #[doc(hidden)]
    fn topics(node: &Node<Self>) -> Result<Vec<String>, BusError>;
    #[doc(hidden)]
    fn hold(node: &Node<Self>, service: &Service<'_>) -> Result<TopicHold, BusError>;
    #[doc(hidden)]
    fn publish(node: &Node<Self>, service: &Service<'_>) -> Result<Sending<Self>, BusError>;
    #[doc(hidden)]
    fn subscribe(node: &Node<Self>, service: &Service<'_>, queue: usize) -> Result<Receiving<Self>, BusError>;
    #[doc(hidden)]
    fn listen(node: &Node<Self>, service: &Service<'_>) -> Result<DropGuard<Listener<Self>>, BusError>;
    #[doc(hidden)]
    fn loan(
        port: &PublisherPort<Self>,
        length: usize,
        place: &mut Option<DropGuard<Loan<Self>>>,
    ) -> Result<(), &'static str>;
    /// # Safety
    /// Every sample and the header of the slice in `place` must have been written.
    #[doc(hidden)]
    unsafe fn send(place: &mut Option<DropGuard<Loan<Self>>>) -> Result<(), &'static str>;
    /// Wakes the listeners. Returns whether there are any.
    #[doc(hidden)]
    fn wake(wake_ups: &WakeUps<Self>) -> bool;
    #[doc(hidden)]
    fn has_subscribers(slices: &Slices<Self>) -> bool;
    #[doc(hidden)]
    fn receive(port: &SubscriberPort<Self>) -> Result<Option<DropGuard<TakenSlice<Self>>>, ReceiveError>;
    #[doc(hidden)]
    fn has_slices(port: &SubscriberPort<Self>) -> bool;
}

/// Ports and topic behind a publisher, iceoryx2's numbers of the process and of the port, and a counter of failed
/// connections.
#[derive(Debug)]
pub struct Sending<S: Medium> {
    pub(crate) node: u128,
    pub(crate) origin: u128,
    pub(crate) port: DropGuard<PublisherPort<S>>,
    pub(crate) slices: DropGuard<Slices<S>>,
    pub(crate) wake_ups: DropGuard<WakeUps<S>>,
    pub(crate) failed_connections: Arc<AtomicU64>,
}

/// The port behind a subscriber, and a counter of failed connections.
#[derive(Debug)]
pub struct Receiving<S: Medium> {
    pub(crate) port: DropGuard<SubscriberPort<S>>,
    pub(crate) failed_connections: Arc<AtomicU64>,
}

/// A value that is always dropped by code of this crate.
#[derive(Debug)]
pub struct DropGuard<T> {
    value: ManuallyDrop<T>,
    end: unsafe fn(&mut ManuallyDrop<T>),
}

impl<T> DropGuard<T> {
    /// Keeps `value`. Called where `T` is a concrete type: there the drop is compiled.
    pub(crate) fn new(value: T) -> Self {
        Self {
            value: ManuallyDrop::new(value),
            end: ManuallyDrop::drop,
        }
    }

    pub(crate) fn into_inner(self) -> T {
        let mut kept = ManuallyDrop::new(self);
        // SAFETY: `kept` is neither used nor dropped afterwards.
        unsafe { ManuallyDrop::take(&mut kept.value) }
    }
}

impl<T> Deref for DropGuard<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for DropGuard<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.value
    }
}

impl<T> Drop for DropGuard<T> {
    fn drop(&mut self) {
        // SAFETY: `end` drops the value in place, once: nothing but this and `into_inner`, which keeps this from
        // running, takes the value away.
        unsafe { (self.end)(&mut self.value) }
    }
}

/// Listeners of both transports have a descriptor, but only the concrete types give access to the descriptor.
macro_rules! transport {
    ($name:ty, $crosses:literal) => {
        impl Transport for $name {
            const CROSSES_PROCESSES: bool = $crosses;
        }

        impl Ports for $name {
            fn descriptor(listener: &Listener<Self>) -> BorrowedFd<'_> {
                // SAFETY: the listener keeps the descriptor open and unchanged during the listener's life, and the
                // result cannot outlive the borrow of the listener.
                unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
            }

            fn drain(listener: &Listener<Self>) -> io::Result<()> {
                service::drain(listener)
            }

            fn join(
                root: &Root,
                process: &str,
                prefix: &str,
                leavers: usize,
            ) -> Result<DropGuard<Node<Self>>, BusError> {
                service::join(root, process, prefix, leavers).map(DropGuard::new)
            }

            fn remove_dead(node: &Node<Self>) -> DeadProcesses {
                service::remove_dead(node)
            }

            fn topics(node: &Node<Self>) -> Result<Vec<String>, BusError> {
                service::topics(node)
            }

            fn hold(node: &Node<Self>, service: &Service<'_>) -> Result<TopicHold, BusError> {
                service.hold(node)
            }

            fn publish(node: &Node<Self>, service: &Service<'_>) -> Result<Sending<Self>, BusError> {
                let (port, slices, failed_connections) = service.publisher(node)?;
                // After the port: making the notifier wakes subscribers, which then connect to the port.
                let wake_ups = DropGuard::new(service.wake_ups(node)?);
                Ok(Sending {
                    node: node.id().value(),
                    origin: port.id().value(),
                    port: DropGuard::new(port),
                    slices: DropGuard::new(slices),
                    wake_ups,
                    failed_connections,
                })
            }

            fn subscribe(node: &Node<Self>, service: &Service<'_>, queue: usize) -> Result<Receiving<Self>, BusError> {
                let (port, failed_connections) = service.subscriber(node, queue)?;
                Ok(Receiving {
                    port: DropGuard::new(port),
                    failed_connections,
                })
            }

            fn listen(node: &Node<Self>, service: &Service<'_>) -> Result<DropGuard<Listener<Self>>, BusError> {
                service.listener(node).map(DropGuard::new)
            }

            // Loans have some two hundred bytes: moves are kept to a minimum.
            fn loan(
                port: &PublisherPort<Self>,
                length: usize,
                place: &mut Option<DropGuard<Loan<Self>>>,
            ) -> Result<(), &'static str> {
                *place = Some(DropGuard::new(service::loan(port, length)?));
                Ok(())
            }

            unsafe fn send(place: &mut Option<DropGuard<Loan<Self>>>) -> Result<(), &'static str> {
                match place.take() {
                    // SAFETY: as asked for.
                    Some(slice) => unsafe { service::send(slice.into_inner()) },
                    None => Err("there is no slice"),
                }
            }

            fn wake(wake_ups: &WakeUps<Self>) -> bool {
                service::wake(wake_ups)
            }

            fn has_subscribers(slices: &Slices<Self>) -> bool {
                service::has_subscribers(slices)
            }

            fn receive(port: &SubscriberPort<Self>) -> Result<Option<DropGuard<TakenSlice<Self>>>, ReceiveError> {
                Ok(service::receive(port)?.map(DropGuard::new))
            }

            fn has_slices(port: &SubscriberPort<Self>) -> bool {
                // The next take returns the error.
                port.has_samples().unwrap_or(true)
            }
        }
    };
}

transport!(SharedMemory, true);
#[cfg(feature = "any-thread")]
transport!(crate::transport::SharedMemoryAnyThread, true);
transport!(InProcess, false);

#[cfg(test)]
mod tests {
    use std::rc::Rc;

    use super::*;

    #[test]
    fn kept_value_is_dropped_once_or_handed_back() {
        let value = Rc::new(7);
        drop(DropGuard::new(Rc::clone(&value)));
        assert_eq!(Rc::strong_count(&value), 1);
        let handed_back = DropGuard::new(Rc::clone(&value)).into_inner();
        assert_eq!(Rc::strong_count(&value), 2);
        drop(handed_back);
        assert_eq!(Rc::strong_count(&value), 1);
    }
}
