//! Spectrum of an antenna array: the power by direction behind its bearings.

use crate::StageTimes;
use crate::layout::sample;

/// Number of directions of a spectrum: one for each degree.
pub const SPECTRUM_DIRECTIONS: usize = 360;

sample! {
    /// Spectrum of one measurement of an antenna array (EL-1), published while the topic has subscribers.
    SensorSpectrum, size 1536 {
        /// Time of measurement, UTC, nanoseconds since 1970.
        time_of_measurement_ns: i64,
        /// The spectrum's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Direction of the forward axis, radians clockwise from north; from the bow if the snapshots state no heading.
        forward_rad: f64,
        /// Frequency of the measurement, hertz.
        frequency_hz: f64,
        /// Variance of the noise at one antenna, in squares of the samples' unit.
        noise_variance: f64,
        /// Number of snapshots of the measurement.
        snapshots: u32,
        /// Number of transmitters, as given or estimated.
        transmitters: u32,
        /// Source: its number in the configuration (TI-2).
        source: u16,
        /// Reserved, 0.
        reserved: [u16; 7],
        /// From k to k + 1 degrees clockwise from the forward axis, decibels: 0 where no wave comes from.
        spectrum_db: [f32; 360] = [0.0; SPECTRUM_DIRECTIONS],
    }
}
