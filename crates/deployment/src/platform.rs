//! Platforms that carry sensors: where their states come from.

use std::net::SocketAddr;
use std::path::PathBuf;

use crate::network::DatagramInput;

/// One platform.
#[derive(Clone, Debug)]
pub struct Platform {
    /// Its number: its place among the platforms in the file, from 0.
    pub number: u16,
    /// Its name, which is that of its process, and part of its topic's name.
    pub name: String,
    /// Where its states come from.
    pub input: PlatformInput,
    /// True for a simulated platform: its sentences come over the loopback network.
    pub is_simulated: bool,
    /// Name of the receiver of rows from its simulated radar, if a sensor is that radar.
    pub radar: Option<String>,
    /// Largest distance of its states from the frame's origin, metres.
    pub range_m: f64,
    /// Standard deviation of the delay of sentences without a time, seconds.
    pub receipt_sigma_s: f64,
    /// Time without a state after which the platform is silent, nanoseconds.
    pub silent_after_ns: i64,
    /// Time by which a sensor's data may run ahead of the states, while a detection waits for a state, nanoseconds.
    pub wait_ns: i64,
}

/// Where the states of a platform come from.
#[derive(Clone, Debug)]
pub enum PlatformInput {
    /// Sentences of NMEA 0183, or rows of states, received by a process of its own.
    Live(PlatformFeed),
    /// Rows of states in a file, relative to the data folder unless absolute; tracker processes read it themselves.
    Recorded(PathBuf),
    /// A process that is no part of the deployment publishes the topic.
    External,
}

/// Where the bytes of a live platform come from.
#[derive(Clone, Debug)]
pub enum PlatformFeed {
    /// Datagrams.
    Udp(DatagramInput),
    /// Datagrams to this port of the deployment's own loopback address: what the simulator sends.
    Loopback(u16),
    /// Lines from a server.
    Tcp(SocketAddr),
    /// A serial device, or any other file that is read as it grows.
    Device(PathBuf),
}

impl Platform {
    /// Whether a process of the deployment receives its states.
    pub fn has_process(&self) -> bool {
        matches!(self.input, PlatformInput::Live(_))
    }
}
