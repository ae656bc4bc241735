//! The stages of a report's journey.

use messages::SystemTrack;

/// A part of the way from measurement to subscriber.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// In the adapter: from the report's last byte to its hand-over to shared memory.
    IngestToPublish,
    /// Transport in: until fusion took it.
    PublishToTaken,
    /// In fusion: until the system track was handed over to shared memory.
    TakenToFused,
    /// Transport out: until the subscriber had it.
    FusedToReceived,
    /// All of these: from the report's last byte to the subscriber.
    EndToEnd,
    /// Age of the data: from the measurement to the subscriber, between the sensor's clock and this machine's (UTC).
    Age,
}

/// Event that ends the journey of a state, for whoever measures it.
///
/// A subscriber that is woken for every slice measures the whole journey. One that looks only now and then, to spare
/// the publisher the waking, would measure its own pauses: for it, the journey ends where fusion has published the
/// state, and the last stage is not measured at all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JourneyEnd {
    /// The subscriber has received the state.
    #[default]
    Received,
    /// Fusion has handed the state over to shared memory.
    Published,
}

impl Stage {
    /// Every stage, in the order of the journey.
    pub const ALL: [Self; 6] = [
        Self::IngestToPublish,
        Self::PublishToTaken,
        Self::TakenToFused,
        Self::FusedToReceived,
        Self::EndToEnd,
        Self::Age,
    ];

    /// Name in logs, JSON and metrics.
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

    /// Name in tables.
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

    /// The stamps at which this stage of `track` began and ended, nanoseconds of one clock; 0 where there is none.
    /// `ended` is the end of the journey.
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
}

/// End of a state's journey on both clocks, nanoseconds; 0 if that is not known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ended {
    mono_ns: i64,
    utc_ns: i64,
}

impl JourneyEnd {
    /// End of the journey of `track`, which was received at `received_ns` and, by UTC, `received_utc_ns`.
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
