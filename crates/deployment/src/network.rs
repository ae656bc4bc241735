//! Network inputs and outputs of a deployment.

use std::net::SocketAddr;

use asterix::{Category, Decoder, Mode, registry};
use formats::sbs::SbsSettings;
use outgoing::HeightReference;

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
    /// Table that a category is read by; `None` if there is none.
    pub fn table(&self, category: u8) -> Option<&'static Category> {
        let stated = self.tables.iter().find(|table| table.number == category).copied();
        stated.or_else(|| registry::default_edition(category))
    }

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

/// A part of the Earth between two parallels and two meridians (WGS-84), degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Latitudes of the south and the north side, −90 to 90.
    pub latitude_deg: [f64; 2],
    /// Longitudes of the west and the east side, −180 to 180; the west one is greater in an area across 180°.
    pub longitude_deg: [f64; 2],
}

/// An output to the network: one gateway process.
#[derive(Clone, Debug)]
pub struct Gateway {
    /// Its name, which is that of its process.
    pub name: String,
    /// Where its datagrams go, and how.
    pub sender: net::SenderSettings,
    /// Content that it sends.
    pub content: GatewayContent,
    /// Category and edition that it sends in.
    pub table: &'static Category,
    /// System area code of the sender.
    pub sac: u8,
    /// System identification code of the sender.
    pub sic: u8,
    /// Time between two reports of one track, nanoseconds; 0 to send each report as it comes.
    pub refresh_ns: i64,
    /// Time between two status messages, nanoseconds.
    pub status_ns: i64,
    /// Categories of the status messages that are sent with the fused picture.
    pub status: Vec<u8>,
    /// Area whose tracks are sent; `None`: all.
    pub area: Option<Area>,
    /// Lowest and highest flight level of which tracks are sent, hundreds of feet; `None`: all.
    pub levels: Option<[f64; 2]>,
    /// Most octets in a datagram.
    pub block_bytes: usize,
    /// Reference of its tracks' heights, and so the items that carry them.
    pub heights: HeightReference,
}

/// Content that a gateway sends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GatewayContent {
    /// The fused picture.
    SystemTracks,
    /// The fused picture as the sensors here know it.
    OwnTracks,
    /// The sensor tracks of one source, by number.
    SensorTracks(u16),
}
