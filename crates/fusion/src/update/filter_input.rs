//! What the filters of system tracks received: for readers of the engine's inputs, such as the smoother.

use estimation::Symmetric3;
use messages::AXES;
use source_models::{Correction, Motion};

/// What the filter of a system track received: a measurement, or the report with which it began. Its source's errors
/// are still in it, so that they can be taken off as they are known later.
#[derive(Clone, Copy, Debug)]
pub struct FilterInput {
    /// Time of measurement, nanoseconds.
    pub time_ns: i64,
    /// Number of the system track.
    pub system_track: u32,
    /// Source of the report.
    pub source: u16,
    /// Whether the filter began with this report, and with nothing of what came before.
    pub begins: bool,
    /// Whether the third axis is measured.
    pub has_height: bool,
    /// Measured position east, north, up, metres, and its covariance, as the source gives both.
    pub position_m: [f64; AXES],
    /// Upper triangle of the covariance, row by row, m².
    pub covariance_m2: Symmetric3,
    /// Velocity and position of the report, on which the source's errors depend, m/s and metres.
    pub velocity_mps: [f64; AXES],
    /// Position of the report, metres.
    pub reported_m: [f64; AXES],
    /// Variances of the report's velocity, m²/s².
    pub velocity_m2ps2: [f64; AXES],
    /// Detection point of the source relative to the target's reference point, east and north, metres, and its variance
    /// per axis, m².
    pub point_m: [f64; 2],
    /// Variance per axis of that, m².
    pub point_m2: f64,
    /// Whether it takes the place of an earlier input with the same time and sensor track: a report between both has
    /// come late, and shows what was measured.
    pub replaces: bool,
    /// Number of the sensor track.
    pub(crate) sensor_track: u32,
    /// Errors of the source, as they were taken off.
    pub(crate) correction: Correction,
    /// What fusion assumes at this moment; unknown where the filter begins.
    pub(crate) assumed: Option<Assumed>,
}

/// What fusion assumes beside the measurements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Assumed {
    /// How the target moves.
    pub(crate) motion: Motion,
    /// Variance per axis of errors that no measurement shows, m².
    pub(crate) common_error_m2: f64,
}

impl FilterInput {
    /// Whether both come from the same report.
    pub(crate) fn is_of_same_report(&self, other: &Self) -> bool {
        let report = |input: &Self| (input.time_ns, input.source, input.sensor_track);
        report(self) == report(other)
    }
}
