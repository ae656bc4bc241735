//! Datagrams to the network.
//!
//! Sending gives no guarantee: the operating system accepts or refuses a datagram, and the later fate of the datagram
//! is unknown. A failure is therefore counted, and the next datagram is sent independently. One exception: if no
//! process listens at the destination, the destination host may answer with an ICMP message, and the kernel reports
//! this message at the *next* sending instead of sending. The report is counted, and the datagram sent again, so that a
//! new listener does not miss the first datagram.
//!
//! A multicast datagram passes one router fewer than the time to live: with 1, the default here, it stays in the
//! local network (RFC 1112, section 6.1). With loop-back, processes of this machine in the group receive the datagrams,
//! too.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};

use rustix::net::sockopt::set_ip_multicast_if_with_ifindex;
use socket2::{Domain, Protocol, Socket, Type};

use crate::interface::InterfaceIdentity;
use crate::{Interface, NetError};

/// Where to send to, and how.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SenderSettings {
    /// An address or a multicast group, with the port.
    pub destination: SocketAddr,
    /// By which interface a group is sent to; needed for a group, and for nothing else.
    pub interface: Option<Interface>,
    /// Time to live, 1 to 255; `None`: 1 for a group, the kernel's default otherwise.
    pub time_to_live: Option<u8>,
    /// Whether processes of this machine that have joined the group receive the datagrams too.
    pub multicast_loop: bool,
}

impl SenderSettings {
    /// Settings stated by a configuration: address and port, interface, and time to live.
    pub fn stated(destination: SocketAddr, interface: Option<&str>, time_to_live: Option<u8>) -> Self {
        Self {
            interface: interface.map(Interface::stated),
            time_to_live,
            ..Self::new(destination)
        }
    }

    /// Sends to `destination` with the usual time to live, and to processes of this machine too.
    pub fn new(destination: SocketAddr) -> Self {
        Self {
            destination,
            interface: None,
            time_to_live: None,
            multicast_loop: true,
        }
    }

    /// Checks the settings without opening a socket.
    ///
    /// # Errors
    /// [`NetError::Setting`] for the first that cannot.
    pub fn check(&self) -> Result<(), NetError> {
        let destination = self.destination;
        if destination.port() == 0 || destination.ip().is_unspecified() {
            let reason = "is no destination; give an address and a port above 0";
            return Err(NetError::setting("destination", destination, reason));
        }
        if self.time_to_live == Some(0) {
            let reason = "would keep every datagram from leaving; take 1 for the local network";
            return Err(NetError::setting("time to live", 0, reason));
        }
        match (&self.interface, destination.ip().is_multicast()) {
            (None, true) => {
                let reason = "is a multicast group; name the interface by which it is to be sent to";
                Err(NetError::setting("destination", destination, reason))
            }
            (Some(interface), false) => {
                let reason = format!("is of use with a multicast group only, which {destination} is not; leave it out");
                Err(NetError::setting("interface", interface, reason))
            }
            _ => Ok(()),
        }
    }
}

/// Counts since the socket was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SenderCounters {
    /// Datagrams that the operating system took.
    pub sent: u64,
    /// Bytes in the sent datagrams.
    pub octets: u64,
    /// Datagrams refused by the kernel: buffer full, datagram too long, no route.
    pub failed: u64,
    /// Reports by the destination host that no process listens.
    pub unheard: u64,
}

/// A socket that sends datagrams to a single destination.
#[derive(Debug)]
pub struct UdpSender {
    socket: Socket,
    counters: SenderCounters,
}

