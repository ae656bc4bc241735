//! Reasons why something cannot be measured.

use thiserror::Error;

/// Fault of an array, a measurement or the settings; each message gives the remedy.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum MusicError {
    /// An array of fewer than two antennas.
    #[error("an array of {antennas} antennas measures no bearing: two at least are needed")]
    TooFewAntennas {
        /// Number given.
        antennas: usize,
    },
    /// A position that is no number, or absurdly far away.
    #[error("antenna {antenna} has no usable position: both coordinates have to be numbers below 1,000,000 metres")]
    Position {
        /// Number of the antenna, from 0.
        antenna: usize,
    },
    /// Two antennas in the same place.
    #[error("antennas {first} and {second} are at the same place: between them there is no phase to measure")]
    Coincident {
        /// Number of the first antenna, from 0.
        first: usize,
        /// Number of the other.
        second: usize,
    },
    /// A number of sources that cannot be separated.
    #[error("{sources} sources cannot be separated by {antennas} antennas: 1 to {} can", antennas - 1)]
    Sources {
        /// Number of sources asked for.
        sources: usize,
        /// Number of antennas.
        antennas: usize,
    },
    /// A standard deviation of the antennas' phases that cannot be used.
    #[error("phase_sigma_rad is {phase_sigma_rad}: it has to be a number from 0 on")]
    PhaseSigma {
        /// Value given, radians.
        phase_sigma_rad: f64,
    },
    /// A frequency that cannot be used.
    #[error("the frequency is {frequency_hz} Hz: it has to be above 0 and at most {frequency_max_hz} Hz")]
    Frequency {
        /// Value given, hertz.
        frequency_hz: f64,
        /// The highest, hertz.
        frequency_max_hz: f64,
    },
    /// An array too wide for the wavelength.
    #[error(
        "the array is {wavelengths:.0} wavelengths wide: at most {max} can be searched; are its positions in metres?"
    )]
    TooWide {
        /// Width at the highest frequency, wavelengths.
        wavelengths: f64,
        /// Most that can be searched.
        max: f64,
    },
    /// No snapshot, or a part of a snapshot.
    #[error("{samples} samples are no whole number of snapshots of {antennas} antennas, or none")]
    SampleCount {
        /// Number of samples that came.
        samples: usize,
        /// Number of antennas.
        antennas: usize,
    },
    /// A sample that is no number.
    #[error("the sample of antenna {antenna} in snapshot {snapshot} is no finite number")]
    Sample {
        /// Number of the snapshot, from 0.
        snapshot: usize,
        /// Number of the antenna, from 0.
        antenna: usize,
    },
    /// Fewer snapshots than needed.
    #[error("{snapshots} snapshots are too few: {needed} at least are needed")]
    TooFewSnapshots {
        /// Number given.
        snapshots: usize,
        /// Number needed.
        needed: usize,
    },
    /// Samples with unusable power.
    #[error("the snapshots' power is {power}: silence, or samples too large to be squared")]
    Power {
        /// Sum over the antennas, in squares of the samples' unit.
        power: f64,
    },
    /// A decomposition that found no end.
    #[error("the eigenvalues of the snapshots' covariance were not found")]
    NoConvergence,
    /// Simulated waves that cannot be.
    #[error("{name} of the simulated waves is {value}: it has to be {limit}")]
    Waves {
        /// Name of the value.
        name: &'static str,
        /// Value given.
        value: f64,
        /// Violated condition.
        limit: &'static str,
    },
}
