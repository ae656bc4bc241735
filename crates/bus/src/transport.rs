//! Shared memory, and its twin within one process.
//!
//! iceoryx2 has the same ports over several media, and each with or without a lock around every port. Here they have
//! none: a port stays on the thread that made it (a [`Bus`](crate::Bus) may move). The lock would never be contended,
//! but makes asking an empty topic for work twice as expensive (90 ns instead of 40), and a spinning process does
//! little else.

use std::fmt::Debug;
use std::os::fd::BorrowedFd;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::{FileDescriptorBased, ZeroCopySend, ipc, local};
use messages::layout::Sample;

/// Connects the processes of one machine through shared memory.
pub type SharedMemory = ipc::Service;

/// Connects the threads of one process; nothing exists outside of it.
pub type InProcess = local::Service;

/// The medium of a [`Bus`](crate::Bus). Implemented by [`SharedMemory`] and [`InProcess`], and by nothing else.
pub trait Transport: iceoryx2::service::Service + sealed::Sealed + 'static {
    /// Whether other processes can see the topics, so that one of them must hold the instance's claim.
    const CROSSES_PROCESSES: bool;

    /// Descriptor that becomes readable when `listener` is notified.
    #[doc(hidden)]
    fn descriptor(listener: &Listener<Self>) -> BorrowedFd<'_>;
}

/// Sample that a topic can carry: one declared in the `messages` crate.
pub trait Payload: Sample + ZeroCopySend + Debug + 'static {}

impl<T: Sample + ZeroCopySend + Debug + 'static> Payload for T {}

mod sealed {
    pub trait Sealed {}
}

/// Both transports' listeners have a descriptor, but only their concrete types say so.
macro_rules! transport {
    ($name:ident, $crosses:literal) => {
        impl sealed::Sealed for $name {}

        impl Transport for $name {
            const CROSSES_PROCESSES: bool = $crosses;

            fn descriptor(listener: &Listener<Self>) -> BorrowedFd<'_> {
                // SAFETY: the listener keeps its descriptor open and unchanged as long as it lives, and the result
                // cannot outlive the borrow of the listener.
                unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
            }
        }
    };
}

transport!(SharedMemory, true);
transport!(InProcess, false);
