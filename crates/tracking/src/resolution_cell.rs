//! Resolution cell of a sensor, and the probability that two targets lie within a cell.

use std::f64::consts::PI;

use estimation::Gaussian;
use settings::{Degrees, SettingsError};

use crate::field_of_view::between;

settings::settings! {
    /// Resolution cell of a sensor: two targets that differ by less give one detection between them.
    #[derive(Copy)]
    pub struct ResolutionCell {
        check ResolutionCell::check;
        /// Difference of range from the sensor.
        range_m: f64;
        /// Difference of bearing from the sensor.
        bearing_deg: Degrees;
    }
}

impl ResolutionCell {
    fn check(&self) -> Result<(), SettingsError> {
        // Written so that NaN is rejected.
        if self.range_m > 0.0 && self.bearing_deg.rad() > 0.0 && self.bearing_deg.rad() <= PI {
            return Ok(());
        }
        let what = "write a range above 0 m and a bearing above 0, at most 180 degrees";
        Err(SettingsError::new("range_m", what))
    }

    /// Probability that two targets lie within a cell, seen from `sensor_m`.
    pub(crate) fn holds(&self, one: &Gaussian, other: &Gaussian, sensor_m: [f64; 2]) -> f64 {
        let middle = [0, 1].map(|axis| 0.5 * (one.mean[axis] + other.mean[axis]) - sensor_m[axis]);
        let range = middle[0].hypot(middle[1]);
        let (sin, cos) = if range > 0.0 {
            (middle[0] / range, middle[1] / range)
        } else {
            (0.0, 1.0)
        };
        let [east, north] = [0, 1].map(|axis| other.mean[axis] - one.mean[axis]);
        let (a, b) = (one.position_covariance(), other.position_covariance());
        let [xx, xy, yy] = [0, 1, 3].map(|place| a[place] + b[place]);
        let along = (sin * sin * xx + 2.0 * sin * cos * xy + cos * cos * yy).max(0.0).sqrt();
        let across = (cos * cos * xx - 2.0 * sin * cos * xy + sin * sin * yy).max(0.0).sqrt();
        let within = |half: f64, difference: f64, sigma: f64| between(-half - difference, half - difference, sigma);
        let in_range = within(self.range_m, sin * east + cos * north, along);
        in_range * within(self.bearing_deg.rad() * range, cos * east - sin * north, across)
    }

    /// Largest distance of two targets in a cell at a range, metres.
    pub(crate) fn widest_m(&self, range_m: f64) -> f64 {
        self.range_m.hypot(self.bearing_deg.rad() * range_m)
    }
}
