//! Stages of a report from measurement to subscriber.

use messages::SystemTrack;

/// Stage of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Adapter: from the report's last byte to its publication in shared memory.
    IngestToPublish,
    /// Transport in: until fusion takes the report.
    PublishToTaken,
    /// Fusion: until the publication of the system track in shared memory.
    TakenToFused,
    /// Transport out: until the subscriber receives the state.
    FusedToReceived,
    /// All of these: from the report's last byte to the subscriber.
    EndToEnd,
    /// Age of the data: from the measurement to the subscriber, by the sensor's clock and this machine's UTC.
    Age,
}

/// End of a state's journey for a measurement.
///
/// A subscriber that is woken for every slice measures the whole journey. A subscriber that reads from time to time,
/// to spare the publisher the wake-ups, would measure its own pauses: for it, the journey ends at the publication by
/// fusion, and the last stage is not measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JourneyEnd {
    /// Reception of the state by the subscriber.
    #[default]
    Received,
    /// Publication of the state by fusion.
    Published,
}

impl Stage {
    /// All stages in the order of the journey.
    pub const ALL: [Self; 6] = [
        Self::IngestToPublish,
        Self::PublishToTaken,
        Self::TakenToFused,
        Self::FusedToReceived,
        Self::EndToEnd,
        Self::Age,
    ];

    /// Returns the name in logs, JSON and metrics.
    pub fn key(self) -> &'static str {
        match self {
            Self::IngestToPublish => "ingest_to_publish",
            Self::PublishToTaken => "publish_to_taken",
            Self::TakenToFused => "taken_to_fused",
            Self::FusedToReceived => "fused_to_received",
            Self::EndToEnd => "end_to_end",
            Self::Age => "age",
        }
    }

    /// Returns the name in tables.
    pub fn label(self) -> &'static str {
        match self {
            Self::IngestToPublish => "adapter",
            Self::PublishToTaken => "transport in",
            Self::TakenToFused => "fusion",
            Self::FusedToReceived => "transport out",
            Self::EndToEnd => "end to end",
            Self::Age => "age of data",
        }
    }

    /// Whether this stage lies before the `end` of the journey.
    pub fn is_measured(self, end: JourneyEnd) -> bool {
        end == JourneyEnd::Received || self != Self::FusedToReceived
    }

    /// Returns the stamps at which this stage of `track` began and ended, nanoseconds of one clock; 0 for a missing
    /// stamp. `ended` is the end of the journey.
    pub(crate) fn stamps(self, track: &SystemTrack, ended: Ended) -> (i64, i64) {
        let stages = &track.stages;
        match self {
            Self::IngestToPublish => (stages.ingested_ns, stages.published_ns),
            Self::PublishToTaken => (stages.published_ns, stages.taken_ns),
            Self::TakenToFused => (stages.taken_ns, stages.fused_ns),
            Self::FusedToReceived => (stages.fused_ns, ended.mono_ns),
            Self::EndToEnd => (stages.ingested_ns, ended.mono_ns),
            Self::Age => (track.time_of_measurement_ns, ended.utc_ns),
        }
    }

    /// Returns for how much of this stage the report of `track` waited before it could be answered, nanoseconds.
    pub(crate) fn held_ns(self, track: &SystemTrack) -> u64 {
        match self {
            Self::TakenToFused | Self::EndToEnd | Self::Age => u64::from(track.held_us) * 1000,
            Self::IngestToPublish | Self::PublishToTaken | Self::FusedToReceived => 0,
        }
    }
}

/// End of a state's journey on both clocks, nanoseconds; 0 if unknown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ended {
    mono_ns: i64,
    utc_ns: i64,
}

impl JourneyEnd {
    /// Returns the end of the journey of `track`, received at `received_ns` and, in UTC, `received_utc_ns`.
    pub(crate) fn of(self, track: &SystemTrack, received_ns: i64, received_utc_ns: i64) -> Ended {
        let fused_ns = track.stages.fused_ns;
        match self {
            Self::Received => Ended {
                mono_ns: received_ns,
                utc_ns: received_utc_ns,
            },
            Self::Published if fused_ns <= 0 => Ended { mono_ns: 0, utc_ns: 0 },
            Self::Published => Ended {
                mono_ns: fused_ns,
                utc_ns: received_utc_ns - (received_ns - fused_ns),
            },
        }
    }
}
