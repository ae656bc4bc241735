//! Datagrams put together again from the fragments that IP cut them into.
//!
//! Fragments of a datagram have the same addresses and the same identification, and each has its position. Fragments
//! arrive in any order, mixed with fragments of other datagrams, and some are lost. A limited number of datagrams is
//! kept open; a further datagram replaces the oldest.

use std::borrow::Cow;
use std::collections::VecDeque;

use etherparse::IpNumber;
use etherparse::defrag::IpDefragBuf;

use super::packet::{self, Fragment, FragmentKey, Packet};
use super::skipped::{Reason, Skipped};
use super::{RecordedDatagram, TimeStamp};

/// The most fragmented datagrams that are kept open at a time. Senders emit the fragments of one in a burst, so more
/// than one per sender is rare.
pub const FRAGMENTED_MAX: usize = 64;

/// The datagrams of which some fragments have come, the oldest first.
#[derive(Debug, Default)]
pub(super) struct Fragments {
    open: VecDeque<OpenDatagram>,
}

#[derive(Debug)]
struct OpenDatagram {
    key: FragmentKey,
    buffer: IpDefragBuf,
    time_stamp: Option<TimeStamp>,
    /// Place of the first to come in the recording.
    offset: usize,
    fragments: usize,
    /// The captured bytes of their packets.
    octets: usize,
}

impl Fragments {
    /// Adds a fragment. Returns the completed datagram and the number of bytes of all its packets, or the skipped
    /// datagram: the oldest open datagram, or the fragment's own datagram if the fragment contradicts earlier
    /// fragments.
    pub(super) fn add(
        &mut self,
        fragment: &Fragment<'_>,
        packet: &Packet<'_>,
    ) -> Option<Result<(RecordedDatagram<'static>, usize), Skipped>> {
        let mut open = self
            .take(fragment.key)
            .unwrap_or_else(|| OpenDatagram::new(fragment.key, packet));
        open.fragments += 1;
        open.octets += packet.bytes.len();
        if open.buffer.add(fragment.offset, fragment.more, fragment.bytes).is_err() {
            return Some(Err(open.give_up()));
        }
        if open.buffer.is_complete() {
            return Some(open.complete());
        }
        let oldest = (self.open.len() == FRAGMENTED_MAX).then(|| self.open.pop_front());
        self.open.push_back(open);
        oldest.flatten().map(|oldest| Err(oldest.give_up()))
    }

    /// Gives the oldest datagram up, at the end of the recording.
    pub(super) fn give_up(&mut self) -> Option<Skipped> {
        self.open.pop_front().map(OpenDatagram::give_up)
    }

    fn take(&mut self, key: FragmentKey) -> Option<OpenDatagram> {
        let place = self.open.iter().position(|open| open.key == key)?;
        self.open.remove(place)
    }
}

impl OpenDatagram {
    fn new(key: FragmentKey, packet: &Packet<'_>) -> Self {
        Self {
            key,
            buffer: IpDefragBuf::new(IpNumber::UDP, Vec::new(), Vec::new()),
            time_stamp: packet.time_stamp,
            offset: packet.offset,
            fragments: 0,
            octets: 0,
        }
    }

    fn complete(self) -> Result<(RecordedDatagram<'static>, usize), Skipped> {
        let Some(payload) = packet::udp(self.buffer.data()) else {
            return Err(self.give_up());
        };
        let datagram = RecordedDatagram {
            bytes: Cow::Owned(payload.to_vec()),
            time_stamp: self.time_stamp,
            offset: self.offset,
        };
        Ok((datagram, self.octets))
    }

    fn give_up(self) -> Skipped {
        Skipped {
            offset: self.offset,
            octets: self.octets,
            why: Reason::Fragments {
                fragments: self.fragments,
            },
        }
    }
}
