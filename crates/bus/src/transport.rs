//! Transports: shared memory, and the equivalent within a process.
//!
//! iceoryx2 has the same ports over several media, each with or without a lock around every port. Here ports have no
//! lock: a port stays on its thread (a [`Bus`](crate::Bus) may move). The lock would never be contended, but would
//! double the cost of checking an empty topic (90 ns instead of 40), the main work of a spinning process. Programs of
//! users may need ports that move between threads: for these there is a medium with locks (feature `any-thread`),
//! compatible with the first.

use std::fmt::Debug;

use iceoryx2::prelude::{ZeroCopySend, ipc, local};
use messages::layout::Sample;

/// Connects the processes of a machine through shared memory.
pub type SharedMemory = ipc::Service;

/// Connects the threads of a process; nothing is visible outside.
pub type InProcess = local::Service;

/// The same, with a lock around every port, which may then move to another thread.
#[cfg(feature = "any-thread")]
pub type SharedMemoryAnyThread = iceoryx2::prelude::ipc_threadsafe::Service;

/// Sample that a topic can carry: a type declared in the `messages` crate.
pub trait Payload: Sample + ZeroCopySend + Debug + 'static {}

impl<T: Sample + ZeroCopySend + Debug + 'static> Payload for T {}
