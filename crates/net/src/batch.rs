//! Many datagrams with a single system call.
//!
//! `recvmmsg(2)` fills a row of buffers at once. For every datagram the call also returns the sender's address, the
//! number of bytes, and *control messages*: here the kernel's time stamp and the count of drops. The buffers are in a
//! single allocation with the lifetime of the socket. The headers that point to the buffers are written again before
//! each call, because the kernel overwrites the lengths. A reused header would offer the second datagram only as much
//! room for control messages as the first datagram filled; the count of drops, absent while zero, would then never
//! arrive. (The wrapper of the crate `nix` 0.31 reuses headers; therefore this module makes the call itself.)
//!
//! Addresses and control messages are plain bytes in a documented layout (ip(7), ipv6(7), cmsg(3)), and are read as
//! such.

#![allow(unsafe_code)]

use std::io;
use std::mem;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, SocketAddrV4, SocketAddrV6};
use std::os::fd::{AsRawFd, BorrowedFd};
use std::ptr;

use nix::libc;

/// Most datagrams that a single call takes.
pub const BATCH_MAX: usize = 32;

/// Room for an address: that of `sockaddr_in6`, the longer of the two.
const NAME_OCTETS: usize = 28;
/// Room for control messages: a `timespec` and a `u32`, each behind a header of 16 bytes and padded to 8.
const CONTROL_OCTETS: usize = 32 + 24;
/// Length and kind of a control message.
const CONTROL_HEADER_OCTETS: usize = 16;

/// Buffers for the datagrams of a single call.
#[derive(Debug)]
pub(crate) struct Batch {
    octets: Box<[u8]>,
    octets_each: usize,
    names: Box<[[u8; NAME_OCTETS]; BATCH_MAX]>,
    controls: Box<[[u8; CONTROL_OCTETS]; BATCH_MAX]>,
    taken: [BufferUse; BATCH_MAX],
}

/// Share of the buffers that a datagram fills.
#[derive(Clone, Copy, Debug, Default)]
struct BufferUse {
    octets: usize,
    name_octets: usize,
    control_octets: usize,
    cut: bool,
}

/// A datagram as taken from the socket.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RawDatagram<'a> {
    pub(crate) bytes: &'a [u8],
    /// Whether the datagram was longer than the buffer.
    pub(crate) cut: bool,
    pub(crate) sender: Option<SocketAddr>,
    pub(crate) control: Control,
}

/// The kernel's control messages of a datagram.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Control {
    /// Time of arrival, UTC, nanoseconds.
    pub(crate) received_utc_ns: Option<i64>,
    /// Datagrams dropped between the opening of the socket and the arrival of this datagram; absent while there are no
    /// drops.
    pub(crate) dropped: Option<u32>,
}

impl Batch {
    pub(crate) fn new(octets_each: usize) -> Self {
        Self {
            octets: vec![0; octets_each * BATCH_MAX].into_boxed_slice(),
            octets_each,
            names: Box::new([[0; NAME_OCTETS]; BATCH_MAX]),
            controls: Box::new([[0; CONTROL_OCTETS]; BATCH_MAX]),
            taken: [BufferUse::default(); BATCH_MAX],
        }
    }

