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

    /// The stamps at which this stage of `track` began and ended, nanoseconds of one clock; 0 where there is none.
    pub(crate) fn stamps(self, track: &SystemTrack, received_ns: i64, received_utc_ns: i64) -> (i64, i64) {
        let stages = &track.stages;
        match self {
            Self::IngestToPublish => (stages.ingested_ns, stages.published_ns),
            Self::PublishToTaken => (stages.published_ns, stages.taken_ns),
            Self::TakenToFused => (stages.taken_ns, stages.fused_ns),
            Self::FusedToReceived => (stages.fused_ns, received_ns),
            Self::EndToEnd => (stages.ingested_ns, received_ns),
            Self::Age => (track.time_of_measurement_ns, received_utc_ns),
        }
    }
}
