//! Arrival times of transmissions at receivers, and ready-made fixes of emitters (FM-7, FM-11).
//!
//! A receiver with a clock states when a transmission arrived (`toa`), or two receivers by how much later it arrived at
//! one of them (`tdoa`). The time of transmission is unknown, so only differences locate. A transmission from a known
//! place, of a reference emitter, shows the receivers' clocks instead. Positions are metres east, north and up in the
//! system frame.

use std::fmt;

use crate::Bearing;

/// Longest name of a receiver, bytes.
const NAME_OCTETS_MAX: usize = 16;

/// Name of a receiver: 1 to 16 visible ASCII characters.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ReceiverName([u8; NAME_OCTETS_MAX]);

impl ReceiverName {
    /// The name of this text; `None` if the text is none.
    pub fn new(text: &str) -> Option<Self> {
        let is_name = (1..=NAME_OCTETS_MAX).contains(&text.len()) && text.bytes().all(|octet| octet.is_ascii_graphic());
        is_name.then(|| {
            let mut octets = [0; NAME_OCTETS_MAX];
            octets[..text.len()].copy_from_slice(text.as_bytes());
            Self(octets)
        })
    }
}

impl fmt::Display for ReceiverName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0.iter().take_while(|octet| **octet != 0);
        text.map(|octet| char::from(*octet))
            .try_for_each(|letter| write!(f, "{letter}"))
    }
}

impl fmt::Debug for ReceiverName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// A receiver and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Name; a receiver has one clock.
    pub name: ReceiverName,
    /// Position, metres east, north and up.
    pub position_m: [f64; 3],
}

/// Measured times of a transmission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArrivalTime {
    /// Arrival at one receiver, by its clock (`toa`).
    At {
        /// The receiver.
        receiver: Receiver,
        /// Time of arrival, seconds since midnight (UTC).
        t_s: f64,
    },
    /// Arrival at the first receiver minus arrival at the second (`tdoa`).
    Between {
        /// The receivers.
        receivers: [Receiver; 2],
        /// Difference, seconds.
        tdoa_s: f64,
    },
}

/// Arrival of a transmission at one receiver, or its difference between two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Time of the transmission, UTC, nanoseconds since 1970; to the millisecond is enough.
    pub time_of_measurement_ns: i64,
    /// Number of the emitter.
    pub emitter_id: u32,
    /// Measured time or difference.
    pub time: ArrivalTime,
    /// Standard deviation of the time or difference, seconds, above 0.
    pub sigma_s: f64,
    /// Position of the emitter, if it is a reference emitter.
    pub reference_m: Option<[f64; 3]>,
}

/// Position of an emitter, found by others (EL-12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadyFix {
    /// Time of the fix, UTC, nanoseconds since 1970.
    pub time_of_measurement_ns: i64,
    /// Number of the emitter.
    pub emitter_id: u32,
    /// Position, metres east, north and up.
    pub position_m: [f64; 3],
    /// Covariance in the plane: east, east with north, north, m².
    pub covariance_m2: [f64; 3],
}

/// Any measurement of an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmitterMeasurement {
    /// Direction from a platform.
    Bearing(Bearing),
    /// Arrival time, or a difference of two.
    Arrival(Arrival),
    /// Ready-made fix.
    Fix(ReadyFix),
}

impl EmitterMeasurement {
    /// Time of the measurement, UTC, nanoseconds.
    pub fn time_ns(&self) -> i64 {
        match self {
            Self::Bearing(bearing) => bearing.time_of_measurement_ns,
            Self::Arrival(arrival) => arrival.time_of_measurement_ns,
            Self::Fix(fix) => fix.time_of_measurement_ns,
        }
    }

    /// Changes the time of the measurement.
    #[must_use]
    pub fn at_ns(mut self, time_ns: i64) -> Self {
        match &mut self {
            Self::Bearing(bearing) => bearing.time_of_measurement_ns = time_ns,
            Self::Arrival(arrival) => arrival.time_of_measurement_ns = time_ns,
            Self::Fix(fix) => fix.time_of_measurement_ns = time_ns,
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_and_visible() {
        for text in ["1", "north-east", "0123456789abcdef"] {
            assert_eq!(ReceiverName::new(text).unwrap().to_string(), text);
        }
        for text in ["", "0123456789abcdefg", "a b", "\u{e4}"] {
            assert_eq!(ReceiverName::new(text), None, "{text}");
        }
    }
}