    /// Takes up to [`BATCH_MAX`] waiting datagrams from `socket` without waiting; returns the number taken.
    pub(crate) fn take(&mut self, socket: BorrowedFd<'_>) -> io::Result<usize> {
        const NO_SLOT: libc::iovec = libc::iovec {
            iov_base: ptr::null_mut(),
            iov_len: 0,
        };
        let mut slots = [NO_SLOT; BATCH_MAX];
        // SAFETY: a C structure of numbers and pointers, for which zeros and null pointers are values. The structure
        // cannot be written out field by field, because some C libraries have private padding.
        let mut headers: [libc::mmsghdr; BATCH_MAX] = unsafe { mem::zeroed() };
        let octets = self.octets.chunks_exact_mut(self.octets_each);
        let buffers = octets.zip(self.names.iter_mut()).zip(self.controls.iter_mut());
        for ((slot, header), ((octets, name), control)) in slots.iter_mut().zip(&mut headers).zip(buffers) {
            slot.iov_base = octets.as_mut_ptr().cast();
            slot.iov_len = octets.len();
            header.msg_hdr.msg_name = name.as_mut_ptr().cast();
            header.msg_hdr.msg_namelen = NAME_OCTETS as libc::socklen_t;
            header.msg_hdr.msg_iov = slot;
            header.msg_hdr.msg_iovlen = 1;
            header.msg_hdr.msg_control = control.as_mut_ptr().cast();
            header.msg_hdr.msg_controllen = CONTROL_OCTETS as _;
        }
        // SAFETY: `headers` has BATCH_MAX initialised headers, and each points to buffers of the stated lengths. `self`
        // and this function own the buffers, nothing else borrows the buffers, and the buffers outlive the call; the
        // kernel keeps no pointer. A null timeout is allowed.
        let taken = unsafe {
            libc::recvmmsg(
                socket.as_raw_fd(),
                headers.as_mut_ptr(),
                BATCH_MAX as libc::c_uint,
                libc::MSG_DONTWAIT,
                ptr::null_mut(),
            )
        };
        let Ok(count) = usize::try_from(taken) else {
            let error = io::Error::last_os_error();
            let nothing = matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted);
            return if nothing { Ok(0) } else { Err(error) };
        };
        // Lengths are of other types in other C libraries.
        #[allow(clippy::unnecessary_cast)]
        for (taken, header) in self.taken.iter_mut().zip(&headers[..count]) {
            *taken = BufferUse {
                octets: (header.msg_len as usize).min(self.octets_each),
                name_octets: (header.msg_hdr.msg_namelen as usize).min(NAME_OCTETS),
                control_octets: (header.msg_hdr.msg_controllen as usize).min(CONTROL_OCTETS),
                cut: header.msg_hdr.msg_flags & libc::MSG_TRUNC != 0,
            };
        }
        Ok(count)
    }

    /// A datagram of the last call.
    pub(crate) fn datagram(&self, place: usize) -> RawDatagram<'_> {
        let taken = self.taken[place];
        let start = place * self.octets_each;
        RawDatagram {
            bytes: &self.octets[start..start + taken.octets],
            cut: taken.cut,
            sender: address(&self.names[place][..taken.name_octets]),
            control: Control::read(&self.controls[place][..taken.control_octets]),
        }
    }
}

impl Control {
    /// Reads a row of control messages; other kinds are skipped.
    fn read(mut octets: &[u8]) -> Self {
        let mut found = Self::default();
        while let Some((header, _)) = octets.split_first_chunk::<CONTROL_HEADER_OCTETS>() {
            let length = usize::from_ne_bytes(part(header, 0));
            let level = i32::from_ne_bytes(part(header, 8));
            let kind = i32::from_ne_bytes(part(header, 12));
            let Some(value) = octets.get(CONTROL_HEADER_OCTETS..length) else {
                break;
            };
            match (level, kind, value.len()) {
                (libc::SOL_SOCKET, libc::SCM_TIMESTAMPNS, 16) => {
                    let seconds = i64::from_ne_bytes(part(value, 0));
                    let nanoseconds = i64::from_ne_bytes(part(value, 8));
                    let utc_ns = seconds.checked_mul(1_000_000_000);
                    found.received_utc_ns = utc_ns.and_then(|utc_ns| utc_ns.checked_add(nanoseconds));
                }
                (libc::SOL_SOCKET, libc::SO_RXQ_OVFL, 4) => found.dropped = Some(u32::from_ne_bytes(part(value, 0))),
                _ => {}
            }
            octets = octets.get(length.next_multiple_of(8)..).unwrap_or_default();
        }
        found
    }
}

