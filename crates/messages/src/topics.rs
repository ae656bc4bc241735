//! Topics: name, sample type and all sizes, in one place.
//!
//! Publisher and subscriber must open a topic with the same sizes, so these are defined only here.

use std::fmt;
use std::marker::PhantomData;

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::codes;
use crate::layout::Sample;
use crate::{
    Alarm, Alert, Cue, Decision, FrameOrigin, Health, Order, OrderState, PlatformState, Progress, Restored,
    SensorArrival, SensorBearing, SensorDetection, SensorFix, SensorSpectrum, SensorTrack, SystemTrack,
    TargetStatement, WideArea, WorkStep,
};

/// Name of a topic in shared memory.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TopicName(String);

impl TopicName {
    /// Returns the name as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for TopicName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Capacity of a topic. Memory is about `subscribers × depth` slices of `slice_len` samples per publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopicCapacity {
    /// Number of waiting slices per subscriber before the oldest is dropped (and counted by the subscriber). A
    /// subscriber may request another number, up to the number with which the topic was created.
    pub depth: usize,
    /// Maximum number of samples in a slice.
    pub slice_len: usize,
    /// Maximum number of publishers at a time, including terminated publishers not yet cleaned up.
    pub publishers: usize,
    /// Maximum number of subscribers at a time.
    pub subscribers: usize,
}

codes! {
    /// Kind of topic with data samples, as opposed to messages between processes.
    pub enum Stream: u8 {
        /// Sensor tracks of a source.
        SensorTracks = 1, "sensor-tracks";
        /// Detections of a source.
        Detections = 2, "detections";
        /// Bearings of a source.
        Bearings = 3, "bearings";
        /// States of the platform that carries a source's sensor.
        PlatformStates = 4, "platform-states";
        /// Cues for the sensor of a source.
        Cues = 5, "cues";
        /// Reports of a wide-area sensor.
        WideArea = 6, "wide-area";
        /// System tracks.
        SystemTracks = 7, "system-tracks";
        /// Alarms.
        Alarms = 8, "alarms";
        /// Decisions of fusion.
        Decisions = 9, "decisions";
        /// States of orders.
        Orders = 10, "orders";
        /// Arrival times of a source.
        Arrivals = 11, "arrivals";
        /// Ready-made fixes of a source.
        Fixes = 12, "fixes";
        /// What the targets of a source state beside their motion.
        Statements = 13, "statements";
        /// Alerts on targets.
        Alerts = 14, "alerts";
    }
}

/// Stream of one source or sensor, identified as in [`Progress`](crate::Progress).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamId {
    /// Kind of topic.
    pub stream: Stream,
    /// Number of the source or wide-area sensor; 0 for streams of the system as a whole.
    pub number: u16,
}

impl Stream {
    /// Whether a recorded input delivers the stream again, complete and without repetition. The other streams
    /// result from these.
    pub const fn is_replayed(self) -> bool {
        matches!(self, Self::SensorTracks | Self::Detections | Self::WideArea)
    }
}

impl StreamId {
    /// System tracks.
    pub const SYSTEM_TRACKS: Self = Self {
        stream: Stream::SystemTracks,
        number: 0,
    };
    /// Alarms.
    pub const ALARMS: Self = Self {
        stream: Stream::Alarms,
        number: 0,
    };
    /// Alerts on targets.
    pub const ALERTS: Self = Self {
        stream: Stream::Alerts,
        number: 0,
    };
    /// Decisions of fusion.
    pub const DECISIONS: Self = Self {
        stream: Stream::Decisions,
        number: 0,
    };
    /// States of orders.
    pub const ORDERS: Self = Self {
        stream: Stream::Orders,
        number: 0,
    };
}

/// Topic of samples `T`.
#[derive(Clone, Debug)]
pub struct Topic<T> {
    /// Name in shared memory.
    pub name: TopicName,
    /// Sizes.
    pub capacity: TopicCapacity,
    sample: PhantomData<fn() -> T>,
}

impl<T> Topic<T> {
    fn new(name: String, capacity: TopicCapacity) -> Self {
        Self {
            name: TopicName(name),
            capacity,
            sample: PhantomData,
        }
    }
}

/// Sample of one of the data streams.
pub trait Streamed: Sample {
    /// Stream of the sample type.
    const STREAM: Stream;

    /// Returns the topic of the source or sensor called `name`; the system tracks have a single topic.
    fn topic(name: &str) -> Topic<Self>;

    /// Sequence number at its publisher.
    fn sequence(&self) -> u64;

    /// Time of the data, UTC, nanoseconds since 1970.
    fn time_ns(&self) -> i64;
}

