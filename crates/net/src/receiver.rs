//! Datagrams from the network.
//!
//! **Groups.** A datagram to a multicast address (224.0.0.0/4, ff00::/8) goes to every host that has joined the group
//! (RFC 1112, RFC 4291). Joining is done per socket and per interface, and Linux has two surprises in store. A socket
//! bound to a port alone receives every group of that port that *any* process of the machine has joined; so the socket
//! is bound to the group's address. And even then the socket receives the group's datagrams from interfaces on which
//! only other sockets have joined, because membership counts for the whole host unless `IP_MULTICAST_ALL` is off
//! (ip(7)); so this option is off.
//!
//! **Several readers.** Recorder, tracker and display may run on the same machine. For a group, `SO_REUSEADDR`
//! permits several sockets with the same address and port, and each socket receives every datagram. For a unicast
//! address the option would let a second process take over the feed without a warning; there it is not set, and the
//! second process gets the error "address in use". `SO_REUSEPORT` is not suitable: the kernel distributes unicast
//! datagrams over the sockets, so that every reader would receive a random part of the reports.
//!
//! **Time.** Interrupts, queues and the scheduler delay a datagram between the wire and this process. The kernel stamps
//! each datagram at the arrival from the interface (`SO_TIMESTAMPNS`, socket(7)); the waiting time of a report is
//! therefore measured. The stamps are times of the machine's UTC clock, including jumps. The kernel starts stamping
//! with the first socket that requests stamps; datagrams of the first milliseconds are stamped when read.
//!
//! **Drops.** While the reader is busy, the kernel stores datagrams in a buffer, and drops datagrams without room.
//! With `SO_RXQ_OVFL` the kernel attaches the number of drops to the next datagram. The number includes datagrams
//! with a wrong checksum. The kernel silently limits the requested size of the buffer (`SO_RCVBUF`) to
//! `net.core.rmem_max`; the granted size is read back, and a smaller size gives a [warning].
//!
//! **Floods.** Each call takes at most a single batch and returns. Datagrams of unlisted senders cost a share of a
//! system call and a comparison, but cannot keep the caller busy.
//!
//! [warning]: UdpReceiver::warning

use std::io;
use std::net::{IpAddr, SocketAddr, SocketAddrV6};
use std::os::fd::{AsFd, BorrowedFd};
use std::time::Duration;

use nix::sys::socket::{setsockopt, sockopt};
use rustix::event::PollFlags;
use socket2::{Domain, InterfaceIndexOrAddress, Protocol, Socket, Type};

use crate::batch::{Batch, RawDatagram};
use crate::{AllowedSenders, Interface, NetError, wait};

/// Longest payload that any datagram has.
const DATAGRAM_OCTETS_MAX: usize = 65_535;
/// Sizes of the kernel's buffer that can be asked for.
const RECEIVE_BUFFER_OCTETS: std::ops::RangeInclusive<usize> = 4_096..=1 << 30;

/// Settings of a receiver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReceiverSettings {
    /// An address of this machine (unspecified: all addresses), or a multicast group.
    pub address: IpAddr,
    /// The port; with 0 the kernel chooses a free port, see [`UdpReceiver::local_address`].
    pub port: u16,
    /// On which interface the group is joined; needed for a group, and for nothing else.
    pub interface: Option<Interface>,
    /// Accepted senders.
    pub allowed_senders: AllowedSenders,
    /// Size of the kernel's buffer, 4 KiB to 1 GiB. A datagram occupies some hundred bytes more than the payload, for
    /// the kernel's management.
    pub receive_buffer_octets: usize,
    /// Longest datagram that is accepted, at most 65,535 bytes. [`BATCH_MAX`](crate::BATCH_MAX) times as much is
    /// allocated.
    pub datagram_octets_max: usize,
}

impl ReceiverSettings {
    /// Settings stated by a configuration: address and port, interface, addresses and networks of senders, and the size
    /// of the kernel's buffer in bytes.
    ///
    /// # Errors
    /// As [`AllowedSenders::parse`].
    pub fn stated(
        listen: SocketAddr,
        interface: Option<&str>,
        senders: &[String],
        buffer_octets: usize,
    ) -> Result<Self, NetError> {
        Ok(Self {
            interface: interface.map(Interface::stated),
            allowed_senders: AllowedSenders::parse(senders.iter().map(String::as_str))?,
            receive_buffer_octets: buffer_octets,
            ..Self::new(listen.ip(), listen.port())
        })
    }

    /// Everything that comes to a port of this machine or to a group: all senders, a buffer of 4 MiB, datagrams of any
    /// length.
    pub fn new(address: IpAddr, port: u16) -> Self {
        Self {
            address,
            port,
            interface: None,
            allowed_senders: AllowedSenders::default(),
            receive_buffer_octets: 4 << 20,
            datagram_octets_max: DATAGRAM_OCTETS_MAX,
        }
    }

