//! Target counts of a remote sensor, and cues for sensors on board.

use crate::StageTimes;
use crate::codes::bits;
use crate::layout::sample;

bits! {
    /// Bits of [`WideArea::valid`].
    wide_area_bits: u16 {
        /// `origin_m` is known.
        ORIGIN = 1;
    }
}

sample! {
    /// Number of targets around a place (WA-2): a count, no detection.
    WideArea, size 128 {
        /// Time of observation, UTC, nanoseconds since 1970.
        time_of_observation_ns: i64,
        /// Time of arrival, UTC, nanoseconds since 1970; it is used from then on.
        arrival_ns: i64,
        /// The report's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Middle of the targets at the time of observation, metres east, north and up.
        position_m: [f64; 3],
        /// Mean velocity of the targets east, north, up, metres per second.
        velocity_mps: [f64; 3],
        /// Where they came from, metres east and north.
        origin_m: [f64; 2],
        /// Number of targets, possibly 0.
        targets: u32,
        /// The wide-area sensor: its number in the configuration.
        sensor: u16,
        /// Which fields hold something: see `wide_area_bits`.
        valid: u16,
    }
}

sample! {
    /// Position and time for a sensor's look at one track (WA-12): an ellipse around the predicted position.
    Cue, size 136 {
        /// Time of the look, UTC, nanoseconds since 1970.
        time_ns: i64,
        /// Time of the scan after which it was made, UTC, nanoseconds since 1970.
        made_ns: i64,
        /// The cue's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Predicted position east, north, up, metres.
        position_m: [f64; 3],
        /// Predicted velocity east, north, up, metres per second.
        velocity_mps: [f64; 3],
        /// Longer and shorter half axis of the region to be searched, metres.
        half_axes_m: [f64; 2],
        /// Direction of the longer one, radians clockwise from north, in [0, pi).
        orientation_rad: f64,
        /// Number of the sensor track at its source.
        track_number: u32,
        /// The source that is to look: its number in the configuration (TI-2).
        source: u16,
        /// Reserved, 0.
        reserved: u16,
    }
}