impl UdpSender {
    /// Opens the socket.
    ///
    /// # Errors
    /// [`NetError`] if a setting cannot be meant, the interface is not there, or the operating system refuses.
    pub fn open(settings: &SenderSettings) -> Result<Self, NetError> {
        settings.check()?;
        let destination = settings.destination;
        let failed = || NetError::refused::<io::Error>(format!("sending to {destination}"));
        let socket =
            Socket::new(Domain::for_address(destination), Type::DGRAM, Some(Protocol::UDP)).map_err(failed())?;
        match &settings.interface {
            Some(interface) => {
                let interface = interface.find(&socket)?;
                prepare_multicast(&socket, settings, interface).map_err(failed())?;
            }
            None => prepare_unicast(&socket, settings).map_err(failed())?,
        }
        socket.set_nonblocking(true).map_err(failed())?;
        socket.connect(&destination.into()).map_err(failed())?;
        Ok(Self {
            socket,
            counters: SenderCounters::default(),
        })
    }

    /// Sends a single datagram, or fails, without waiting.
    ///
    /// # Errors
    /// The operating system's error for this datagram. The failure is already counted, and later datagrams may
    /// succeed: a caller with published counters needs no further action.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut outcome = self.socket.send(bytes);
        if let Err(error) = &outcome
            && error.kind() == io::ErrorKind::ConnectionRefused
        {
            self.counters.unheard += 1;
            outcome = self.socket.send(bytes);
        }
        match outcome {
            Ok(octets) => {
                self.counters.sent += 1;
                self.counters.octets += octets as u64;
                Ok(())
            }
            Err(error) => {
                self.counters.failed += 1;
                Err(error)
            }
        }
    }

    /// Returns the counts since the socket was opened.
    pub fn counters(&self) -> SenderCounters {
        self.counters
    }
}

fn prepare_multicast(socket: &Socket, settings: &SenderSettings, interface: InterfaceIdentity) -> io::Result<()> {
    let time_to_live = u32::from(settings.time_to_live.unwrap_or(1));
    if settings.destination.is_ipv4() {
        // The number selects the outgoing interface, the address the source address: otherwise the kernel may use the
        // address of another interface.
        let from = interface.ipv4.unwrap_or(Ipv4Addr::UNSPECIFIED);
        set_ip_multicast_if_with_ifindex(socket, &Ipv4Addr::UNSPECIFIED, &from, interface.index)?;
        socket.set_multicast_ttl_v4(time_to_live)?;
        socket.set_multicast_loop_v4(settings.multicast_loop)
    } else {
        socket.set_multicast_if_v6(interface.index)?;
        socket.set_multicast_hops_v6(time_to_live)?;
        socket.set_multicast_loop_v6(settings.multicast_loop)
    }
}

fn prepare_unicast(socket: &Socket, settings: &SenderSettings) -> io::Result<()> {
    match (settings.time_to_live, settings.destination) {
        (None, _) => Ok(()),
        (Some(time_to_live), SocketAddr::V4(_)) => socket.set_ttl_v4(time_to_live.into()),
        (Some(time_to_live), SocketAddr::V6(_)) => socket.set_unicast_hops_v6(time_to_live.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the socket options in the kernel: loopback delivers every datagram, with any options.
    #[test]
    fn time_to_live_and_loop_back_are_set_as_asked() {
        let mut settings = SenderSettings::new("239.255.17.5:5000".parse().unwrap());
        settings.interface = Some(Interface::Name("lo".to_owned()));
        let socket = UdpSender::open(&settings).unwrap().socket;
        assert_eq!(
            (socket.multicast_ttl_v4().unwrap(), socket.multicast_loop_v4().unwrap()),
            (1, true)
        );
        settings.time_to_live = Some(7);
        settings.multicast_loop = false;
        let socket = UdpSender::open(&settings).unwrap().socket;
        assert_eq!(
            (socket.multicast_ttl_v4().unwrap(), socket.multicast_loop_v4().unwrap()),
            (7, false)
        );

        let mut settings = SenderSettings::new("127.0.0.1:5000".parse().unwrap());
        let usual = UdpSender::open(&settings).unwrap().socket.ttl_v4().unwrap();
        assert!(usual > 1, "unicast goes beyond the local network: {usual}");
        settings.time_to_live = Some(9);
        assert_eq!(UdpSender::open(&settings).unwrap().socket.ttl_v4().unwrap(), 9);
    }
}