    /// Checks the settings without opening a socket.
    ///
    /// # Errors
    /// [`NetError::Setting`] for the first that cannot.
    pub fn check(&self) -> Result<(), NetError> {
        let address = self.address;
        match (&self.interface, address.is_multicast()) {
            (None, true) => {
                let reason = "is a multicast group; name the interface on which it is to be joined";
                return Err(NetError::setting("address", address, reason));
            }
            (Some(interface), false) => {
                let reason = format!("is of use with a multicast group only, which {address} is not; leave it out");
                return Err(NetError::setting("interface", interface, reason));
            }
            _ => {}
        }
        if let Some(entry) = self.allowed_senders.unreachable_from(address) {
            let reason = format!("can never send to {address}: one is of IPv4, the other of IPv6");
            return Err(NetError::setting("allowed sender", entry, reason));
        }
        if !RECEIVE_BUFFER_OCTETS.contains(&self.receive_buffer_octets) {
            let (least, most) = (RECEIVE_BUFFER_OCTETS.start(), RECEIVE_BUFFER_OCTETS.end());
            let reason = format!("must be {least} to {most} octets");
            return Err(NetError::setting("receive buffer", self.receive_buffer_octets, reason));
        }
        if !(1..=DATAGRAM_OCTETS_MAX).contains(&self.datagram_octets_max) {
            let reason = format!("must be 1 to {DATAGRAM_OCTETS_MAX} octets");
            return Err(NetError::setting("longest datagram", self.datagram_octets_max, reason));
        }
        Ok(())
    }
}

/// A datagram that passed the checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datagram<'a> {
    /// Payload, at least 1 byte.
    pub bytes: &'a [u8],
    /// Sender's address as stated in the datagram.
    pub sender: SocketAddr,
    /// Time at which the kernel took the datagram from the interface, UTC, nanoseconds since 1970.
    pub received_utc_ns: i64,
}

/// Counts since the socket was opened. The first five counts are disjoint: each datagram delivered by the kernel is
/// in exactly one of these counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReceiverCounters {
    /// Datagrams handed on.
    pub datagrams: u64,
    /// Datagrams from unlisted senders, with any content.
    pub refused_senders: u64,
    /// Datagrams longer than accepted, not handed on.
    pub oversized: u64,
    /// Datagrams without payload, not handed on.
    pub empty: u64,
    /// Datagrams without sender or time of receipt, not handed on. No kernel is known to deliver any.
    pub unstamped: u64,
    /// Bytes handed on.
    pub octets: u64,
    /// Datagrams that the kernel dropped. The number comes with the next datagram, so drops before a silence are
    /// counted after the silence.
    pub kernel_drops: u64,
}

/// A socket that receives datagrams.
#[derive(Debug)]
pub struct UdpReceiver {
    socket: Socket,
    local: SocketAddr,
    allowed_senders: AllowedSenders,
    batch: Batch,
    /// The kernel's own count, which starts anew after 2³².
    dropped: u32,
    counters: ReceiverCounters,
    receive_buffer_octets: usize,
    warning: Option<String>,
}

impl UdpReceiver {
    /// Opens the socket, and joins a multicast group.
    ///
    /// # Errors
    /// [`NetError`] if a setting cannot be meant, the interface is not there, or the operating system refuses, for
    /// example because another process has the address.
    pub fn open(settings: &ReceiverSettings) -> Result<Self, NetError> {
        settings.check()?;
        let wished = SocketAddr::new(settings.address, settings.port);
        let failed = || NetError::refused::<io::Error>(format!("receiving at {wished}"));
        let socket = Socket::new(Domain::for_address(wished), Type::DGRAM, Some(Protocol::UDP)).map_err(failed())?;
        ask_for_control_messages(&socket).map_err(failed())?;
        let granted = ask_for_buffer(&socket, settings.receive_buffer_octets).map_err(failed())?;
        if wished.is_ipv6() {
            // Else an IPv4 sender would come in under an address that no list names.
            socket.set_only_v6(true).map_err(failed())?;
        }
        match &settings.interface {
            Some(interface) => join(&socket, wished, interface)?,
            None => socket.bind(&wished.into()).map_err(failed())?,
        }
        let local = socket.local_addr().map_err(failed())?.as_socket().unwrap_or(wished);
        Ok(Self {
            socket,
            local,
            allowed_senders: settings.allowed_senders.clone(),
            batch: Batch::new(settings.datagram_octets_max),
            dropped: 0,
            counters: ReceiverCounters::default(),
            receive_buffer_octets: granted,
            warning: (granted < settings.receive_buffer_octets)
                .then(|| small_buffer(local, granted, settings.receive_buffer_octets)),
        })
    }

