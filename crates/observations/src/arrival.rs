//! Arrival times of transmissions at receivers, and ready-made fixes of emitters (FM-7, FM-11).
//!
//! A receiver with a clock states when a transmission arrived (`toa`), or two receivers by how much later it arrived at
//! one of them (`tdoa`). The time of transmission is unknown, so only differences locate. A transmission from a known
//! place, of a reference emitter, shows the receivers' clocks instead. Positions are metres east, north and up in the
//! system frame.

use std::fmt;

use messages::{SensorArrival, SensorFix, StageTimes, sensor_arrival_bits as bits};

use crate::{Bearing, Sampled, flag};

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

    /// The name as ASCII, unused bytes 0.
    fn octets(self) -> [u8; NAME_OCTETS_MAX] {
        self.0
    }

    /// The name of such octets; `None` if they are none.
    fn of_octets(octets: &[u8; NAME_OCTETS_MAX]) -> Option<Self> {
        let text = octets.split(|octet| *octet == 0).next()?;
        Self::new(std::str::from_utf8(text).ok()?)
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

impl Sampled for Arrival {
    type Sample = SensorArrival;

    fn sample(&self, source: u16, stages: StageTimes) -> SensorArrival {
        let (time_s, first, second) = match self.time {
            ArrivalTime::At { receiver, t_s } => (t_s, receiver, None),
            ArrivalTime::Between {
                receivers: [first, second],
                tdoa_s,
            } => (tdoa_s, first, Some(second)),
        };
        SensorArrival {
            time_of_measurement_ns: self.time_of_measurement_ns,
            stages,
            time_s,
            sigma_s: self.sigma_s,
            receiver_m: first.position_m,
            receiver_2_m: second.map_or([0.0; 3], |second| second.position_m),
            reference_m: self.reference_m.unwrap_or_default(),
            receiver: first.name.octets(),
            receiver_2: second.map_or([0; NAME_OCTETS_MAX], |second| second.name.octets()),
            emitter_id: self.emitter_id,
            source,
            valid: flag(second.is_some(), bits::DIFFERENCE) | flag(self.reference_m.is_some(), bits::REFERENCE),
            ..SensorArrival::default()
        }
    }

    fn of_sample(sample: &SensorArrival) -> Option<Self> {
        let stated = |bit: u16| sample.valid & bit != 0;
        let receiver = |octets, position_m| {
            let name = ReceiverName::of_octets(octets)?;
            Some(Receiver { name, position_m })
        };
        let first = receiver(&sample.receiver, sample.receiver_m)?;
        let time = match stated(bits::DIFFERENCE) {
            true => ArrivalTime::Between {
                receivers: [first, receiver(&sample.receiver_2, sample.receiver_2_m)?],
                tdoa_s: sample.time_s,
            },
            false => ArrivalTime::At {
                receiver: first,
                t_s: sample.time_s,
            },
        };
        Some(Self {
            time_of_measurement_ns: sample.time_of_measurement_ns,
            emitter_id: sample.emitter_id,
            time,
            sigma_s: sample.sigma_s,
            reference_m: stated(bits::REFERENCE).then_some(sample.reference_m),
        })
    }
}

impl Sampled for ReadyFix {
    type Sample = SensorFix;

    fn sample(&self, source: u16, stages: StageTimes) -> SensorFix {
        SensorFix {
            time_of_measurement_ns: self.time_of_measurement_ns,
            stages,
            position_m: self.position_m,
            covariance_m2: self.covariance_m2,
            emitter_id: self.emitter_id,
            source,
            ..SensorFix::default()
        }
    }

    fn of_sample(sample: &SensorFix) -> Option<Self> {
        Some(Self {
            time_of_measurement_ns: sample.time_of_measurement_ns,
            emitter_id: sample.emitter_id,
            position_m: sample.position_m,
            covariance_m2: sample.covariance_m2,
        })
    }
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

    #[test]
    fn samples_hold_arrivals_and_fixes_to_the_last_bit() {
        let receiver = |name, east_m| Receiver {
            name: ReceiverName::new(name).unwrap(),
            position_m: [east_m, 2.0 / 7.0, -3.0],
        };
        let single = Arrival {
            time_of_measurement_ns: 5,
            emitter_id: 7,
            time: ArrivalTime::At {
                receiver: receiver("0123456789abcdef", 1.0 / 3.0),
                t_s: 43_200.000_000_1,
            },
            sigma_s: 1e-8,
            reference_m: Some([1.0, 2.0, 3.0]),
        };
        let difference = Arrival {
            time: ArrivalTime::Between {
                receivers: [receiver("a", 4.0), receiver("b", 5.0)],
                tdoa_s: -1.0 / 7.0,
            },
            reference_m: None,
            ..single
        };
        for arrival in [single, difference] {
            let sample = arrival.sample(3, StageTimes::default());
            assert_eq!((sample.source, Arrival::of_sample(&sample)), (3, Some(arrival)));
        }
        let nameless = SensorArrival {
            receiver_2: [0; NAME_OCTETS_MAX],
            ..difference.sample(3, StageTimes::default())
        };
        assert_eq!(Arrival::of_sample(&nameless), None);
        let fix = ReadyFix {
            time_of_measurement_ns: 6,
            emitter_id: 8,
            position_m: [1.0 / 3.0, -2.0, 0.1],
            covariance_m2: [4.0, 1.0, 9.0],
        };
        let sample = fix.sample(4, StageTimes::default());
        assert_eq!((sample.source, ReadyFix::of_sample(&sample)), (4, Some(fix)));
    }
}
