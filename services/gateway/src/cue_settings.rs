//! Keys of cue outlets.

use deployment::{Deployment, NetworkOutput};
use settings::SettingsError;

use crate::destination::Destination;
use crate::outlet::{OutletKeys, OutletWay};

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
        /// Permit a `listen` that other machines can reach: whoever reaches it reads everything, unencrypted.
        remote: bool = false;
        /// Largest size of a datagram, bytes: by default the room of an Ethernet frame beside the headers of IPv4 and
        /// UDP.
        block_bytes: usize = 1472, in [256, 65_507];
    }
}

impl CueOutletSettings {
    fn check(&self) -> Result<(), SettingsError> {
        self.way().map(|_| ())
    }

    /// Returns how rows leave.
    ///
    /// # Errors
    /// If not exactly one way is given, or a key does not fit the way.
    pub(crate) fn way(&self) -> Result<OutletWay, SettingsError> {
        self.outlet().way()
    }

    fn outlet(&self) -> OutletKeys<'_> {
        OutletKeys {
            send_to: self.send_to,
            listen: self.listen,
            interface: self.interface.as_deref(),
            ttl: self.ttl,
            remote: self.remote,
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
            sender: self.outlet().datagrams()?,
        })
    }
}
