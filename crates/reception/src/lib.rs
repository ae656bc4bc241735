//! From a sensor's observations to the pipeline's reports.
//!
//! Formats differ in items, units, frames and missing data; the crate `formats` converts the target reports of each to
//! a common form, still in the sensor's own terms ([`observations::Observation`]). [`Converter`] then applies the steps
//! common to all formats: time of day to UTC, sensor frame to system frame, accuracy to covariance, and checks for
//! impossible values. Rejected reports are counted by reason and never reach fusion. `sources::Reorder` sorts reports
//! by time and determines the source's watermark.

#![forbid(unsafe_code)]

mod accuracy;
mod alert_memory;
mod converter;
mod placing;
mod plausibility;
mod truncated_time;
mod velocity;

pub use converter::Converter;
pub use placing::RefusedPlace;

use frames::{PolarSigma, SensorFrame, SystemFrame};
use settings::{Degrees, Seconds, SettingsError};

/// Model of a source for the converter.
#[derive(Clone, Copy, Debug)]
pub struct ConversionModel {
    /// Number of the source.
    pub number: u16,
    /// Only reports of this SAC/SIC are taken, where given.
    pub sac_sic: Option<(u8, u8)>,
    /// Reports that are taken, by how they were observed.
    pub method: Method,
    /// Position item that is used, where there are several.
    pub positions: PositionForm,
    /// The frame it measures in.
    pub frame: SensorFrame,
    /// The system frame.
    pub system: SystemFrame,
    /// Height of the sensor above the ellipsoid, metres.
    pub height_m: f64,
    /// Height assumed for the conversion of a slant range to a ground range if the target's height is unknown,
    /// metres. The height differs from the sensor's own height by at most half the slant range, because radars do not
    /// look up more steeply than 30°.
    pub assumed_height_m: f64,
    /// Pressure at mean sea level in the sensor's area, hPa: brings pressure altitudes, which all transponders count
    /// from [`messages::STANDARD_PRESSURE_HPA`], nearer to heights.
    pub qnh_hpa: f64,
    /// Limits of the sensor's reports.
    pub limits: PlausibilityLimits,
    /// How accurate they are.
    pub covariance: CovarianceModel,
    /// Whether the sensor is on a platform that moves: its plots stay slant range and bearing as measured, until the
    /// platform's state at their time is known.
    pub is_on_board: bool,
}

impl Method {
    /// Returns whether reports with this statement about a transponder reply are accepted.
    pub fn admits(self, secondary: Option<bool>) -> bool {
        match self {
            Self::Any => true,
            Self::Primary => secondary != Some(true),
            Self::Secondary => secondary != Some(false),
        }
    }
}

settings::settings! {
    /// Limits of a source's reports; anything else is rejected and counted.
    #[derive(Copy)]
    pub struct PlausibilityLimits {
        check PlausibilityLimits::check;
        /// Largest distance from the sensor.
        range_m: f64 = 400e3, in [1, 2e6];
        /// Lowest height.
        height_min_m: f64 = -500.0, in [-1e4, 1e5];
        /// Greatest height.
        height_max_m: f64 = 25e3, in [-1e4, 1e5];
        /// Greatest horizontal speed.
        speed_mps: f64 = 700.0, in [0.1, 2e4];
        /// Permitted distance of a position from the track's last report, in addition to the distance explained by
        /// the speed limit.
        jump_m: f64 = 100.0, in [0, 1e6];
        /// Limit for the difference between a time and the time of receipt (in a recording: its running time); a time
        /// beyond the limit is invalid.
        time_step_s: Option<Seconds> = None, in [0.01, 40e3], usually "5; in a recording 60";
        /// Greatest number of live tracks of the source; reports of further tracks are dropped and counted.
        tracks: usize = 4096, in [1, 1e6];
    }

    /// Covariance of a source's reports.
    #[derive(Copy)]
    pub struct CovarianceModel {
        check CovarianceModel::check;
        /// Origin: the report's own quality figures, if present, or the values below.
        from: CovarianceFrom = CovarianceFrom::Configuration;
        /// Standard deviation of each horizontal position component: per unit of dilution of precision if reports
        /// state this dilution; the minimum if reports state a standard deviation.
        position_sigma_m: f64 = 20.0, in [1e-3, 1e5];
        /// Standard deviation of each horizontal velocity component; the minimum if reports state a standard
        /// deviation.
        velocity_sigma_mps: f64 = 3.0, in [1e-3, 1e4];
        /// Standard deviation of each horizontal position component of a report without a statement, where others have
        /// one and `position_sigma_m` is their minimum; `from = "report"` only.
        unstated_position_sigma_m: Option<f64> = None, in [1e-3, 1e5], usually "position_sigma_m";
        /// The same of velocity components.
        unstated_velocity_sigma_mps: Option<f64> = None, in [1e-3, 1e4], usually "velocity_sigma_mps";
        /// Standard deviation of height.
        height_sigma_m: f64 = 30.0, in [1e-3, 1e5];
        /// Range error of a polar sensor; replaces `position_sigma_m`, together with `azimuth_sigma_deg`.
        range_sigma_m: Option<f64> = None, in [1e-3, 1e5];
        /// Azimuth error of a polar sensor.
        azimuth_sigma_deg: Option<Degrees> = None, in [1e-6, 45];
        /// Standard deviation of the radial speed of plots (CAT048, I048/120); the radial speed is used for tracking if
        /// this is given.
        doppler_sigma_mps: Option<f64> = None, in [1e-3, 1e4], usually "not used";
        /// Whether a positive radial speed is towards the radar: ASTERIX does not state the sign.
        doppler_towards: bool = false;
        /// Treatment of reports with a quality figure for "accuracy unknown": used with a large covariance, or
        /// rejected.
        poor_quality: PoorQuality = PoorQuality::Use;
    }
}

