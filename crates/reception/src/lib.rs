//! From a sensor's records to the pipeline's reports.
//!
//! Formats differ in everything: items, units, frames, what is missing. [`observation`] brings each category's target
//! report into one form, still in the sensor's own terms. [`Converter`] then does what must be done alike for all of
//! them: time of day to UTC, the sensor's frame to the system frame, accuracy to covariance, and the checks that keep
//! impossible values out. What it refuses is counted by reason, and never reaches fusion. [`Reorder`] puts reports
//! into the order of their times and says how far the source has got.

#![forbid(unsafe_code)]

mod accuracy;
mod atmosphere;
mod converter;
pub mod observation;
mod placing;
mod plausibility;
mod reorder;
mod truncated_time;
mod velocity;

pub use atmosphere::STANDARD_PRESSURE_HPA;
pub use converter::Converter;
pub use reorder::Reorder;

use frames::{PolarSigma, SensorFrame, SystemFrame};
use serde::Deserialize;

/// What the converter must know of a source.
#[derive(Clone, Copy, Debug)]
pub struct SourceModel {
    /// Its number.
    pub number: u16,
    /// Only reports of this SAC/SIC are taken, where given.
    pub sac_sic: Option<(u8, u8)>,
    /// Which of several position items is used.
    pub positions: PositionForm,
    /// The frame it measures in.
    pub frame: SensorFrame,
    /// The system frame.
    pub system: SystemFrame,
    /// Height of the sensor above the ellipsoid, metres.
    pub height_m: f64,
    /// Height that a target is given whose slant range is to be turned into a ground range and whose own height is not
    /// known, metres; never farther from the sensor's own than half the slant range, as radars do not look up steeper
    /// than 30°.
    pub assumed_height_m: f64,
    /// Pressure at mean sea level in the sensor's area, hPa: brings pressure altitudes, which all transponders count
    /// from [`STANDARD_PRESSURE_HPA`], nearer to heights.
    pub qnh_hpa: f64,
    /// What its reports may contain.
    pub limits: Limits,
    /// How accurate they are.
    pub covariance: CovarianceModel,
}

/// What a source's reports may contain; anything else is rejected and counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest distance from the sensor, metres.
    pub range_m: f64,
    /// Lowest height, metres.
    pub height_min_m: f64,
    /// Greatest height, metres.
    pub height_max_m: f64,
    /// Greatest horizontal speed, metres per second.
    pub speed_mps: f64,
    /// How far a position may lie beyond what the speed limit explains since the track's last report, metres.
    pub jump_m: f64,
    /// How far a time of day may lie from the source's running time, nanoseconds.
    pub time_step_ns: i64,
    /// Most live tracks that are remembered.
    pub tracks: usize,
}

/// Which position item of a report is used, where it carries several.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum PositionForm {
    /// Cartesian, else range and azimuth, else geographic: a radar's track rather than its plot. The plot, where there is
    /// one, goes along as the measurement behind the track.
    #[default]
    Any,
    /// Cartesian only.
    Cartesian,
    /// Range and azimuth only, along the ground or straight: a radar's plot rather than its track.
    Polar,
}

/// Where the covariance of a source's reports comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CovarianceModel {
    /// The report's own quality figures, or the values below.
    pub from: CovarianceFrom,
    /// Standard deviation of each horizontal position component, metres. Where reports state a dilution of precision,
    /// per unit of it; where they state a standard deviation, its floor.
    pub position_sigma_m: f64,
    /// Standard deviation of each horizontal velocity component, metres per second; where reports state one, its floor.
    pub velocity_sigma_mps: f64,
    /// Standard deviation of height, metres.
    pub height_sigma_m: f64,
    /// Range and azimuth errors of a polar sensor; they replace `position_sigma_m`.
    pub polar: Option<PolarSigma>,
    /// What to do with a report whose own quality figure says that its accuracy is unknown.
    pub poor_quality: PoorQuality,
}

/// Where the covariance comes from.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum CovarianceFrom {
    /// From the report's own quality figures, where it has them.
    Report,
    /// From the configuration.
    Configuration,
}

/// What to do with reports of unknown accuracy.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum PoorQuality {
    /// Use them, with a large covariance.
    Use,
    /// Reject and count them.
    Reject,
}
