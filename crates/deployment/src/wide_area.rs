//! Wide-area sensors, which count targets and are no sources.

use std::path::PathBuf;

use crate::network::Asterix;

/// One wide-area sensor.
#[derive(Clone, Debug)]
pub struct WideAreaSensor {
    /// Its number: its place among the wide-area sensors in the file, from 0.
    pub number: u16,
    /// Its name, which is also part of its topic's name.
    pub name: String,
    /// Where its reports come from.
    pub input: WideAreaInput,
    /// Name of the adapter process that publishes it: that of its receiver, or its own.
    pub adapter: String,
    /// True for a simulated sensor: its rows come over the loopback network, to a receiver of its own name.
    pub is_simulated: bool,
}

/// Where the reports of a wide-area sensor come from.
#[derive(Clone, Debug)]
pub enum WideAreaInput {
    /// Rows of counts (FM-6) in the datagrams of the receiver of this name.
    Live(String),
    /// A file of rows (FM-6), relative to the data folder unless absolute.
    Recorded(PathBuf),
    /// Another system's tracks, counted by place.
    Tracks(Box<CountedTracks>),
    /// A process that is no part of the deployment publishes the topic.
    External,
}

/// Another system's tracks, and how they become counts.
#[derive(Clone, Debug)]
pub struct CountedTracks {
    /// Where they come from.
    pub feed: TrackFeed,
    /// How their records are read.
    pub asterix: Asterix,
    /// Time between two reports of one track, nanoseconds: tracks of one period are counted together.
    pub period_ns: i64,
    /// Tracks that are no farther from each other make one report, metres.
    pub group_m: f64,
}

/// Where another system's tracks come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TrackFeed {
    /// Datagrams of the receiver of this name.
    Receiver(String),
    /// A recording, relative to the data folder unless absolute.
    File(PathBuf),
}

impl WideAreaSensor {
    /// The receiver that it is behind, if it is behind one.
    pub fn receiver(&self) -> Option<&str> {
        match &self.input {
            WideAreaInput::Live(receiver) => Some(receiver),
            WideAreaInput::Tracks(tracks) => match &tracks.feed {
                TrackFeed::Receiver(receiver) => Some(receiver),
                TrackFeed::File(_) => None,
            },
            WideAreaInput::Recorded(_) | WideAreaInput::External => None,
        }
    }

    /// The recording that its reports come from, if they come from one.
    pub fn recording(&self) -> Option<&PathBuf> {
        match &self.input {
            WideAreaInput::Recorded(file) => Some(file),
            WideAreaInput::Tracks(tracks) => match &tracks.feed {
                TrackFeed::File(file) => Some(file),
                TrackFeed::Receiver(_) => None,
            },
            WideAreaInput::Live(_) | WideAreaInput::External => None,
        }
    }
}
