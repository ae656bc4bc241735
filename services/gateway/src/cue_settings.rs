//! Keys of cue outlets.

use std::fmt;
use std::net::SocketAddr;

use deployment::{Deployment, NetworkOutput};
use net::{Interface, SenderSettings};
use settings::SettingsError;

use crate::destination::{Destination, sender_mistake};

settings::settings! {
    /// Outlet of a source's cues to sensor controllers: rows in datagrams, or over connections (WA-12).
    pub struct CueOutletSettings {
        check CueOutletSettings::check;
        /// Name of the process.
        name: String;
        /// Source whose tracker makes the cues.
        source: String;
        /// Multicast group or address, with the port, as destination of the datagrams; each has a header line.
        send_to: Option<Destination> = None, usually "none: controllers connect";
        /// Interface on which datagrams leave, by address, name or index.
        interface: Option<String> = None, usually "the machine's choice";
        /// Time to live of the datagrams. Without the key, 1 for a group: the datagrams stay in the local network.
        ttl: Option<u8> = None, usually "the machine's choice";
        /// Address and port at which controllers connect (TCP); each gets a header line and all following rows.
        listen: Option<Destination> = None, usually "none: datagrams are sent";
        /// Largest size of a datagram, bytes: by default the room of an Ethernet frame beside the headers of IPv4 and
        /// UDP.
        block_bytes: usize = 1472, in [256, 65_507];
    }
}

/// How rows leave.
#[derive(Clone, Debug)]
pub(crate) enum CueWay {
    /// In datagrams.
    Datagrams(SenderSettings),
    /// As lines to each controller that connects.
    Lines(SocketAddr),
}

impl fmt::Display for CueWay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Datagrams(sender) => write!(f, "sending to {}", sender.destination),
            Self::Lines(address) => write!(f, "listening at {address}"),
        }
    }
}

impl CueOutletSettings {
    fn check(&self) -> Result<(), SettingsError> {
        let way = self.way()?;
        match way {
            CueWay::Datagrams(sender) => sender.check().map_err(sender_mistake),
            CueWay::Lines(_) if self.interface.is_some() || self.ttl.is_some() => {
                let what = "is about datagrams, but controllers connect; leave it out";
                let key = if self.interface.is_some() { "interface" } else { "ttl" };
                Err(SettingsError::new(key, what))
            }
            CueWay::Lines(_) => Ok(()),
        }
    }

    /// Returns how rows leave.
    ///
    /// # Errors
    /// If not exactly one way is given.
    pub(crate) fn way(&self) -> Result<CueWay, SettingsError> {
        match (self.send_to, self.listen) {
            (Some(to), None) => {
                let interface = |text: &str| -> Interface {
                    let Ok(interface) = text.parse();
                    interface
                };
                Ok(CueWay::Datagrams(SenderSettings {
                    interface: self.interface.as_deref().map(interface),
                    time_to_live: self.ttl,
                    ..SenderSettings::new(to.0)
                }))
            }
            (None, Some(at)) => Ok(CueWay::Lines(at.0)),
            _ => {
                let what = "give either send_to (datagrams) or listen (connections of controllers)";
                Err(SettingsError::new("", what))
            }
        }
    }

    /// Checks the source, and returns the facts that other processes need.
    ///
    /// # Errors
    /// If the deployment has no such source, or the source has no cues.
    pub(crate) fn output(&self, deployment: &Deployment) -> Result<NetworkOutput, SettingsError> {
        let name = &self.source;
        let Some(source) = deployment.source(name) else {
            return Err(SettingsError::new(
                "source",
                format!("there is no source named \"{name}\""),
            ));
        };
        if !source.has_cues() {
            let what = format!(
                "\"{name}\" makes no cues; they need a live source with cues = true in its [source.tracker] or [[tracker]]"
            );
            return Err(SettingsError::new("source", what));
        }
        Ok(NetworkOutput {
            name: self.name.clone(),
            sender: match self.way()? {
                CueWay::Datagrams(sender) => Some(sender),
                CueWay::Lines(_) => None,
            },
        })
    }
}
