//! Where pieces go.

use std::net::SocketAddr;
use std::time::Duration;

use net::{DoorRefusal, Interface, LineServer, NetError, Reach, SenderSettings, UdpSender};
use runtime::signals::Stop;

use super::pieces::PieceKind;

/// Pause between two looks for a reader.
const PAUSE: Duration = Duration::from_millis(20);

/// Way of the pieces onto the network.
#[derive(Debug)]
pub(super) enum WayOut {
    /// Datagrams to an address or group.
    Datagrams(UdpSender),
    /// Lines to all connected clients.
    Lines(Box<LineServer>),
}

impl WayOut {
    /// Opens the socket for pieces of a kind.
    ///
    /// # Errors
    /// If the address cannot be meant, or the operating system refuses.
    pub(super) fn open(
        to: SocketAddr,
        interface: Option<&Interface>,
        kind: PieceKind,
        reach: Reach,
    ) -> Result<Self, NetError> {
        Ok(match kind {
            PieceKind::Datagrams => {
                let mut settings = SenderSettings::new(to);
                settings.interface = interface.filter(|_| to.ip().is_multicast()).cloned();
                Self::Datagrams(UdpSender::open(&settings)?)
            }
            PieceKind::Lines => Self::Lines(Box::new(LineServer::open(to, reach)?)),
        })
    }

    /// Waits for a client, if clients must connect.
    ///
    /// # Errors
    /// If the operating system takes no connections.
    pub(super) fn await_reader(&mut self, stop: &Stop) -> std::io::Result<()> {
        let Self::Lines(server) = self else { return Ok(()) };
        eprintln!("waiting at {} for a reader", server.local_address()?);
        while server.accept()? == 0 && !stop.requested() {
            std::thread::sleep(PAUSE);
        }
        Ok(())
    }

    /// Sends a piece. Failures of the operating system are counted.
    ///
    /// # Errors
    /// If the way out takes no connections any more.
    pub(super) fn send(&mut self, octets: &[u8]) -> std::io::Result<()> {
        match self {
            // Counted by the sender.
            Self::Datagrams(sender) => drop(sender.send(octets)),
            Self::Lines(server) => {
                server.accept()?;
                server.send(octets);
            }
        }
        Ok(())
    }

    /// Datagrams that the operating system did not take; readers that did not keep up.
    pub(super) fn failed(&self) -> u64 {
        match self {
            Self::Datagrams(sender) => sender.counters().failed,
            Self::Lines(server) => server.counters().refused(DoorRefusal::Slow),
        }
    }
}