macro_rules! streamed {
    ($( $sample:ident: $stream:ident, $topic:expr, $time:ident; )*) => {
        $( impl Streamed for $sample {
            const STREAM: Stream = Stream::$stream;

            fn topic(name: &str) -> Topic<Self> {
                $topic(name)
            }

            fn sequence(&self) -> u64 {
                self.sequence
            }

            fn time_ns(&self) -> i64 {
                self.$time
            }
        } )*
    };
}

streamed! {
    SensorTrack: SensorTracks, sensor_tracks, time_of_measurement_ns;
    SensorDetection: Detections, sensor_detections, time_of_measurement_ns;
    SensorBearing: Bearings, sensor_bearings, time_of_measurement_ns;
    SensorArrival: Arrivals, sensor_arrivals, time_of_measurement_ns;
    SensorFix: Fixes, sensor_fixes, time_of_measurement_ns;
    TargetStatement: Statements, target_statements, time_ns;
    PlatformState: PlatformStates, platform_states, time_ns;
    Cue: Cues, cues, time_ns;
    WideArea: WideArea, wide_area, time_of_observation_ns;
    SystemTrack: SystemTracks, |_| system_tracks(), reference_time_ns;
    Alarm: Alarms, |_| alarms(), time_ns;
    Alert: Alerts, |_| alerts(), time_ns;
    Decision: Decisions, |_| decisions(), time_ns;
    OrderState: Orders, |_| order_states(), time_ns;
}

/// Operation on a topic of any sample type: see [`visit`].
pub trait Visitor {
    /// Result of the visit.
    type Output;

    /// Executes the operation.
    fn visit<T: Sample + ZeroCopySend + fmt::Debug + 'static>(self, topic: Topic<T>) -> Self::Output;
}

/// Returns the part of `name` in place of the braces of `pattern`, if `name` matches the pattern; an empty text if
/// the pattern has no braces and equals the name.
fn matched<'a>(pattern: &str, name: &'a str) -> Option<&'a str> {
    let Some((before, rest)) = pattern.split_once('{') else {
        return (pattern == name).then_some("");
    };
    let (_, after) = rest.split_once('}')?;
    let of = name.strip_prefix(before)?.strip_suffix(after)?;
    (!of.is_empty() && !of.contains('/')).then_some(of)
}

/// Sample published by sources and sensors.
pub trait Outgoing: Streamed + ZeroCopySend + fmt::Debug + Default + 'static {
    /// Sets the sequence number at its publisher and the time of publication (monotonic, nanoseconds).
    fn leave(&mut self, sequence: u64, sent_ns: i64);

    /// Sets the time at which the sample's input arrived (monotonic, nanoseconds).
    fn came_in(&mut self, ingested_ns: i64);

    /// Returns the time at which the sample's input arrived (monotonic, nanoseconds).
    fn ingested_ns(&self) -> i64;
}

macro_rules! outgoing {
    ($($sample:ty),*) => {
        $(impl Outgoing for $sample {
            fn leave(&mut self, sequence: u64, sent_ns: i64) {
                self.sequence = sequence;
                self.stages.published_ns = sent_ns;
            }

            fn came_in(&mut self, ingested_ns: i64) {
                self.stages.ingested_ns = ingested_ns;
            }

            fn ingested_ns(&self) -> i64 {
                self.stages.ingested_ns
            }
        })*
    };
}

outgoing!(
    Cue,
    PlatformState,
    SensorArrival,
    SensorBearing,
    SensorDetection,
    SensorFix,
    SensorTrack,
    TargetStatement,
    WideArea
);

