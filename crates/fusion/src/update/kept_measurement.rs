//! Measurement as used by the filter of a system track, for repeated use.

use estimation::Gaussian;
use messages::{AXES, COVARIANCE_LEN, Covariance, SensorTrack, sensor_track_bits};
use serde::{Deserialize, Serialize};
use source_models::{Correction, FilterInnovation, Measurement, Motion, Stretch, gaussian_of};

use crate::update::filter::TargetFilter;
use crate::update::filter_input::{Assumed, FilterInput};

/// A measurement as used by the filter.
#[derive(Clone, Copy, Debug)]
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

/// A kept measurement in the table: half of its size. Covariances have single precision, like in the filter: a repeated
/// update gives the bits of the first. Velocities and corrections matter for overtaken reports and for inputs only.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct StoredMeasurement {
    time_ns: i64,
    position_m: [f64; AXES],
    /// Position in the report.
    reported_m: [f64; AXES],
    covariance_m2: [f32; 6],
    velocity_mps: [f32; AXES],
    /// Upper triangle of the report's covariance.
    upper: [f32; COVARIANCE_LEN],
    shift_m: [f32; AXES],
    covariance_scale: f32,
    stretch: [f32; 3],
    point_m: [f32; 2],
    point_m2: f32,
    track_number: u32,
    source: u16,
    axes: u8,
    has_waited: bool,
    is_used: bool,
    has_height: bool,
}

fn single<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(|value| value as f32)
}

impl StoredMeasurement {
    /// Placeholder for a measurement.
    pub(crate) const NONE: Self = Self {
        time_ns: 0,
        position_m: [0.0; AXES],
        reported_m: [0.0; AXES],
        covariance_m2: [0.0; 6],
        velocity_mps: [0.0; AXES],
        upper: [0.0; COVARIANCE_LEN],
        shift_m: [0.0; AXES],
        covariance_scale: 1.0,
        stretch: [0.0; 3],
        point_m: [0.0; 2],
        point_m2: 0.0,
        track_number: 0,
        source: 0,
        axes: 0,
        has_waited: false,
        is_used: false,
        has_height: false,
    };

    /// Time of measurement, nanoseconds.
    pub(crate) fn time_ns(&self) -> i64 {
        self.time_ns
    }

    /// Source, and number of the sensor track.
    pub(crate) fn track(&self) -> (u16, u32) {
        (self.source, self.track_number)
    }

    /// Writes a measurement, the part that is not of the report.
    #[inline]
    fn write_measurement(&mut self, measurement: &Measurement) {
        self.position_m = measurement.position_m;
        self.covariance_m2 = single(measurement.covariance_m2);
        self.axes = measurement.axes as u8;
        self.has_waited = measurement.has_waited;
    }

    #[inline]
    fn write_applied(&mut self, correction: &Correction, point_m: [f64; 2], point_m2: f64) {
        self.shift_m = single(correction.shift_m);
        self.covariance_scale = correction.covariance_scale as f32;
        self.stretch = single(correction.stretch.elements());
        self.point_m = single(point_m);
        self.point_m2 = point_m2 as f32;
    }

    /// Writes a measurement in use by the filter.
    #[inline]
    pub(crate) fn write(&mut self, used: &UsedMeasurement<'_>) {
        let report = used.report;
        self.time_ns = report.time_of_measurement_ns;
        (self.source, self.track_number) = (report.source, report.track_number);
        self.write_measurement(used.measurement);
        self.is_used = used.is_used;
        self.reported_m = report.position_m;
        self.velocity_mps = single(report.velocity_mps);
        self.upper = single(report.covariance.upper);
        self.has_height = report.has(sensor_track_bits::HEIGHT);
        self.write_applied(used.correction, used.point_m, used.point_m2);
    }

    /// Writes a kept measurement.
    pub(crate) fn write_kept(&mut self, kept: &KeptMeasurement) {
        self.time_ns = kept.time_ns;
        (self.source, self.track_number) = kept.track;
        self.write_measurement(&kept.measurement);
        self.is_used = kept.is_used;
        self.reported_m = kept.state.position_m();
        self.velocity_mps = single(kept.state.velocity_mps());
        self.upper = single(kept.state.covariance.upper);
        self.has_height = kept.has_height;
        self.write_applied(&kept.correction, kept.point_m, kept.point_m2);
    }

    /// Puts another measurement in the place of that of the report.
    pub(crate) fn replace(&mut self, measurement: &Measurement) {
        self.write_measurement(measurement);
    }

    /// Relates the measurement to another point of the target, at this offset from the previous point.
    pub(crate) fn shift(&mut self, by_m: [f64; 2]) {
        for (axis, by) in by_m.into_iter().enumerate() {
            self.position_m[axis] += by;
            self.point_m[axis] -= by as f32;
        }
    }

    fn measurement(&self) -> Measurement {
        Measurement {
            position_m: self.position_m,
            covariance_m2: self.covariance_m2.map(f64::from),
            axes: self.axes.into(),
            has_waited: self.has_waited,
        }
    }

    /// The measurement with all parts.
    pub(crate) fn kept(&self) -> KeptMeasurement {
        let covariance = Covariance {
            upper: self.upper.map(f64::from),
        };
        KeptMeasurement {
            time_ns: self.time_ns,
            track: self.track(),
            measurement: self.measurement(),
            is_used: self.is_used,
            state: Gaussian::new(self.reported_m, self.velocity_mps.map(f64::from), &covariance),
            has_height: self.has_height,
            correction: Correction {
                shift_m: self.shift_m.map(f64::from),
                covariance_scale: self.covariance_scale.into(),
                stretch: Stretch::of_elements(self.stretch.map(f64::from)),
            },
            point_m: self.point_m.map(f64::from),
            point_m2: self.point_m2.into(),
        }
    }

    /// Updates a filter with the measurement.
    pub(crate) fn use_in<'m>(
        &self,
        filter: &mut TargetFilter,
        motion_of: impl Fn(&TargetFilter) -> &'m Motion,
    ) -> Option<FilterInnovation> {
        let motion = motion_of(filter);
        filter.take(&self.measurement(), self.time_ns, motion, self.is_used)
    }
}
