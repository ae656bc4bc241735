//! Network inputs and outputs of a deployment.

use std::net::SocketAddr;

/// A network input: one socket, read by one adapter process, with one sensor or several behind it.
#[derive(Clone, Debug)]
pub struct Receiver {
    /// Its name, which is that of its adapter process.
    pub name: String,
    /// Where the data come from.
    pub transport: ReceiverTransport,
}

/// Where a receiver's data come from.
#[derive(Clone, Debug)]
pub enum ReceiverTransport {
    /// ASTERIX in datagrams.
    Udp(DatagramInput),
    /// ASTERIX in datagrams to this port of the deployment's own loopback address: what the simulator sends.
    Loopback {
        /// The port.
        port: u16,
    },
    /// Rows of detections from a server.
    Rows {
        /// The server.
        server: SocketAddr,
    },
    /// Reports of targets from a receiver of transponders or of AIS, or from a ship's radar.
    Feed(Feed),
}

/// A feed of a receiver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Feed {
    /// Content.
    pub format: FeedFormat,
    /// Where the data come from.
    pub link: FeedLink,
    /// How far the receiver's clock is ahead of UTC, minutes.
    pub ahead_of_utc_min: i32,
}

/// Where a feed comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FeedLink {
    /// A server, to which a connection is made.
    Tcp(SocketAddr),
    /// Datagrams.
    Udp(DatagramInput),
    /// Datagrams to this port of the deployment's own loopback address: what the simulator sends.
    Loopback {
        /// The port.
        port: u16,
    },
    /// A document that is fetched again and again.
    Http {
        /// Address of the document, beginning with `http://`.
        url: String,
        /// Time between two fetches, nanoseconds.
        period_ns: i64,
    },
}

settings::words! {
    /// Content of a feed.
    pub enum FeedFormat {
        /// Lines of SBS-1 (BaseStation).
        Sbs = "sbs",
        /// Mode S frames: Beast, AVR, or hexadecimal lines.
        ModeS = "mode-s",
        /// AIS: lines of NMEA 0183.
        Ais = "ais",
        /// Targets that ships' radars track: sentences TTM and TLL of NMEA 0183.
        RadarTargets = "radar-targets",
        /// JSON of readsb and its relatives.
        Readsb = "readsb",
        /// Lines of JSON with messages of Remote ID.
        RemoteId = "remote-id",
        /// Events of Cursor on Target (XML).
        Cot = "cot",
    }
}

settings::words! {
    /// Origin of the positions of a feed that a source uses.
    pub enum FeedOrigin {
        /// Every origin.
        Any = "any",
        /// Targets that state their own positions, and the targets of a radar.
        Own = "own",
        /// Multilateration by a network of receivers.
        Multilateration = "mlat",
        /// Ground stations about targets of other sensors.
        Traffic = "tis-b",
        /// Ground stations that repeat another link.
        Repeated = "ads-r",
    }
}

impl FeedFormat {
    /// Whether the data are lines of text.
    pub const fn is_lines(self) -> bool {
        matches!(self, Self::Sbs | Self::Ais | Self::RadarTargets | Self::RemoteId)
    }
}

/// Datagrams from the network, as the file states them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DatagramInput {
    /// An address of this machine (unspecified: all of them), or a multicast group, and the port.
    pub listen: SocketAddr,
    /// Interface on which a group is joined, by name, address or number.
    pub interface: Option<String>,
    /// Addresses and networks from which datagrams are accepted; all, if it is empty.
    pub senders: Vec<String>,
    /// Size of the kernel's buffer, bytes.
    pub buffer_bytes: usize,
}

/// Datagrams to the network, as the file states them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DatagramOutput {
    /// An address or a multicast group, with its port.
    pub send_to: SocketAddr,
    /// Interface by which a group is sent to, by name, address or number.
    pub interface: Option<String>,
    /// Time to live; `None`: the usual one.
    pub ttl: Option<u8>,
}

/// How ASTERIX records are read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Asterix {
    /// Categories whose edition the file states, each with the numbers before and behind the edition's point.
    pub editions: Vec<(u8, [u8; 2])>,
    /// True if records have to follow their edition closely.
    pub is_strict: bool,
}

/// A source behind a receiver.
#[derive(Clone, Debug)]
pub struct Live {
    /// Name of the receiver.
    pub receiver: String,
    /// How its records are read.
    pub asterix: Asterix,
    /// Positions of a feed that the source uses.
    pub origin: FeedOrigin,
}

/// An output to the network: one gateway process.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkOutput {
    /// Its name, which is that of its process.
    pub name: String,
    /// Where its datagrams go, and how; `None` if its readers connect.
    pub sender: Option<DatagramOutput>,
}
