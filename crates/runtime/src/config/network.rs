//! What a deployment takes from the network and gives to it.

use std::hash::Hasher as _;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;

use asterix::{Category, Decoder, Mode};
use formats::sbs::SbsSettings;
use outgoing::HeightReference;
use rustc_hash::FxHasher;

/// A network input: one socket, read by one adapter process, with one sensor or several behind it.
#[derive(Clone, Debug)]
pub struct Receiver {
    /// Its name, which is that of its adapter process.
    pub name: String,
    /// Where the data come from.
    pub transport: Transport,
}

/// Where a receiver's data come from.
#[derive(Clone, Debug)]
pub enum Transport {
    /// ASTERIX in datagrams.
    Udp(net::ReceiverSettings),
    /// ASTERIX in datagrams to this port of the deployment's own loopback address: what the simulator sends.
    Loopback {
        /// The port.
        port: u16,
    },
    /// Lines of SBS-1 (BaseStation) from a server.
    Sbs {
        /// The server.
        server: SocketAddr,
        /// How its lines are read.
        settings: SbsSettings,
    },
}

/// How ASTERIX records are read.
#[derive(Clone, Debug)]
pub struct Asterix {
    /// Tables of the categories whose edition the file states.
    pub tables: Vec<&'static Category>,
    /// How closely records must follow their edition.
    pub mode: Mode,
}

impl Asterix {
    /// A decoder that reads so.
    pub fn decoder(&self) -> Decoder {
        let decoder = Decoder::new(self.mode);
        self.tables
            .iter()
            .fold(decoder, |decoder, table| decoder.with_table(table))
    }
}

/// A source behind a receiver.
#[derive(Clone, Debug)]
pub struct Live {
    /// Name of the receiver.
    pub receiver: String,
    /// How its records are read.
    pub asterix: Asterix,
}

/// An output to the network: one gateway process.
#[derive(Clone, Debug)]
pub struct Gateway {
    /// Its name, which is that of its process.
    pub name: String,
    /// Where its datagrams go, and how.
    pub sender: net::SenderSettings,
    /// What it sends.
    pub content: GatewayContent,
    /// What it sends in: category and edition.
    pub table: &'static Category,
    /// System area code that it sends under.
    pub sac: u8,
    /// System identification code that it sends under.
    pub sic: u8,
    /// Time between two reports of one track, nanoseconds; 0 to send each report as it comes.
    pub refresh_ns: i64,
    /// Time between two status messages, nanoseconds.
    pub status_ns: i64,
    /// Most octets in a datagram.
    pub block_bytes: usize,
    /// What the heights of its tracks are, and so which items carry them.
    pub heights: HeightReference,
}

/// What a gateway sends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GatewayContent {
    /// The fused picture.
    SystemTracks,
    /// The sensor tracks of one source, by number.
    SensorTracks(u16),
}

/// The loopback address that belongs to the deployment with its shared memory at `root`.
///
/// All of 127.0.0.0/8 is the machine itself. An address of its own for each deployment lets several with the same ports
/// run side by side, without asking anyone which ports are free. The upper half is used, as the lower holds addresses
/// that systems give to their own services.
pub(crate) fn loopback_of(root: &Path) -> Ipv4Addr {
    let mut hasher = FxHasher::default();
    hasher.write(root.as_os_str().as_encoded_bytes());
    let [.., a, b, c] = (hasher.finish() >> 8).to_be_bytes();
    Ipv4Addr::new(127, 128 | a, b, c.clamp(1, 254))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_deployment_has_a_loopback_address_of_its_own() {
        let address = |i: u32| loopback_of(Path::new(&format!("/run/koseki/instance-{i}")));
        let mut addresses: Vec<Ipv4Addr> = (0..1000).map(address).collect();
        assert!(addresses.iter().all(Ipv4Addr::is_loopback));
        assert_eq!(address(5), address(5));
        addresses.sort_unstable();
        addresses.dedup();
        assert!(addresses.len() >= 999, "{} different ones", addresses.len());
    }
}
