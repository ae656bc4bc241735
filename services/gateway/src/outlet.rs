//! Ways out of a gateway process: datagrams, or connections of clients.

use std::fmt;
use std::net::SocketAddr;

use anyhow::Context as _;
use deployment::DatagramOutput;
use messages::Counter;
use net::{LineServer, Reach, SenderSettings, UdpSender};
use runtime::{HealthEntry, Now};
use settings::SettingsError;

use crate::destination::{Destination, sender_mistake};

/// How blocks leave.
#[derive(Clone, Debug)]
pub(crate) enum OutletWay {
    /// In datagrams.
    Datagrams(SenderSettings),
    /// To each client that connects (TCP).
    Lines(SocketAddr, Reach),
}

/// Keys of an outlet that select the way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutletKeys<'a> {
    /// Destination of datagrams.
    pub(crate) send_to: Option<Destination>,
    /// Address for connections.
    pub(crate) listen: Option<Destination>,
    /// Interface of datagrams.
    pub(crate) interface: Option<&'a str>,
    /// Time to live of datagrams.
    pub(crate) ttl: Option<u8>,
    /// Whether other machines may reach the address for connections.
    pub(crate) remote: bool,
}

/// An open way out.
#[derive(Debug)]
pub(crate) enum Outlet {
    /// In datagrams.
    Datagrams(Box<UdpSender>),
    /// To each connected client.
    Lines(Box<LineServer>),
}

impl fmt::Display for OutletWay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Datagrams(sender) => write!(f, "sending to {}", sender.destination),
            Self::Lines(address, _) => write!(f, "listening at {address}"),
        }
    }
}

impl OutletKeys<'_> {
    /// Returns where datagrams go; `None` for connections.
    ///
    /// # Errors
    /// As [`Self::way`].
    pub(crate) fn datagrams(&self) -> Result<Option<DatagramOutput>, SettingsError> {
        self.way()?;
        Ok(self.send_to.map(|to| DatagramOutput {
            send_to: to.0,
            interface: self.interface.map(str::to_owned),
            ttl: self.ttl,
        }))
    }

    /// Returns how blocks leave.
    ///
    /// # Errors
    /// If not exactly one way is given, or a key does not fit the way.
    pub(crate) fn way(&self) -> Result<OutletWay, SettingsError> {
        match (self.send_to, self.listen) {
            (Some(_), None) if self.remote => {
                let what = "is about clients that connect, but datagrams are sent; leave it out";
                Err(SettingsError::new("remote", what))
            }
            (Some(to), None) => {
                let sender = SenderSettings::stated(to.0, self.interface, self.ttl);
                sender.check().map_err(sender_mistake)?;
                Ok(OutletWay::Datagrams(sender))
            }
            (None, Some(_)) if self.interface.is_some() || self.ttl.is_some() => {
                let what = "is about datagrams, but clients connect; leave it out";
                let key = if self.interface.is_some() { "interface" } else { "ttl" };
                Err(SettingsError::new(key, what))
            }
            (None, Some(at)) => {
                let reach = Reach::permitted(self.remote, "remote = true beside it");
                reach
                    .check(at.0)
                    .map_err(|reason| SettingsError::new("listen", reason))?;
                Ok(OutletWay::Lines(at.0, reach))
            }
            _ => {
                let what = "give either send_to (datagrams) or listen (connections of clients)";
                Err(SettingsError::new("", what))
            }
        }
    }
}

impl Outlet {
    /// Opens the sockets of `way`.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub(crate) fn open(way: &OutletWay) -> anyhow::Result<Self> {
        let outlet = match way {
            OutletWay::Datagrams(sender) => UdpSender::open(sender).map(|sender| Self::Datagrams(Box::new(sender))),
            OutletWay::Lines(address, reach) => {
                LineServer::open(*address, *reach).map(|server| Self::Lines(Box::new(server)))
            }
        };
        outlet.with_context(|| way.to_string())
    }

    /// Accepts clients, each of which gets `greeting` first.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub(crate) fn accept_with(&mut self, greeting: &[u8]) -> anyhow::Result<()> {
        if let Self::Lines(server) = self {
            server.accept_with(greeting)?;
            if let Some(counters) = server.news(Now::read().mono_ns) {
                let at = server.local_address()?;
                runtime::notice(format_args!(
                    "koseki: clients at {at} refused or disconnected: {counters}"
                ));
            }
        }
        Ok(())
    }

    /// Sends a block; blocks that cannot be sent are counted.
    pub(crate) fn send(&mut self, block: &[u8]) {
        match self {
            Self::Datagrams(sender) => drop(sender.send(block)),
            Self::Lines(server) => server.send(block),
        }
    }

    /// Adds the counts of datagrams, or of clients and the last one that was refused or disconnected.
    pub(crate) fn count(&self, entry: &mut HealthEntry) {
        match self {
            Self::Datagrams(sender) => {
                entry.set(Counter::DatagramsSent, sender.counters().sent);
                entry.set(Counter::SendFailures, sender.counters().failed);
            }
            Self::Lines(server) => {
                let counters = server.counters();
                entry.set(Counter::Connections, counters.admitted);
                entry.set(Counter::RequestsRejected, counters.all_refused());
                if counters.last.is_some() {
                    entry.refusal = format!("clients: {counters}");
                }
            }
        }
    }

    /// Address at which clients connect; `None` for datagrams.
    #[cfg(test)]
    pub(crate) fn listening_at(&self) -> Option<SocketAddr> {
        match self {
            Self::Datagrams(_) => None,
            Self::Lines(server) => server.local_address().ok(),
        }
    }
}
