//! One bearing of an emitter, as seen from a moving platform at one time (FM-7).
//!
//! A direction finder says in which direction something transmits, and not how far away it is. What can be made of many of
//! them depends on where the platform was at each, so a bearing carries that. Positions are in the system frame, east, north
//! and up; a bearing is clockwise from north in the horizontal plane, whatever the platform's heading.

/// One bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bearing {
    /// When it was measured, UTC, nanoseconds since 1970.
    pub time_of_measurement_ns: i64,
    /// Whose it is, where the direction finder can tell; otherwise it has to be found by frequency and direction.
    pub emitter_id: Option<u32>,
    /// Direction, radians clockwise from north.
    pub bearing_rad: f64,
    /// Its standard deviation, radians.
    pub sigma_rad: f64,
    /// Where the platform was, metres east, north and up.
    pub platform_m: [f64; 3],
    /// Where the platform was heading, radians clockwise from north, where that is known: it tells turns.
    pub heading_rad: Option<f64>,
    /// Frequency of the emission, hertz, where it was measured.
    pub frequency_hz: Option<f64>,
    /// Time between its pulses, seconds, where it was measured.
    pub pulse_interval_s: Option<f64>,
}
