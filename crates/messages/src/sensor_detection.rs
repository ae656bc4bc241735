//! Detections of a sensor, before tracking.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::codes::bits;
use crate::layout::sample;
use crate::{Identity, IdentityAges, StageTimes, codes};

bits! {
    /// Bits of [`SensorDetection::valid`].
    sensor_detection_bits: u8 {
        /// `range_rate_mps` was measured.
        RANGE_RATE = 1;
        /// `sigmas` hold standard deviations.
        SIGMAS = 1 << 1;
        /// `level` holds the level of the target's transponder.
        LEVEL = 1 << 2;
        /// `platform_velocity_mps` is known.
        PLATFORM_VELOCITY = 1 << 3;
        /// `platform_attitude_rad` and `attitude_sigmas_rad` are known.
        PLATFORM_ATTITUDE = 1 << 4;
        /// `platform_sigma_m` is known.
        PLATFORM_SIGMA = 1 << 5;
        /// The sample is no detection but a mark of the sensor's time: `kind` holds a `DetectionMark` code.
        MARK = 1 << 6;
        /// Of a designation: `platform_velocity_mps` is the velocity of the target east and north, and the last of
        /// `sigmas` its standard deviation. Not together with `RANGE_RATE`.
        TARGET_VELOCITY = 1 << 7;
    }
}

sample! {
    /// One detection of one sensor (FM-6): a measurement without an assigned track.
    SensorDetection, size 248 {
        /// Time of measurement, UTC, nanoseconds since 1970.
        time_of_measurement_ns: i64,
        /// The detection's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// The sensor's scan, turn or frame; it rises with time.
        scan: u32,
        /// Number of the detection, unique within its scan.
        detection_id: u32,
        /// Measured values in the order of the kind: metres, radians; 0 beyond.
        values: [f64; 3],
        /// Speed away from the sensor, metres per second.
        range_rate_mps: f64,
        /// Standard deviations of the values and, last, of the range rate.
        sigmas: [f64; 4],
        /// Where the sensor was, metres east, north and up.
        platform_m: [f64; 3],
        /// Source: its number in the configuration (TI-2).
        source: u16,
        /// Quantities that were measured: a `DetectionKind` code.
        kind: u8,
        /// Which fields hold something: see `sensor_detection_bits`.
        valid: u8,
        /// Age of `level` at the time of measurement, milliseconds.
        level_age_ms: u32,
        /// Identity of the target in the detection, as far as it is known.
        identity: Identity,
        /// Ages of the values of `identity` at the time of measurement.
        identity_ages: IdentityAges,
        /// Level of the transponder, in steps of 25 feet at 1013.25 hPa; 0 without the bit `LEVEL`.
        level: i16,
        /// Reserved, 0.
        reserved: u16,
        /// Velocity of the sensor's platform east, north, up, metres per second.
        platform_velocity_mps: [f32; 3],
        /// Heading (clockwise from north), pitch (nose up) and roll (right wing down) of the platform, radians.
        platform_attitude_rad: [f32; 3],
        /// Standard deviation of each coordinate of `platform_m`, metres.
        platform_sigma_m: f32,
        /// Standard deviations of heading, pitch and roll, radians.
        attitude_sigmas_rad: [f32; 3],
    }
}

codes! {
    /// Kind of a detection: the quantities that were measured.
    pub enum DetectionKind: u8 {
        /// East and north in the system frame.
        Position2 = 0, "position2";
        /// East, north and up in the system frame.
        Position3 = 1, "position3";
        /// Slant range and bearing from the sensor.
        RangeBearing = 2, "range_bearing";
        /// Slant range, bearing and elevation from the sensor.
        RangeBearingElevation = 3, "range_bearing_elevation";
        /// Bearing from the sensor.
        Bearing = 4, "bearing";
        /// Bearing and elevation from the sensor.
        BearingElevation = 5, "bearing_elevation";
    }
}

codes! {
    /// Mark of a sensor's time among its detections: what `kind` means in a sample with the bit `MARK`.
    pub enum DetectionMark: u8 {
        /// The sensor's time has come to the time of measurement.
        Passed = 0, "passed";
        /// The scan `scan` at the time of measurement has no detections.
        EmptyScan = 1, "empty_scan";
        /// A turn of the sensor begins at the time of measurement.
        TurnBegins = 2, "turn_begins";
        /// A detection at the time of measurement was refused: no state of the sensor's platform belongs to its time.
        Unplaced = 3, "unplaced";
    }
}

/// Measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Metres east.
    East,
    /// Metres north.
    North,
    /// Metres up.
    Up,
    /// Distance from the sensor, metres.
    Range,
    /// Direction in the plane, radians clockwise from north.
    Bearing,
    /// Direction above the horizontal, radians.
    Elevation,
}

impl DetectionKind {
    /// Returns the quantities, in the order of the values.
    pub fn quantities(self) -> &'static [Quantity] {
        use Quantity::{Bearing, East, Elevation, North, Range, Up};
        match self {
            Self::Position2 => &[East, North],
            Self::Position3 => &[East, North, Up],
            Self::RangeBearing => &[Range, Bearing],
            Self::RangeBearingElevation => &[Range, Bearing, Elevation],
            Self::Bearing => &[Bearing],
            Self::BearingElevation => &[Bearing, Elevation],
        }
    }
}

impl Quantity {
    /// Returns the fault of a finite value of this quantity, with a remedy; `None` for a valid value.
    pub fn fault(self, value: f64) -> Option<&'static str> {
        match self {
            Self::East | Self::North | Self::Up => None,
            Self::Range => (value < 0.0).then_some("is negative, which no range is"),
            Self::Bearing => (value.abs() > TAU).then_some("is more than a full turn; write radians, not degrees"),
            Self::Elevation => {
                (value.abs() > FRAC_PI_2).then_some("is beyond the vertical; write radians, not degrees")
            }
        }
    }
}
