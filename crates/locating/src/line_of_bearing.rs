//! A bearing in the filters' form, and its dependence on the emitter's position.

use kept::kept;
use observations::Bearing;

/// Nearer to the platform than this an emitter has no direction, metres.
const OVERHEAD_M: f64 = 1.0;

kept! {
    /// A checked bearing: direction as sine and cosine, so that no angle has to be unwrapped; a few that were taken one
    /// after the other may have become one.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct LineOfBearing {
        pub(crate) time_ns: i64,
        /// Position of the platform, east and north in the system frame, metres.
        pub(crate) platform_m: [f64; 2],
        pub(crate) sine: f64,
        pub(crate) cosine: f64,
        /// Inverse variance, 1/rad².
        pub(crate) information: f64,
        /// Set if the line is used; bearings found to be wrong are not.
        pub(crate) is_used: bool,
    }
}

/// Innovation of a line of bearing where the emitter is believed to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residual {
    /// Measured minus expected bearing, radians.
    pub(crate) innovation_rad: f64,
    /// Change of the bearing per metre east and north, radians per metre.
    pub(crate) gradient: [f64; 2],
}

impl LineOfBearing {
    pub(crate) const NONE: Self = Self {
        time_ns: 0,
        platform_m: [0.0; 2],
        sine: 0.0,
        cosine: 1.0,
        information: 0.0,
        is_used: false,
    };

    /// Makes the line of a bearing with finite values.
    pub(crate) fn new(bearing: &Bearing) -> Self {
        let (sine, cosine) = bearing.bearing_rad.sin_cos();
        Self {
            time_ns: bearing.time_of_measurement_ns,
            platform_m: [bearing.platform_m[0], bearing.platform_m[1]],
            sine,
            cosine,
            information: 1.0 / (bearing.sigma_rad * bearing.sigma_rad),
            is_used: true,
        }
    }

    /// With the emitter at `position_m`; `None` where it is at the platform itself.
    pub(crate) fn residual(&self, position_m: [f64; 2]) -> Option<Residual> {
        let east = position_m[0] - self.platform_m[0];
        let north = position_m[1] - self.platform_m[1];
        let squared = east * east + north * north;
        if squared.is_nan() || squared < OVERHEAD_M * OVERHEAD_M {
            return None;
        }
        // The expected direction, rotated so that the measured direction is north.
        let across = east * self.cosine - north * self.sine;
        let along = north * self.cosine + east * self.sine;
        Some(Residual {
            innovation_rad: -small_angle(across, along),
            gradient: [north / squared, -east / squared],
        })
    }

    /// Seconds since `reference_ns`.
    pub(crate) fn after_s(&self, reference_ns: i64) -> f64 {
        (self.time_ns - reference_ns) as f64 * 1e-9
    }

    /// Distance in the plane, metres.
    pub(crate) fn distance_m(&self, position_m: [f64; 2]) -> f64 {
        self.squared_distance_m2(position_m).sqrt()
    }

    /// Squared distance.
    pub(crate) fn squared_distance_m2(&self, position_m: [f64; 2]) -> f64 {
        let [east, north]: [f64; 2] = std::array::from_fn(|axis| position_m[axis] - self.platform_m[axis]);
        east * east + north * north
    }

    /// Merges two lines taken near each other: mean time, place and direction, weighted by information.
    pub(crate) fn merged(&self, later: &Self) -> Self {
        let information = self.information + later.information;
        let share = later.information / information;
        let mean = |a: f64, b: f64| a + share * (b - a);
        let (sine, cosine) = (mean(self.sine, later.sine), mean(self.cosine, later.cosine));
        let length = sine.hypot(cosine);
        // Opposite directions have no mean; the caller does not merge them, and any one is as good as the other.
        let (sine, cosine) = match length > 0.0 {
            true => (sine / length, cosine / length),
            false => (self.sine, self.cosine),
        };
        Self {
            time_ns: self.time_ns + (share * (later.time_ns - self.time_ns) as f64) as i64,
            platform_m: std::array::from_fn(|axis| mean(self.platform_m[axis], later.platform_m[axis])),
            sine,
            cosine,
            information,
            is_used: self.is_used,
        }
    }
}

/// Returns the angle with the tangent `across / along`; nearly all angles are small, and then a few terms of the
/// series are exact to a millionth of a degree.
fn small_angle(across: f64, along: f64) -> f64 {
    let tangent = across / along;
    if along > 0.0 && tangent.abs() < 0.125 {
        let square = tangent * tangent;
        tangent * (1.0 - square * (1.0 / 3.0 - square * (0.2 - square * (1.0 / 7.0 - square / 9.0))))
    } else {
        across.atan2(along)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn line(bearing_rad: f64) -> LineOfBearing {
        LineOfBearing::new(&Bearing {
            time_of_measurement_ns: 0,
            emitter_id: None,
            bearing_rad,
            sigma_rad: 0.1,
            platform_m: [10.0, 20.0, 30.0],
            heading_rad: None,
            frequency_hz: None,
            pulse_interval_s: None,
        })
    }

    #[test]
    fn residuals_are_differences_of_angles_whatever_the_turn() {
        for (bearing, truth) in [
            (0.3, 0.31),
            (3.1, -3.1),
            (-FRAC_PI_2, 2.0),
            (0.01, 6.2),
            (1.0, 1.0 + 0.9 * PI),
        ] {
            let place = [10.0 + 500.0 * f64::sin(truth), 20.0 + 500.0 * f64::cos(truth)];
            let found = line(bearing).residual(place).unwrap();
            let mut expected: f64 = bearing - truth;
            expected -= 2.0 * PI * (expected / (2.0 * PI)).round();
            assert!((found.innovation_rad - expected).abs() < 1e-9, "{bearing} {truth}");
            // The gradient equals that of the expected bearing.
            for axis in 0..2 {
                let mut moved = place;
                moved[axis] += 0.01;
                let change = found.innovation_rad - line(bearing).residual(moved).unwrap().innovation_rad;
                assert!((change / 0.01 - found.gradient[axis]).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn an_emitter_at_the_platform_has_no_direction() {
        assert!(line(1.0).residual([10.5, 20.0]).is_none());
        assert!(line(1.0).residual([f64::NAN, 20.0]).is_none());
    }
}
