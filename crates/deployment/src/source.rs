//! Sources of a deployment, and the inputs of their data.

use std::path::PathBuf;

use frames::SensorFrame;
use settings::Seconds;

use crate::network::{Asterix, FeedFormat, FeedOrigin, Live};
use crate::technology::Technology;

/// One source.
#[derive(Clone, Debug)]
pub struct Source {
    /// Its number: its place in the file, from 0.
    pub number: u16,
    /// Identity of the sensor, the same in every deployment that hears it.
    pub uid: u32,
    /// Its name, which is also part of its topic's name.
    pub name: String,
    /// Where its data come from.
    pub input: Input,
    /// Name of the adapter process that publishes it: that of its receiver, or its own.
    pub adapter: String,
    /// How it observes.
    pub technology: Technology,
    /// SAC and SIC of the sensor, if it has any.
    pub sac_sic: Option<(u8, u8)>,
    /// Where it stands.
    pub frame: SensorFrame,
    /// Latitude and longitude where the file states that it stands, degrees.
    pub stated_place_deg: Option<[f64; 2]>,
    /// Whether its targets state facts beside their motion: the source is a live feed.
    pub has_statements: bool,
    /// Distance of a time from that of receipt beyond which the time is not believed.
    pub clock_step: Seconds,
    /// Most of its tracks at a time.
    pub tracks_max: usize,
    /// Samples that it delivers.
    pub delivers: SampleDelivery,
    /// Other sources that its tracker listens to.
    pub links: Links,
    /// Platform that moves, which carries the sensor; `None` if it is at rest, or detections state their places in the
    /// system frame.
    pub on_board: Option<OnBoard>,
    /// True if operators' orders to the tracker are the detections of this sensor.
    pub takes_orders: bool,
    /// Silence of its adapter's input that is an alarm, nanoseconds; `None` if none is. Nothing is expected of a
    /// recording.
    pub silent_after_ns: Option<i64>,
    /// Time between two reports of one target, nanoseconds.
    pub period_ns: i64,
    /// Whether the deployment ends where its adapter cannot be kept running.
    pub required: bool,
}

/// Sources that a source's tracker listens to besides its own detections.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Links {
    /// Numbers of the wide-area sensors, ascending.
    pub wide_area_sensors: Vec<u16>,
    /// Numbers of the sources, direction finders, whose emissions it hears, ascending.
    pub emissions: Vec<u16>,
}

/// Place of a sensor on a platform that moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OnBoard {
    /// Number of the platform; `None` if each detection states the platform's state itself.
    pub platform: Option<u16>,
}

impl Source {
    /// Whether it publishes detections: those behind its tracks, or for a tracker process.
    pub fn has_detections(&self) -> bool {
        matches!(
            self.delivers,
            SampleDelivery::Detections { .. } | SampleDelivery::Plots { .. }
        )
    }

    /// Whether it publishes tracks; a sensor of a tracker process does not.
    pub fn has_tracks(&self) -> bool {
        !matches!(self.delivers, SampleDelivery::Plots { .. })
    }

    /// Whether its detections come as rows of a table.
    pub fn has_rows(&self) -> bool {
        matches!(
            self.delivers,
            SampleDelivery::Plots {
                format: PlotFormat::Rows,
                ..
            }
        )
    }

    /// Whether its tracks are made of its bearings.
    pub fn has_bearings(&self) -> bool {
        matches!(self.delivers, SampleDelivery::Bearings { .. })
    }

    /// Returns whether the source publishes bearings and the places of its finder; a recording publishes tracks only.
    pub fn publishes_bearings(&self) -> bool {
        self.has_bearings() && !self.input.is_recorded()
    }

    /// Whether its bearings are measured from snapshots of an antenna array.
    pub fn has_array(&self) -> bool {
        self.delivers == SampleDelivery::Bearings { array: true }
    }

    /// Whether arrival times and fixes of emitters may come in place of its bearings, or beside them.
    pub fn has_emitter_rows(&self) -> bool {
        let is_live = matches!(self.input, Input::Live(_));
        is_live && self.delivers == SampleDelivery::Bearings { array: false }
    }

    /// Whether its tracker publishes places for the sensor's next look.
    pub fn has_cues(&self) -> bool {
        self.delivers == SampleDelivery::Detections { cues: true }
    }

    /// Whether its sensor tracks reach fusion as they come, checked by no adapter.
    pub fn is_taken_as_it_is(&self) -> bool {
        match &self.input {
            Input::External => true,
            Input::Recorded(recorded) => recorded.format == RecordedFormat::SensorTracks,
            Input::Simulated(_) | Input::Live(_) | Input::Tracker(_) => false,
        }
    }
}