/// The address in a `sockaddr_in` or `sockaddr_in6`.
fn address(octets: &[u8]) -> Option<SocketAddr> {
    let (family, _) = octets.split_first_chunk()?;
    match (i32::from(u16::from_ne_bytes(*family)), octets.len()) {
        (libc::AF_INET, 16..) => {
            let ip = Ipv4Addr::from(part::<4>(octets, 4));
            Some(SocketAddrV4::new(ip, u16::from_be_bytes(part(octets, 2))).into())
        }
        (libc::AF_INET6, 28..) => {
            let ip = Ipv6Addr::from(part::<16>(octets, 8));
            let port = u16::from_be_bytes(part(octets, 2));
            let flow = u32::from_be_bytes(part(octets, 4));
            let scope = u32::from_ne_bytes(part(octets, 24));
            Some(SocketAddrV6::new(ip, port, flow, scope).into())
        }
        _ => None,
    }
}

/// Returns `N` bytes from `start`; the caller guarantees the presence.
fn part<const N: usize>(octets: &[u8], start: usize) -> [u8; N] {
    let mut found = [0; N];
    found.copy_from_slice(&octets[start..start + N]);
    found
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn message(kind: i32, value: &[u8]) -> Vec<u8> {
        let mut octets = (CONTROL_HEADER_OCTETS + value.len()).to_ne_bytes().to_vec();
        octets.extend(libc::SOL_SOCKET.to_ne_bytes());
        octets.extend(kind.to_ne_bytes());
        octets.extend(value);
        octets.resize(octets.len().next_multiple_of(8), 0);
        octets
    }

    #[test]
    fn control_messages_are_found_behind_one_another() {
        let stamp = [1_700_000_000i64.to_ne_bytes(), 5i64.to_ne_bytes()].concat();
        let mut octets = message(libc::SCM_TIMESTAMPNS, &stamp);
        octets.extend(message(99, &[1, 2, 3]));
        octets.extend(message(libc::SO_RXQ_OVFL, &7u32.to_ne_bytes()));
        let expected = Control {
            received_utc_ns: Some(1_700_000_000_000_000_005),
            dropped: Some(7),
        };
        assert_eq!(Control::read(&octets), expected);
        assert_eq!(Control::read(&octets[..octets.len() - 8]).dropped, None, "cut");
        assert_eq!(Control::read(&[]), Control::default());
    }

    #[test]
    fn a_header_that_lies_about_its_length_ends_the_row() {
        for length in [0usize, 15, 1000, usize::MAX] {
            let mut octets = message(libc::SO_RXQ_OVFL, &7u32.to_ne_bytes());
            octets[..8].copy_from_slice(&length.to_ne_bytes());
            assert_eq!(Control::read(&octets), Control::default(), "{length}");
        }
    }

    #[test]
    fn addresses_of_both_kinds_are_read() {
        let mut v4 = (libc::AF_INET as u16).to_ne_bytes().to_vec();
        v4.extend([0x1f, 0x90, 192, 0, 2, 17, 0, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(address(&v4), Some("192.0.2.17:8080".parse().unwrap()));
        let mut v6 = (libc::AF_INET6 as u16).to_ne_bytes().to_vec();
        v6.extend([0x1f, 0x90, 0, 0, 0, 0]);
        v6.extend(Ipv6Addr::LOCALHOST.octets());
        v6.extend(3u32.to_ne_bytes());
        let expected = SocketAddrV6::new(Ipv6Addr::LOCALHOST, 8080, 0, 3);
        assert_eq!(address(&v6), Some(expected.into()));
        assert_eq!(address(&v6[..27]), None);
    }

    proptest! {
        #[test]
        fn no_octets_are_read_beyond_the_end(octets in prop::collection::vec(any::<u8>(), 0..CONTROL_OCTETS)) {
            let _ = (Control::read(&octets), address(&octets));
        }
    }
}