    /// Takes up to [`BATCH_MAX`](crate::BATCH_MAX) waiting datagrams; without any, waits up to `timeout` for the first
    /// datagram. `visit` receives the valid datagrams in order of arrival; returns the number of valid datagrams, which
    /// is 0 if no arrived datagram was valid. A signal ends the wait.
    ///
    /// # Errors
    /// If the socket fails; no received datagram causes an error. The receiver remains usable.
    pub fn receive(&mut self, timeout: Duration, mut visit: impl FnMut(Datagram<'_>)) -> io::Result<usize> {
        let mut taken = self.batch.take(self.socket.as_fd())?;
        if taken == 0 && !timeout.is_zero() && wait::ready(self.socket.as_fd(), PollFlags::IN, timeout)? {
            taken = self.batch.take(self.socket.as_fd())?;
        }
        let mut visited = 0;
        for place in 0..taken {
            let raw = self.batch.datagram(place);
            if let Some(dropped) = raw.control.dropped {
                self.counters.kernel_drops += u64::from(dropped.wrapping_sub(self.dropped));
                self.dropped = dropped;
            }
            if let Some(datagram) = check(raw, &self.allowed_senders, &mut self.counters) {
                visit(datagram);
                visited += 1;
            }
        }
        Ok(visited)
    }

    /// Returns the address of the socket: the configured address, and the port chosen by the kernel if not
    /// configured.
    pub fn local_address(&self) -> SocketAddr {
        self.local
    }

    /// Returns the counts since the socket was opened.
    pub fn counters(&self) -> ReceiverCounters {
        self.counters
    }

    /// How many bytes the kernel has agreed to hold.
    pub fn receive_buffer_octets(&self) -> usize {
        self.receive_buffer_octets
    }

    /// Returns a warning if the kernel's buffer is smaller than requested.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }
}

impl AsFd for UdpReceiver {
    /// For waiting for several sockets at once: ready to be read when [`UdpReceiver::receive`] would not wait.
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

fn check<'a>(raw: RawDatagram<'a>, allowed: &AllowedSenders, counters: &mut ReceiverCounters) -> Option<Datagram<'a>> {
    let (Some(sender), Some(received_utc_ns)) = (raw.sender, raw.control.received_utc_ns) else {
        counters.unstamped += 1;
        return None;
    };
    if !allowed.allow(sender.ip()) {
        counters.refused_senders += 1;
        return None;
    }
    if raw.cut {
        counters.oversized += 1;
        return None;
    }
    if raw.bytes.is_empty() {
        counters.empty += 1;
        return None;
    }
    counters.datagrams += 1;
    counters.octets += raw.bytes.len() as u64;
    Some(Datagram {
        bytes: raw.bytes,
        sender,
        received_utc_ns,
    })
}

fn ask_for_control_messages(socket: &Socket) -> io::Result<()> {
    setsockopt(socket, sockopt::ReceiveTimestampns, &true)?;
    setsockopt(socket, sockopt::RxqOvfl, &1)?;
    Ok(())
}

/// Requests a buffer of `octets` bytes; returns the granted size.
fn ask_for_buffer(socket: &Socket, octets: usize) -> io::Result<usize> {
    socket.set_recv_buffer_size(octets)?;
    // The kernel doubles the figure for internal management, and reports the doubled figure.
    Ok(socket.recv_buffer_size()? / 2)
}

fn small_buffer(local: SocketAddr, granted: usize, wished: usize) -> String {
    format!(
        "{local}: the kernel holds {granted} octets for a busy reader instead of the {wished} asked for, and drops \
         datagrams beyond that; allow more with `sysctl -w net.core.rmem_max={wished}`"
    )
}

/// Binds `socket` to the group and joins the group on `interface` alone.
fn join(socket: &Socket, group: SocketAddr, interface: &Interface) -> Result<(), NetError> {
    let index = interface.find(socket)?.index;
    let bound = match group {
        // Groups of link-local scope exist once per interface.
        SocketAddr::V6(group) => SocketAddrV6::new(*group.ip(), group.port(), 0, index).into(),
        SocketAddr::V4(_) => group,
    };
    let joined = || {
        socket.set_reuse_address(true)?;
        socket.bind(&bound.into())?;
        match group.ip() {
            IpAddr::V4(group) => {
                socket.set_multicast_all_v4(false)?;
                socket.join_multicast_v4_n(&group, &InterfaceIndexOrAddress::Index(index))
            }
            IpAddr::V6(group) => {
                socket.set_multicast_all_v6(false)?;
                socket.join_multicast_v6(&group, index)
            }
        }
    };
    joined().map_err(NetError::refused(format!("joining {group} on interface {interface}")))
}
