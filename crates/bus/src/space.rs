//! Check of the room in shared memory.
//!
//! Memory in `/dev/shm` is allocated page by page at the first write; a write to an unavailable page kills the writer
//! with SIGBUS, without an error or a message. Therefore the creator of topics first checks the room for the largest
//! size of these topics.

use std::path::Path;

use messages::{BatchHeader, Topic};

use crate::error::BusError;
use crate::log::log_bytes;
use crate::quality::{NODES_MAX, reserved_slices};
use crate::seal::SHARED_MEMORY_DIR;
use crate::transport::Payload;

/// iceoryx2's own header of a slice, with padding (rounded up).
const SLICE_HEADER_BYTES: usize = 64;
/// Lists of ports and processes of a topic: bytes for each place (rounded up).
const PLACE_BYTES: usize = 256;
/// Bytes of a connection's queues for each slice that can wait in the queues (rounded up).
const QUEUE_ENTRY_BYTES: usize = 32;
/// Fixed part of each file in shared memory, with the rounding to whole pages.
const FILE_BYTES: usize = 8192;

/// Returns the largest size of `topic` in shared memory with this number of `publishers`, bytes; a dead publisher
/// counts until the removal. `topic.capacity.publishers` gives the worst case; most topics have a single publisher, and
/// two during a restart.
pub fn needed_bytes<T>(topic: &Topic<T>, publishers: usize) -> u64 {
    let capacity = topic.capacity;
    let slice = SLICE_HEADER_BYTES + size_of::<BatchHeader>() + capacity.slice_len * size_of::<T>();
    let publisher = FILE_BYTES + reserved_slices(capacity) * slice;
    let connection = FILE_BYTES + (2 * capacity.depth + reserved_slices(capacity)) * QUEUE_ENTRY_BYTES;
    let lists = 2 * (NODES_MAX + capacity.publishers + capacity.subscribers) * PLACE_BYTES;
    let listeners = capacity.subscribers * FILE_BYTES;
    (publishers * (publisher + capacity.subscribers * connection) + lists + listeners + 3 * FILE_BYTES) as u64
}

/// Bytes that the log of `topic` takes in shared memory.
pub fn needed_log_bytes<T: Payload>(topic: &Topic<T>) -> u64 {
    (FILE_BYTES + log_bytes(topic)) as u64
}

/// Bytes that are free in shared memory.
///
/// # Errors
/// If the system call fails.
pub fn free_space() -> Result<u64, BusError> {
    let path = Path::new(SHARED_MEMORY_DIR);
    let answer = rustix::fs::statvfs(path).map_err(|error| BusError::Io {
        action: "ask for the free space of",
        path: path.into(),
        source: error.into(),
    })?;
    Ok(answer.f_bavail * answer.f_frsize)
}

/// Makes sure that `needed` bytes (the sum of [`needed_bytes`]) are free.
///
/// # Errors
/// [`BusError::Space`] with both numbers if not.
pub fn check_space(needed: u64) -> Result<(), BusError> {
    let free = free_space()?;
    if free < needed {
        return Err(BusError::Space {
            path: SHARED_MEMORY_DIR.into(),
            needed,
            free,
        });
    }
    Ok(())
}
