//! Measurement as used by the filter of a system track, for repeated use.

use estimation::Gaussian;
use messages::{AXES, COVARIANCE_LEN, Covariance, STATE_LEN, SensorTrack, sensor_track_bits};
use serde::{Deserialize, Serialize};
use source_models::{Correction, FilterInnovation, Measurement, Motion, gaussian_of};

use crate::update::filter::TargetFilter;
use crate::update::filter_input::{Assumed, FilterInput};

/// A measurement as used by the filter.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct KeptMeasurement {
    /// Time of measurement, nanoseconds.
    pub(crate) time_ns: i64,
    /// Source, and number of the sensor track.
    pub(crate) track: (u16, u32),
    /// Relative to the target's reference point, without the known errors of the source.
    pub(crate) measurement: Measurement,
    /// Whether the filter used the measurement; otherwise the filter only advanced to the time of measurement.
    pub(crate) is_used: bool,
    /// State in the report behind the measurement, without the known errors of the source, and whether the state has a
    /// height.
    pub(crate) state: Gaussian,
    pub(crate) has_height: bool,
    /// Applied correction of the known errors.
    pub(crate) correction: Correction,
    /// Subtracted detection point, east and north, metres, and variance per axis, m².
    pub(crate) point_m: [f64; 2],
    pub(crate) point_m2: f64,
}

/// A measurement in use by the filter: references to the parts of a [`KeptMeasurement`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct UsedMeasurement<'a> {
    pub(crate) measurement: &'a Measurement,
    /// The report behind the measurement, without the known errors of the source.
    pub(crate) report: &'a SensorTrack,
    pub(crate) correction: &'a Correction,
    /// Whether the filter uses the measurement.
    pub(crate) is_used: bool,
    /// Subtracted detection point, east and north, metres, and variance per axis, m².
    pub(crate) point_m: [f64; 2],
    pub(crate) point_m2: f64,
}

impl UsedMeasurement<'_> {
    /// Time of measurement, nanoseconds.
    pub(crate) fn time_ns(&self) -> i64 {
        self.report.time_of_measurement_ns
    }

    /// Writes all parts into `kept`.
    #[inline]
    pub(crate) fn write(&self, kept: &mut KeptMeasurement) {
        let report = self.report;
        kept.time_ns = report.time_of_measurement_ns;
        kept.track = (report.source, report.track_number);
        kept.measurement = *self.measurement;
        kept.is_used = self.is_used;
        kept.state.mean[..AXES].copy_from_slice(&report.position_m);
        kept.state.mean[AXES..].copy_from_slice(&report.velocity_mps);
        kept.state.covariance = report.covariance;
        kept.has_height = report.has(sensor_track_bits::HEIGHT);
        kept.correction = *self.correction;
        kept.point_m = self.point_m;
        kept.point_m2 = self.point_m2;
    }

    /// Returns all parts as a copy.
    pub(crate) fn kept(&self) -> KeptMeasurement {
        KeptMeasurement {
            time_ns: self.time_ns(),
            track: (self.report.source, self.report.track_number),
            measurement: *self.measurement,
            is_used: self.is_used,
            state: gaussian_of(self.report),
            has_height: self.report.has(sensor_track_bits::HEIGHT),
            correction: *self.correction,
            point_m: self.point_m,
            point_m2: self.point_m2,
        }
    }
}

impl KeptMeasurement {
    /// Placeholder for a measurement.
    pub(crate) const NONE: Self = Self {
        time_ns: 0,
        track: (0, 0),
        measurement: Measurement::NONE,
        is_used: false,
        state: Gaussian {
            mean: [0.0; STATE_LEN],
            covariance: Covariance {
                upper: [0.0; COVARIANCE_LEN],
            },
        },
        has_height: false,
        correction: Correction::NONE,
        point_m: [0.0; 2],
        point_m2: 0.0,
    };

    /// Returns the input of the filter of a system track, without corrections.
    pub(crate) fn input(&self, system_track: u32, assumed: Assumed) -> FilterInput {
        let (mut raw, state) = (self.measurement, self.correction.undone(self.state));
        raw.refer(self.point_m.map(|point| -point), -self.point_m2);
        raw.uncorrect(&self.correction);
        let variance = |axis: usize| state.covariance.get(axis + AXES, axis + AXES);
        FilterInput {
            time_ns: self.time_ns,
            system_track,
            source: self.track.0,
            begins: false,
            has_height: raw.axes == AXES,
            position_m: raw.position_m,
            covariance_m2: raw.covariance_m2,
            velocity_mps: state.velocity_mps(),
            reported_m: state.position_m(),
            velocity_m2ps2: std::array::from_fn(variance),
            point_m: self.point_m,
            point_m2: self.point_m2,
            replaces: false,
            sensor_track: self.track.1,
            correction: self.correction,
            assumed: Some(assumed),
        }
    }

    /// Updates a filter with the measurement.
    pub(crate) fn use_in<'m>(
        &self,
        filter: &mut TargetFilter,
        motion_of: impl Fn(&TargetFilter) -> &'m Motion,
    ) -> Option<FilterInnovation> {
        let motion = motion_of(filter);
        filter.take(&self.measurement, self.time_ns, motion, self.is_used)
    }
}
