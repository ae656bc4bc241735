//! Bearing of an emitter, measured from a moving platform at one time (FM-7).
//!
//! A direction finder reports the direction of a transmission, not its distance. The evaluation of many bearings
//! depends on the platform's position at each, so a bearing contains that position. Positions are in the system
//! frame, east, north and up; a bearing is clockwise from north in the horizontal plane, whatever the platform's
//! heading.

use messages::{PlatformState, SensorBearing, StageTimes, platform_state_bits, sensor_bearing_bits as bits};

use crate::{Sampled, flag};

/// Bearing of an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bearing {
    /// Time of measurement, UTC, nanoseconds since 1970.
    pub time_of_measurement_ns: i64,
    /// Number of the emitter, if the direction finder identifies it; `None`: association by frequency and direction.
    pub emitter_id: Option<u32>,
    /// Direction, radians clockwise from north.
    pub bearing_rad: f64,
    /// Standard deviation of the bearing, radians, above 0.
    pub sigma_rad: f64,
    /// Position of the platform, metres east, north and up in the system frame.
    pub platform_m: [f64; 3],
    /// Heading of the platform, radians clockwise from north, if known: used to detect turns.
    pub heading_rad: Option<f64>,
    /// Frequency of the emission, hertz, if measured.
    pub frequency_hz: Option<f64>,
    /// Time between its pulses, seconds, if measured.
    pub pulse_interval_s: Option<f64>,
}

impl Bearing {
    /// The state of the platform at this bearing, as a sample of source number `source`.
    pub fn platform(&self, source: u16, stages: StageTimes) -> PlatformState {
        PlatformState {
            time_ns: self.time_of_measurement_ns,
            stages,
            position_m: self.platform_m,
            heading_rad: self.heading_rad.unwrap_or_default(),
            source,
            valid: flag(self.heading_rad.is_some(), platform_state_bits::HEADING),
            ..PlatformState::default()
        }
    }
}

impl Sampled for Bearing {
    type Sample = SensorBearing;

    fn sample(&self, source: u16, stages: StageTimes) -> SensorBearing {
        SensorBearing {
            time_of_measurement_ns: self.time_of_measurement_ns,
            stages,
            bearing_rad: self.bearing_rad,
            sigma_rad: self.sigma_rad,
            platform_m: self.platform_m,
            heading_rad: self.heading_rad.unwrap_or_default(),
            frequency_hz: self.frequency_hz.unwrap_or_default(),
            pulse_interval_s: self.pulse_interval_s.unwrap_or_default(),
            emitter_id: self.emitter_id.unwrap_or_default(),
            source,
            valid: flag(self.emitter_id.is_some(), bits::EMITTER)
                | flag(self.heading_rad.is_some(), bits::HEADING)
                | flag(self.frequency_hz.is_some(), bits::FREQUENCY)
                | flag(self.pulse_interval_s.is_some(), bits::PULSE_INTERVAL),
            ..SensorBearing::default()
        }
    }

    fn of_sample(sample: &SensorBearing) -> Option<Self> {
        let stated = |bit: u16| sample.valid & bit != 0;
        Some(Self {
            time_of_measurement_ns: sample.time_of_measurement_ns,
            emitter_id: stated(bits::EMITTER).then_some(sample.emitter_id),
            bearing_rad: sample.bearing_rad,
            sigma_rad: sample.sigma_rad,
            platform_m: sample.platform_m,
            heading_rad: stated(bits::HEADING).then_some(sample.heading_rad),
            frequency_hz: stated(bits::FREQUENCY).then_some(sample.frequency_hz),
            pulse_interval_s: stated(bits::PULSE_INTERVAL).then_some(sample.pulse_interval_s),
        })
    }
}