impl Input {
    /// Whether the data are recorded.
    pub fn is_recorded(&self) -> bool {
        match self {
            Self::Recorded(_) => true,
            Self::Tracker(tracker) => tracker.is_recorded,
            Self::Simulated(_) | Self::Live(_) | Self::External => false,
        }
    }
}

/// Samples that a source delivers besides its tracks: they decide on its topics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SampleDelivery {
    /// None: the sensor tracks its targets.
    #[default]
    Tracks,
    /// Detections, of which its adapter makes tracks.
    Detections {
        /// Whether the tracker publishes cues.
        cues: bool,
    },
    /// Bearings and states of the platform, of which its adapter makes tracks.
    Bearings {
        /// Whether the bearings are measured from snapshots of an antenna array.
        array: bool,
    },
    /// Detections and no tracks: a sensor of a tracker process.
    Plots {
        /// Content of the datagrams or of the file.
        format: PlotFormat,
        /// Number of the sensor in rows; `None` takes all rows.
        sensor_id: Option<u32>,
    },
}

/// Where a source's data come from.
#[derive(Clone, Debug)]
pub enum Input {
    /// A recording.
    Recorded(Recorded),
    /// A simulated sensor, whose reports come over the loopback network like those of a real one.
    Simulated(Live),
    /// A sensor behind a receiver.
    Live(Live),
    /// A process that is no part of the deployment publishes the source's topic.
    External,
    /// A tracker process that joins the detections of several sensors.
    Tracker(TrackerInput),
}

/// Sensors of a tracker process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrackerInput {
    /// Places in [`Deployment::tracker_sensors`](crate::Deployment::tracker_sensors), in the order of the tracker's
    /// sensors.
    pub sensors: std::ops::Range<usize>,
    /// Whether all of them are recordings.
    pub is_recorded: bool,
}

/// A recorded input.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// File, relative to the data folder unless absolute.
    pub file: PathBuf,
    /// Content of the file.
    pub format: RecordedFormat,
    /// How its ASTERIX records are read.
    pub asterix: Asterix,
    /// Positions of a feed that the source uses.
    pub origin: FeedOrigin,
    /// How far reports may come out of order, nanoseconds.
    pub reorder_ns: i64,
    /// Whether the file may end in the middle of a data block.
    pub truncated: Truncated,
}

settings::words! {
    /// Content of a recorded file.
    pub enum RecordedFormat {
        /// ASTERIX, as bare data blocks or in a capture file.
        Asterix = "asterix",
        /// Lines of SBS-1 (BaseStation).
        Sbs = "sbs",
        /// Mode S frames: Beast, AVR, or hexadecimal lines with or without times.
        ModeS = "mode-s",
        /// AIS: lines of NMEA 0183.
        Ais = "ais",
        /// Targets that ships' radars track: sentences TTM and TLL of NMEA 0183.
        RadarTargets = "radar-targets",
        /// JSON of readsb and its relatives: documents, lines of history, traces.
        Readsb = "readsb",
        /// Lines of JSON with messages of Remote ID.
        RemoteId = "remote-id",
        /// Events of Cursor on Target (XML).
        Cot = "cot",
        /// A table of sensor tracks (FM-5).
        SensorTracks = "sensor-tracks",
    }
}

impl RecordedFormat {
    /// The feed whose data the file holds; `None` if the data are of no feed.
    pub const fn feed(self) -> Option<FeedFormat> {
        match self {
            Self::Sbs => Some(FeedFormat::Sbs),
            Self::ModeS => Some(FeedFormat::ModeS),
            Self::Ais => Some(FeedFormat::Ais),
            Self::RadarTargets => Some(FeedFormat::RadarTargets),
            Self::Readsb => Some(FeedFormat::Readsb),
            Self::RemoteId => Some(FeedFormat::RemoteId),
            Self::Cot => Some(FeedFormat::Cot),
            Self::Asterix | Self::SensorTracks => None,
        }
    }
}

settings::words! {
    /// Content of a tracker sensor's datagrams or file.
    pub enum PlotFormat {
        /// ASTERIX.
        Asterix = "asterix",
        /// Rows of detections (FM-6); a datagram is a table of its own.
        Rows = "rows",
        /// A scenario of the Autoferry data set; files only.
        Autoferry = "autoferry",
    }
}

settings::words! {
    /// Use of a recording that ends within a data block, after a kill of the recorder or an incomplete copy.
    pub enum Truncated {
        /// Refuse it before anything starts: more than one block may be missing.
        Refuse = "refuse",
        /// Use it without its last block.
        Accept = "accept",
    }
}
