//! Samples of fixed layout in shared memory, and the topics that carry them (PL-2, PL-8).
//!
//! Processes built separately, perhaps in other languages, read the same bytes. Every sample is therefore
//! `#[repr(C)]`, holds no pointer, declares all padding, and has a size asserted at compile time. The [`layout`]
//! module has every field's offset. The module generates the C header and the Python module in `layout/`; a test
//! fails if these files are outdated.
//!
//! A topic carries *slices* of one sample type: a scan is one send. A [`BatchHeader`] precedes each slice. There,
//! the publisher states the number of samples sent before (the basis of subscribers' loss counts), the layout of
//! the publisher's build, and the source's progress in time.
//!
//! Architecture invariant: this crate performs no I/O and does not depend on the implementation of shared memory.
//! The marker trait for types fit for shared memory comes from iceoryx2's small trait crate.

#![forbid(unsafe_op_in_unsafe_fn)]

pub mod admission;
mod alarm;
mod alert;
mod atmosphere;
mod batch;
mod codes;
mod conversion;
mod counters;
mod covariance;
mod decision;
mod designated_place;
mod extent;
mod frame_origin;
mod health;
mod identity;
mod identity_text;
pub mod layout;
mod level;
mod movement;
mod order;
mod order_check;
mod order_kind;
mod order_text;
pub mod picture;
mod platform_state;
mod process_kind;
mod progress;
mod registration;
mod restored;
mod sensor_arrival;
mod sensor_bearing;
mod sensor_detection;
mod sensor_fix;
mod sensor_spectrum;
mod sensor_track;
mod sensor_uid;
mod stages;
mod statement;
mod system_track;
mod target_type;
mod topics;
mod unknown;
mod wide_area;
mod work_step;

pub use alarm::{ALARM_TEXT_MAX, Alarm, AlarmEvent, AlarmSeverity};
pub use alert::{ALERT_TEXT_MAX, Alert, AlertKind, alert_value_bits};
pub use atmosphere::{STANDARD_PRESSURE_HPA, pressure_correction_m};
pub use batch::{BatchHeader, Epochs};
pub use codes::Constant;
pub use conversion::Conversion;
pub use counters::{COUNTERS_MAX, Counter, CounterClass, Counters};
pub use covariance::{AXES, COVARIANCE_LEN, Covariance, STATE_LEN};
pub use decision::{Decision, DecisionKind};
pub use designated_place::{DesignatedCourse, DesignatedPlace};
pub use extent::Extent;
pub use frame_origin::FrameOrigin;
pub use health::{Health, HealthName, LifeState, NO_SOURCE, REFUSAL_MAX, printable};
pub use identity::{
    CONSPICUITY_CODES, Callsign, Identity, IdentityAges, IdentityKind, NAME_MAX, UniqueNumber, identity_bits,
};
pub use identity_text::{IdentityText, Spelled};
pub use level::{LEVEL_STEP_M, altitude_m, level_of};
pub use movement::{HorizontalMovement, LongitudinalMovement, Movement, VerticalMovement, movement_bits};
pub use order::{NO_TRACK, ORDER_TEXT_MAX, ORDER_WORDS, Order, OrderState, OrderStatus, Refusal};
pub use order_check::check as check_order;
pub use order_kind::{OrderKind, Parameter};
pub use platform_state::{PlatformState, platform_state_bits};
pub use process_kind::ProcessKind;
pub use progress::Progress;
pub use registration::{Bias, BiasKind, ErrorModel, Registration, registration_bits};
pub use restored::{RESTORED_WORDS, Restored};
pub use sensor_arrival::{SensorArrival, sensor_arrival_bits};
pub use sensor_bearing::{SensorBearing, sensor_bearing_bits};
pub use sensor_detection::{DetectionKind, DetectionMark, Quantity, SensorDetection, sensor_detection_bits};
pub use sensor_fix::SensorFix;
pub use sensor_spectrum::{SPECTRUM_DIRECTIONS, SensorSpectrum};
pub use sensor_track::{SensorTrack, alert_bits, sensor_track_bits};
pub use sensor_uid::sensor_uid;
pub use stages::StageTimes;
pub use statement::{AidKind, Emergency, NavigationStatus, TargetCategory, TargetStatement, target_statement_bits};
pub use system_track::{CONTRIBUTIONS_MAX, Contribution, MotionMode, SystemTrack, contribution_bits};
pub use target_type::{TYPE_NAME_MAX, TargetType};
pub use topics::{
    Outgoing, Stream, StreamId, Streamed, Topic, TopicCapacity, TopicName, Visitor, alarms, alerts, cues, decisions,
    event_log, frame_origin, health, order_states, orders, own_tracks, platform_states, progress, restored,
    sensor_arrivals, sensor_bearings, sensor_detections, sensor_fixes, sensor_spectrum, sensor_tracks, smoothed_tracks,
    system_tracks, target_statements, visit, wide_area,
};
pub use unknown::{UNKNOWN_CLIMB_SIGMA_MPS, UNKNOWN_HEIGHT_SIGMA_M, UNKNOWN_VELOCITY_SIGMA_MPS};
pub use wide_area::{Cue, WideArea, wide_area_bits};
pub use work_step::{StepKind, WorkStep, work_step_bits};

/// Version of the meaning of the samples' fields. It is part of every sample's fingerprint, which every slice
/// carries and every subscriber checks. A changed layout changes the fingerprint of that type automatically.
pub const SCHEMA_VERSION: u32 = 6;

/// Number of nanoseconds in a second.
pub const NS_PER_S: f64 = 1e9;

codes! {
    /// State in the life of a track.
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub enum TrackState: u8, default Tentative {
        /// Seen, not yet believed.
        Tentative = 0, "tentative";
        /// Believed, and supported by recent reports.
        Confirmed = 1, "confirmed";
        /// Believed, but carried on by extrapolation for want of reports.
        Coasted = 2, "coasted";
        /// Ended; the number is not used again soon.
        Terminated = 3, "terminated";
        /// No longer reported by any source: not shown, while the number rests and may resume.
        Suspended = 4, "suspended";
    }
}

impl TrackState {
    /// Whether the state with this code takes a track off the picture: the track is suspended, or has ended.
    pub const fn is_off(code: u8) -> bool {
        code == Self::Suspended as u8 || code == Self::Terminated as u8
    }
}

codes! {
    /// Kind of object followed by a track.
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub enum TrackKind: u8, default Single {
        /// One target.
        Single = 0, "single";
        /// Several unresolved targets (WA-7).
        Group = 1, "group";
    }
}

codes! {
    /// Rule for the weights of a system track's contributions.
    pub enum FusionRule: u8 {
        /// Filter of the target, with learned accuracies of the sources.
        Auto = 1, "auto";
        /// Filter of the target's own.
        SystemFilter = 2, "system-filter";
        /// Source with the smallest accuracy value.
        BestSource = 3, "best-source";
        /// Weights inverse to the covariance traces.
        InverseTrace = 4, "inverse-trace";
        /// Weights by quality index.
        QualityFactor = 5, "quality-factor";
        /// Source that the cell of a mosaic names.
        Mosaic = 6, "mosaic";
        /// Information sum of independent errors.
        Information = 7, "information";
        /// Covariance intersection: bound for unknown correlations.
        CovarianceIntersection = 8, "covariance-intersection";
        /// Bar-Shalom and Campo's combination of correlated errors.
        BarShalomCampo = 9, "bar-shalom-campo";
    }
}