/// Declares topics: sample, name, number of waiting slices and samples in each, maximum numbers of publishers and
/// subscribers.
macro_rules! topics {
    ($(
        $(#[doc = $doc:literal])+
        $topic:ident($($of:ident)?) -> $sample:ident: $name:literal, $depth:literal slices of $slice_len:literal,
        $publishers:literal to $subscribers:literal;
    )+) => { $(
        $(#[doc = $doc])+
        pub fn $topic($($of: &str)?) -> Topic<$sample> {
            let capacity = TopicCapacity {
                depth: $depth,
                slice_len: $slice_len,
                publishers: $publishers,
                subscribers: $subscribers,
            };
            Topic::new(format!($name), capacity)
        }
    )+

    /// Passes the topic called `name` to `visitor`, for programs that receive its name at run time; `None` if no
    /// topic has this name.
    pub fn visit<V: Visitor>(name: &str, visitor: V) -> Option<V::Output> {
        $(
            if let Some(_of) = matched($name, name) {
                return Some(visitor.visit($topic($( { let $of = _of; $of } )?)));
            }
        )+
        None
    } };
}

topics! {
    /// Sensor tracks of one source: a topic per source, so that a flood from one source cannot displace the reports
    /// of another.
    sensor_tracks(source_name) -> SensorTrack: "sensor/{source_name}/tracks", 256 slices of 64, 4 to 16;

    /// Detections of one source whose adapter forms tracks from them: a scan at a time, before the resulting
    /// tracks.
    sensor_detections(source_name) -> SensorDetection: "sensor/{source_name}/detections", 256 slices of 64, 4 to 16;

    /// Bearings of one source whose adapter locates their transmitters, before the resulting tracks.
    sensor_bearings(source_name) -> SensorBearing: "sensor/{source_name}/bearings", 256 slices of 64, 4 to 16;

    /// Arrival times of one source whose adapter locates their transmitters, before the resulting tracks.
    sensor_arrivals(source_name) -> SensorArrival: "sensor/{source_name}/arrivals", 256 slices of 64, 4 to 16;

    /// Ready-made fixes of one source whose adapter selects or joins them, before the resulting tracks.
    sensor_fixes(source_name) -> SensorFix: "sensor/{source_name}/fixes", 256 slices of 64, 4 to 16;

    /// What the targets of one source state beside their motion (category, size, status, selected altitude), when some
    /// of it changes, and for each target once a minute.
    target_statements(source_name) -> TargetStatement: "sensor/{source_name}/statements", 64 slices of 64, 4 to 16;

    /// Spectra of one source that measures bearings with an antenna array. They are computed and published only while
    /// the topic has subscribers, and are not recorded.
    sensor_spectrum(source_name) -> SensorSpectrum: "sensor/{source_name}/spectrum", 16 slices of 4, 4 to 16;

    /// Position of a platform, for its sensors: published by the sensor's adapter or by a separate process.
    platform_states(platform_name) -> PlatformState: "platform/{platform_name}/state", 64 slices of 16, 4 to 16;

    /// Reports of a wide-area sensor: read by every connected tracker, and by the recorder.
    wide_area(sensor_name) -> WideArea: "wide-area/{sensor_name}/reports", 64 slices of 64, 4 to 72;

    /// Positions for the next look of a source's sensor: after each scan, one cue for each confirmed track.
    cues(source_name) -> Cue: "sensor/{source_name}/cues", 64 slices of 64, 4 to 16;

    /// Fused track picture: one slice per processed batch, in the order of fusion.
    system_tracks() -> SystemTrack: "system/tracks", 256 slices of 64, 4 to 24;

    /// Track picture fused from the sources of this deployment alone, for other centres: each state names the
    /// contributing sensors. Published if `fusion.exchange` requests it.
    own_tracks() -> SystemTrack: "system/own-tracks", 256 slices of 64, 4 to 8;

    /// Fused track picture of some seconds ago, smoothed with the measurements since then, if `fusion.smoothing_lag_s`
    /// requests it.
    smoothed_tracks() -> SystemTrack: "system/smoothed", 256 slices of 64, 4 to 16;

    /// Alarms from the monitor. Each slice replaces the previous slice, and slices are sent twice a second, so a
    /// late subscriber has the standing alarms after half a second.
    alarms() -> Alarm: "system/alarms", 16 slices of 64, 2 to 32;

    /// Alerts on targets, by the rules of `[[alert]]`. Each slice replaces the previous slice; a slice is sent after
    /// each change, and twice a second, so a late subscriber has all alerts in force after half a second.
    alerts() -> Alert: "system/alerts", 16 slices of 256, 2 to 32;

    /// Decisions of fusion, if `[fusion] decisions` requests them: a few hundredths of a second after the resulting
    /// states.
    decisions() -> Decision: "system/decisions", 64 slices of 64, 2 to 16;

    /// Origin of the system frame, published repeatedly for subscribers without the configuration.
    frame_origin() -> FrameOrigin: "system/frame-origin", 2 slices of 1, 4 to 16;

    /// State and counters of every process.
    // One publisher per process: 128 sources, the services, and restarted processes whose predecessor is not yet
    // removed.
    health() -> Health: "health", 8 slices of 80, 160 to 16;

    /// Progress of each consumer of recorded data.
    // Published by fusion and recorder, read by every adapter of a recording.
    progress() -> Progress: "progress", 16 slices of 80, 8 to 160;

    /// Initial state of a fusion with a predecessor: bit by bit, in the first moments.
    restored() -> Restored: "system/restored", 64 slices of 32, 4 to 4;

    /// Orders of operators and of the recorder to fusion.
    orders() -> Order: "orders", 16 slices of 1, 16 to 4;

    /// Orders in force, and orders that ended recently. Each slice replaces the previous slice; fusion sends a slice
    /// after each change, and twice a second while the list is not empty.
    order_states() -> OrderState: "system/order-states", 16 slices of 128, 2 to 32;

    /// Event log of fusion, which outlives fusion. The capacity covers thirteen seconds at 20,000 reports a second.
    event_log() -> WorkStep: "system/order", 262144 slices of 1, 1 to 16;
}
