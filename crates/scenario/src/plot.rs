//! What a sensor detected, before its own tracker made a track of it: a plot.
//!
//! A tracker that is to be tried takes these instead of the sensor's tracks. They know nothing of earlier looks, and of
//! which target they are only the truth knows.

use crate::measurement::Measurement;
use crate::sensor_settings::{MeasurementErrors, PlaneErrors};

/// One detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plot {
    /// Time of measurement, UTC, nanoseconds since 1970.
    pub time_of_measurement_ns: i64,
    /// Number of the sensor's period (a radar's turn) in which it was made, from 0.
    pub scan: u64,
    /// Number of the target; `None` for a false one.
    pub target: Option<u32>,
    /// Measured position: east, north, up, metres; up is 0 without a height.
    pub position_m: [f64; 3],
    /// Standard deviations of that, as the sensor knows them, metres; of the height 0 without one.
    pub sigma_m: [f64; 3],
    /// Whether height was measured.
    pub height: bool,
    /// Place of the sensor: east, north, up, metres.
    pub site_m: [f64; 3],
    /// For a radar: standard deviations of range, metres, and azimuth, radians.
    pub polar_sigma: Option<[f64; 2]>,
}

impl Plot {
    pub(crate) fn new(
        (time_of_measurement_ns, scan): (i64, u64),
        target: Option<u32>,
        found: &Measurement,
        site_m: [f64; 3],
        errors: &MeasurementErrors,
    ) -> Self {
        Self {
            time_of_measurement_ns,
            scan,
            target,
            position_m: found.position_m.into(),
            sigma_m: std::array::from_fn(|axis| found.covariance_m2[(axis, axis)].sqrt()),
            height: found.height,
            site_m,
            polar_sigma: match errors.plane {
                PlaneErrors::Polar {
                    range_sigma_m,
                    azimuth_sigma_rad,
                    ..
                } => Some([range_sigma_m, azimuth_sigma_rad]),
                PlaneErrors::Cartesian { .. } => None,
            },
        }
    }

    /// Range in the plane, metres, and azimuth from the sensor, radians clockwise from north, 0 to 2π.
    pub fn polar(&self) -> [f64; 2] {
        let [east, north] = [0, 1].map(|axis| self.position_m[axis] - self.site_m[axis]);
        [east.hypot(north), east.atan2(north).rem_euclid(std::f64::consts::TAU)]
    }
}
