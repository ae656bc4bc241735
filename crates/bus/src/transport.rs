//! Shared memory, and its twin within one process.
//!
//! iceoryx2 has the same ports over several media, and each with or without a lock around every port. Here they have
//! none: a port stays on the thread that made it (a [`Bus`](crate::Bus) may move). The lock would never be contended,
//! but makes asking an empty topic for work twice as expensive (90 ns instead of 40), and a spinning process does
//! little else. Programs of others may not be built so: for them there is a medium with locks (feature `any-thread`),
//! whose ports meet those of the first one.

use std::fmt::Debug;

use iceoryx2::prelude::{ZeroCopySend, ipc, local};
use messages::layout::Sample;

/// Connects the processes of one machine through shared memory.
pub type SharedMemory = ipc::Service;

/// Connects the threads of one process; nothing exists outside of it.
pub type InProcess = local::Service;

/// The same, with a lock around every port, which may then move to another thread.
#[cfg(feature = "any-thread")]
pub type SharedMemoryAnyThread = iceoryx2::prelude::ipc_threadsafe::Service;

/// Sample that a topic can carry: one declared in the `messages` crate.
pub trait Payload: Sample + ZeroCopySend + Debug + 'static {}

impl<T: Sample + ZeroCopySend + Debug + 'static> Payload for T {}
