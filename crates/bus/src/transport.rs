//! Shared memory, and its twin within one process.
//!
//! iceoryx2 has the same ports over several media, and each with or without a lock around every port. Here they have
//! none: a port stays on the thread that made it (a [`Bus`](crate::Bus) may move). The lock would never be contended,
//! but makes asking an empty topic for work twice as expensive (90 ns instead of 40), and a spinning process does
//! little else.

use std::fmt::Debug;

use iceoryx2::prelude::{ZeroCopySend, ipc, local};
use messages::layout::Sample;

/// Connects the processes of one machine through shared memory.
pub type SharedMemory = ipc::Service;

/// Connects the threads of one process; nothing exists outside of it.
pub type InProcess = local::Service;

/// Sample that a topic can carry: one declared in the `messages` crate.
pub trait Payload: Sample + ZeroCopySend + Debug + 'static {}

impl<T: Sample + ZeroCopySend + Debug + 'static> Payload for T {}
