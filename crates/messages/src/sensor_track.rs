//! What an adapter reports.

use crate::layout::sample;
use crate::{Covariance, Identity, StageTimes, TargetType};

/// Bits of [`SensorTrack::valid`].
pub mod sensor_track_bits {
    /// Height (`position[2]`) was observed; without it z is 0 and its variance says nothing.
    pub const HEIGHT: u16 = 1;
    /// Horizontal velocity was delivered or derived.
    pub const VELOCITY: u16 = 1 << 1;
    /// Vertical velocity was delivered or derived.
    pub const VERTICAL_RATE: u16 = 1 << 2;
    /// The covariance is the source's own statement; without it, it comes from configured accuracies.
    pub const OWN_COVARIANCE: u16 = 1 << 3;
    /// `measured_m` holds the measurement from which the source updated its track.
    pub const MEASURED: u16 = 1 << 4;
    /// The source says that the target is on the ground.
    pub const ON_GROUND: u16 = 1 << 5;
    /// The velocity was derived by the adapter from successive positions.
    pub const DERIVED_VELOCITY: u16 = 1 << 6;
    /// `trace` holds the source's own covariance trace (TI-16).
    pub const TRACE: u16 = 1 << 7;

    pub(crate) const NAMES: &[(&str, u64)] = &[
        ("HEIGHT", HEIGHT as u64),
        ("VELOCITY", VELOCITY as u64),
        ("VERTICAL_RATE", VERTICAL_RATE as u64),
        ("OWN_COVARIANCE", OWN_COVARIANCE as u64),
        ("MEASURED", MEASURED as u64),
        ("ON_GROUND", ON_GROUND as u64),
        ("DERIVED_VELOCITY", DERIVED_VELOCITY as u64),
        ("TRACE", TRACE as u64),
    ];
}

/// Bits of [`SensorTrack::alerts`] and [`SystemTrack::alerts`](crate::SystemTrack::alerts).
pub mod alert_bits {
    /// Special position identification: the pilot has pressed the button.
    pub const SPECIAL_IDENTIFICATION: u8 = 1;
    /// An emergency, of whatever kind; Mode 3/A code 7700.
    pub const EMERGENCY: u8 = 1 << 1;
    /// Radio communication has failed; code 7600.
    pub const COMMUNICATION_FAILURE: u8 = 1 << 2;
    /// Unlawful interference; code 7500.
    pub const UNLAWFUL_INTERFERENCE: u8 = 1 << 3;
    /// Medical flight.
    pub const MEDICAL: u8 = 1 << 4;
    /// Minimum fuel.
    pub const MINIMUM_FUEL: u8 = 1 << 5;
    /// The Mode 3/A code was changed lately, or the transponder raises its alert for another reason.
    pub const TRANSPONDER_ALERT: u8 = 1 << 6;
    /// A collision avoidance system advises the crew to manoeuvre.
    pub const RESOLUTION_ADVISORY: u8 = 1 << 7;

    pub(crate) const NAMES: &[(&str, u64)] = &[
        ("SPECIAL_IDENTIFICATION", SPECIAL_IDENTIFICATION as u64),
        ("EMERGENCY", EMERGENCY as u64),
        ("COMMUNICATION_FAILURE", COMMUNICATION_FAILURE as u64),
        ("UNLAWFUL_INTERFERENCE", UNLAWFUL_INTERFERENCE as u64),
        ("MEDICAL", MEDICAL as u64),
        ("MINIMUM_FUEL", MINIMUM_FUEL as u64),
        ("TRANSPONDER_ALERT", TRANSPONDER_ALERT as u64),
        ("RESOLUTION_ADVISORY", RESOLUTION_ADVISORY as u64),
    ];
}

sample! {
    /// One report of one sensor track (TI-1): state in the system's East-North-Up frame at the time of measurement.
    #[derive(Default)]
    SensorTrack, size 344 {
        /// Time of measurement, UTC, nanoseconds since 1970.
        time_of_measurement_ns: i64,
        /// The report's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Number of the sensor track at its source.
        track_number: u32,
        /// Source: its number in the configuration (TI-2).
        source: u16,
        /// Which fields hold something: see `sensor_track_bits`.
        valid: u16,
        /// Who the target says it is.
        identity: Identity,
        /// Position east, north, up, metres.
        position_m: [f64; 3],
        /// Velocity east, north, up, metres per second.
        velocity_mps: [f64; 3],
        /// Covariance of position and velocity.
        covariance: Covariance,
        /// Measured position, before the source's own filter, metres.
        measured_m: [f64; 3],
        /// Trace of the source's position covariance over east and north, square metres.
        trace_m2: f64,
        /// State of the track at its source: a `TrackState` code.
        state: u8,
        /// Observation method at the source, as numbered by its format; 0 if it has one only.
        method: u8,
        /// What the target or its source wants noticed: see `alert_bits`.
        alerts: u8,
        /// What the track follows: a `TrackKind` code.
        kind: u8,
        /// Expected number of members of a group; 0 for a single target.
        members: u16,
        /// Reserved, 0.
        reserved: u16,
        /// What type of target it is.
        target_type: TargetType,
    }
}

impl SensorTrack {
    /// Whether all of `bits` (see [`sensor_track_bits`]) are set.
    pub fn has(&self, bits: u16) -> bool {
        self.valid & bits == bits
    }
}
