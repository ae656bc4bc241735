//! What travels in shared memory: fixed-layout samples, and the topics that carry them (PL-2, PL-8).
//!
//! Processes that were built apart, perhaps in other languages, read the same bytes. So every sample is
//! `#[repr(C)]`, holds no pointer, spells out its padding, and has its size asserted at compile time. The
//! [`layout`] module knows every field's offset; the C header and the Python module in `layout/` are written from
//! it, and a test fails when they are not what it would write.
//!
//! A topic carries *slices* of one sample type: a scan is one send. Each slice is preceded by a [`BatchHeader`],
//! in which the publisher says how many samples it has sent before (loss is counted from that, not guessed), which
//! layout it was built with, and how far in time its source has got.
//!
//! Architecture invariant: nothing here performs I/O or knows how shared memory works; the marker trait that
//! declares a type fit for it comes from iceoryx2's small trait crate.

#![forbid(unsafe_op_in_unsafe_fn)]

mod batch;
mod control;
mod counters;
mod covariance;
mod health;
mod identity;
pub mod layout;
mod platform_state;
mod registration;
mod sensor_bearing;
mod sensor_detection;
mod sensor_track;
mod stages;
mod system_track;
mod target_type;
mod topics;
mod wide_area;

pub use batch::BatchHeader;
pub use control::{Control, Progress};
pub use counters::{COUNTERS_MAX, Counter, CounterClass, Counters};
pub use covariance::{AXES, COVARIANCE_LEN, Covariance, STATE_LEN};
pub use health::{Health, HealthName, LifeState, NO_SOURCE, PROCESS_KINDS, ProcessKind};
pub use identity::{Callsign, Identity, identity_bits};
pub use platform_state::{PlatformState, platform_state_bits};
pub use registration::{Registration, registration_bits};
pub use sensor_bearing::{SensorBearing, sensor_bearing_bits};
pub use sensor_detection::{SensorDetection, sensor_detection_bits};
pub use sensor_track::{SensorTrack, alert_bits, sensor_track_bits};
pub use stages::StageTimes;
pub use system_track::{CONTRIBUTIONS_MAX, Contribution, SystemTrack, contribution_bits};
pub use target_type::{TYPE_NAME_MAX, TargetType};
pub use topics::{
    Capacity, Topic, TopicName, control, cues, detections_number, health, platform_states, progress, sensor_bearings,
    sensor_detections, sensor_tracks, system_tracks, wide_area, wide_area_number,
};
pub use wide_area::{Cue, WideArea, wide_area_bits};

/// Changes whenever any layout or the meaning of any field changes; carried by every batch and checked by every
/// subscriber.
pub const SCHEMA_VERSION: u32 = 5;

/// Number of nanoseconds in a second.
pub const NS_PER_S: f64 = 1e9;

/// The life of a track, as files and displays name it (see the vocabulary in ARCHITECTURE.md).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum TrackState {
    /// Seen, not yet believed.
    #[default]
    Tentative = 0,
    /// Believed, and supported by recent reports.
    Confirmed = 1,
    /// Believed, but carried on by extrapolation for want of reports.
    Coasted = 2,
    /// Ended; the number is not used again soon.
    Terminated = 3,
}

impl TrackState {
    /// Every state, in the order of its code.
    pub const ALL: [Self; 4] = [Self::Tentative, Self::Confirmed, Self::Coasted, Self::Terminated];

    /// The word that files use (FM-5).
    pub fn word(self) -> &'static str {
        match self {
            Self::Tentative => "tentative",
            Self::Confirmed => "confirmed",
            Self::Coasted => "coasted",
            Self::Terminated => "terminated",
        }
    }

    /// The state that a file's word names.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.word() == word)
    }

    /// The state that a message's code names; codes of a future schema yield `None`.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }
}

/// What a track follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum TrackKind {
    /// One target.
    #[default]
    Single = 0,
    /// Several targets that are not told apart (WA-7).
    Group = 1,
}

impl TrackKind {
    /// Every kind, in the order of its code.
    pub const ALL: [Self; 2] = [Self::Single, Self::Group];

    /// The word that files use.
    pub fn word(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Group => "group",
        }
    }

    /// The kind that a message's code names; codes of a future schema yield `None`.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }
}