settings::words! {
    /// Reports of a radar accepted by this source, by method of observation: a radar with a primary and a secondary
    /// antenna is two sources (TI-2).
    pub enum Method {
        /// All of them.
        Any = "any",
        /// Echoes of the primary antenna alone.
        Primary = "primary",
        /// Replies of transponders, with an echo or without.
        Secondary = "secondary",
    }

    /// Position item to use of a report with several.
    pub enum PositionForm {
        /// Cartesian, else range and azimuth, else geographic: a radar's track rather than its plot. The plot, where
        /// there is one, goes along as the measurement behind the track.
        Any = "any",
        /// Cartesian only.
        Cartesian = "cartesian",
        /// Range and azimuth only, along the ground or straight: a radar's plot rather than its track.
        Polar = "polar",
    }

    /// Origin of a covariance.
    pub enum CovarianceFrom {
        /// From the report's own quality figures, if present.
        Report = "report",
        /// From the configuration.
        Configuration = "configuration",
    }

    /// Use of reports of unknown accuracy.
    pub enum PoorQuality {
        /// Use them, with a large covariance.
        Use = "use",
        /// Reject and count them.
        Reject = "reject",
    }
}

impl PlausibilityLimits {
    /// Distance of a time from that of receipt beyond which it is not believed: well below the time after which tracks
    /// end.
    pub fn clock_step(&self) -> Seconds {
        self.time_step_s.unwrap_or(Seconds::of(5.0))
    }

    /// The same in a recording, where only the running time is known: gaps are usual.
    fn running_step(&self) -> Seconds {
        self.time_step_s.unwrap_or(Seconds::of(60.0))
    }

    fn check(&self) -> Result<(), SettingsError> {
        let (low, high) = (self.height_min_m, self.height_max_m);
        if low <= high {
            return Ok(());
        }
        let what = format!("{high} lies below height_min_m = {low}; raise it, or lower that");
        Err(SettingsError::new("height_max_m", what))
    }
}

impl CovarianceModel {
    fn check(&self) -> Result<(), SettingsError> {
        let alone = |key, other: &str| Err(SettingsError::new(key, format!("needs {other} beside it")));
        match (self.range_sigma_m, self.azimuth_sigma_deg) {
            (None, Some(_)) => alone("azimuth_sigma_deg", "range_sigma_m"),
            (Some(_), None) => alone("range_sigma_m", "azimuth_sigma_deg"),
            _ => Ok(()),
        }
    }

    /// Range and azimuth errors of a polar sensor; `None` for other sensors.
    pub fn polar(&self) -> Option<PolarSigma> {
        let (range_m, azimuth) = self.range_sigma_m.zip(self.azimuth_sigma_deg)?;
        Some(PolarSigma {
            range_m,
            azimuth_rad: azimuth.rad(),
        })
    }
}
