//! Datagrams from the network.
//!
//! **Groups.** A datagram to a multicast address (224.0.0.0/4, ff00::/8) goes to every host that has joined the group
//! (RFC 1112, RFC 4291). Joining is done per socket and per interface, and Linux has two surprises in store. A socket
//! bound to a port alone receives every group of that port that *any* process of the machine has joined; so the socket
//! is bound to the group's address. And even then it receives the group's datagrams from interfaces on which only
//! others have joined, because membership counts for the whole host unless `IP_MULTICAST_ALL` is off (ip(7)); so it is
//! off.
//!
//! **Several readers.** Recorder, tracker and display may run on one machine. For a group, `SO_REUSEADDR` lets
//! each of them bind the same address and port, and each gets every datagram. For an address of the machine itself it
//! would let a second process take the feed away from the first without a word, so there it is not set, and the second
//! process is told that the address is in use. `SO_REUSEPORT` is no way out: it spreads datagrams to one address over
//! its sockets, each to one of them, which is made for servers with many clients, and would leave every reader
//! with a random half of the sensor's reports.
//!
//! **Time.** Between the wire and this process lie interrupts, queues and a scheduler that may have other plans. The
//! kernel notes the time of each datagram when it comes in from the interface (`SO_TIMESTAMPNS`, socket(7)), so a
//! report that waited 20 ms for its reader is known to have waited. The stamps are of the machine's UTC clock, and jump
//! with it. The kernel turns its stamping on when the first socket of the machine asks for it; what comes in until
//! then, some milliseconds at most, is stamped when it is read.
//!
//! **Drops.** While the reader is busy, the kernel holds datagrams in a buffer, and drops what does not fit. Nobody is
//! told unless somebody asks: `SO_RXQ_OVFL` sends the number of drops along with the next datagram. It goes up when the
//! buffer is full, and also for a damaged checksum. The buffer's size is a wish (`SO_RCVBUF`) that the kernel silently
//! cuts down to `net.core.rmem_max`; what was granted is read back, and a wish cut down gives a [warning].
//!
//! **Floods.** Each call takes one batch at most and then returns, whatever it found. Senders that are not listed cost
//! their share of a system call and a comparison, but cannot hold the caller.
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

/// What to receive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReceiverSettings {
    /// An address of this machine (unspecified: all of them), or a multicast group.
    pub address: IpAddr,
    /// The port; with 0 the kernel chooses a free one, see [`UdpReceiver::local_address`].
    pub port: u16,
    /// On which interface the group is joined; needed for a group, and for nothing else.
    pub interface: Option<Interface>,
    /// Whose datagrams are accepted.
    pub allowed_senders: AllowedSenders,
    /// How many octets the kernel shall hold while the reader is busy, 4 KiB to 1 GiB. A datagram counts with what the
    /// kernel needs to manage it, some hundred octets more than its payload.
    pub receive_buffer_octets: usize,
    /// Longest datagram that is accepted, at most 65,535 octets. [`BATCH_MAX`](crate::BATCH_MAX) times as much is
    /// allocated.
    pub datagram_octets_max: usize,
}

impl ReceiverSettings {
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

    /// Whether they can be meant, as far as that can be said without opening a socket.
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
    /// Its payload, at least one octet.
    pub bytes: &'a [u8],
    /// Where it says it comes from.
    pub sender: SocketAddr,
    /// When the kernel took it from the interface, UTC, nanoseconds since 1970.
    pub received_utc_ns: i64,
}

/// What has been counted since the socket was opened. Each datagram that the kernel delivered is in exactly one of the
/// first five.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReceiverCounters {
    /// Datagrams handed on.
    pub datagrams: u64,
    /// Datagrams from senders that are not on the list, whatever they contain.
    pub refused_senders: u64,
    /// Datagrams longer than accepted, not handed on.
    pub oversized: u64,
    /// Datagrams without payload, not handed on.
    pub empty: u64,
    /// Datagrams without sender or time of receipt, not handed on. No kernel is known to deliver any.
    pub unstamped: u64,
    /// Octets handed on.
    pub octets: u64,
    /// Datagrams that the kernel dropped. The number comes with the next datagram, so drops before a silence are
    /// counted after it.
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
    /// Opens the socket and joins the group, if it is one.
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

    /// Takes the datagrams that are there, [`BATCH_MAX`](crate::BATCH_MAX) at most; if there are none, waits for the
    /// first of them as long as `timeout`. `visit` gets those that pass the checks, in order of arrival; their number
    /// is returned, and may be 0 although something came. A signal ends the wait.
    ///
    /// # Errors
    /// If the socket fails, which it does not because of anything that is sent to it. It may be used again.
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

    /// Where the socket receives: the settings' address, and the port that the kernel chose if they left it open.
    pub fn local_address(&self) -> SocketAddr {
        self.local
    }

    /// What has been counted so far.
    pub fn counters(&self) -> ReceiverCounters {
        self.counters
    }

    /// How many octets the kernel has agreed to hold.
    pub fn receive_buffer_octets(&self) -> usize {
        self.receive_buffer_octets
    }

    /// What an operator should know and can change: that the kernel holds less than was asked for.
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

/// Asks for a buffer of `octets` and says what was granted.
fn ask_for_buffer(socket: &Socket, octets: usize) -> io::Result<usize> {
    socket.set_recv_buffer_size(octets)?;
    // The kernel doubles the figure, to leave room for its own bookkeeping, and reports the doubled one.
    Ok(socket.recv_buffer_size()? / 2)
}

fn small_buffer(local: SocketAddr, granted: usize, wished: usize) -> String {
    format!(
        "{local}: the kernel holds {granted} octets for a busy reader instead of the {wished} asked for, and drops \
         datagrams beyond that; allow more with `sysctl -w net.core.rmem_max={wished}`"
    )
}

/// Binds `socket` to the group and joins it on `interface` alone.
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
