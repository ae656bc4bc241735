//! Inputs of the filters of system tracks, for readers such as the smoother.

use estimation::Symmetric3;
use messages::AXES;
use serde::{Deserialize, Serialize};
use source_models::{Correction, Motion};

/// Input of the filter of a system track: a measurement, or the report at the start of the filter. The input still
/// contains the errors of the source, for a correction with later knowledge of the errors.
#[derive(Clone, Copy, Debug)]
pub struct FilterInput {
    /// Time of measurement, nanoseconds.
    pub time_ns: i64,
    /// Number of the system track.
    pub system_track: u32,
    /// Source of the report.
    pub source: u16,
    /// Whether the filter began with this report, without earlier information.
    pub begins: bool,
    /// Whether the third axis is measured.
    pub has_height: bool,
    /// Measured position east, north, up, metres; like the covariance, as given by the source.
    pub position_m: [f64; AXES],
    /// Upper triangle of the covariance, row by row, m².
    pub covariance_m2: Symmetric3,
    /// Velocity of the report, m/s. The source's errors depend on the velocity and the position.
    pub velocity_mps: [f64; AXES],
    /// Position of the report, metres.
    pub reported_m: [f64; AXES],
    /// Variances of the report's velocity, m²/s².
    pub velocity_m2ps2: [f64; AXES],
    /// Detection point of the source relative to the target's reference point, east and north, metres.
    pub point_m: [f64; 2],
    /// Variance per axis of the detection point, m².
    pub point_m2: f64,
    /// Whether the input replaces an earlier input with the same time and sensor track: an overtaken report came late,
    /// and the measurement was recovered anew.
    pub replaces: bool,
    /// Number of the sensor track.
    pub(crate) sensor_track: u32,
    /// Applied correction of the source's errors.
    pub(crate) correction: Correction,
    /// Assumptions at this moment; unknown at the start of the filter.
    pub(crate) assumed: Option<Assumed>,
}

/// Assumptions of fusion beside the measurements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Assumed {
    /// Motion of the target.
    pub(crate) motion: Motion,
    /// Errors that no measurement shows.
    pub(crate) unseen: UnseenErrors,
}

/// Errors of states that no measurement shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct UnseenErrors {
    /// Variance per axis, m²: of the point that filters follow, and of common offsets of the sources.
    pub(crate) per_axis_m2: f64,
    /// Variance of the time, s²: of coarse time stamps, for a target that all sources see.
    pub(crate) course_s2: f64,
    /// Variance of the height, m²: of slow errors, for a target that all sources see.
    pub(crate) height_m2: f64,
}

impl FilterInput {
    /// Whether both come from the same report.
    pub(crate) fn is_of_same_report(&self, other: &Self) -> bool {
        let report = |input: &Self| (input.time_ns, input.source, input.sensor_track);
        report(self) == report(other)
    }
}
