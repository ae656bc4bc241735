//! Waiting for sockets.

use std::io;
use std::os::fd::BorrowedFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// Waits until `socket` is ready for any of `events`. Returns `false` after `timeout`, or at a signal, so that the
/// caller can end at once.
pub(crate) fn ready(socket: BorrowedFd<'_>, events: PollFlags, timeout: Duration) -> io::Result<bool> {
    wait(&mut [PollFd::from_borrowed_fd(socket, events)], timeout)
}

/// Lets `timeout` pass, or less if a signal comes.
pub(crate) fn pause(timeout: Duration) -> io::Result<()> {
    wait(&mut [], timeout).map(|_| ())
}

/// Waits for several sockets, each with separate events; marks the events that occurred.
pub(crate) fn wait(descriptors: &mut [PollFd<'_>], timeout: Duration) -> io::Result<bool> {
    // A time that does not fit is longer than any machine runs.
    let timeout = Timespec::try_from(timeout).unwrap_or(Timespec {
        tv_sec: i64::MAX / 2,
        tv_nsec: 0,
    });
    match poll(descriptors, Some(&timeout)) {
        Ok(count) => Ok(count > 0),
        Err(Errno::INTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}
