//! Field of view of a sensor, and the probability that a target is inside.
//!
//! Without a field of view, the tracker takes every scan for a miss of every track: a sensor with a reach of 100 m
//! deletes the tracks of a sensor with a reach of 300 m. Operators can give a sensor's reach and sector; outside,
//! silence of the sensor means nothing. A target's position is as uncertain as its track, so a miss counts with the
//! probability that the target is inside. This probability is the part of the track's Gaussian between two ranges and
//! two bearings (range and bearing are taken as independent, with the variances along and across the line of sight).
//!
//! A detection needs no such test: the target was inside.
//!
//! Limits: a sector is given in bearings from north, so a sector that turns with the vehicle must be configured as the
//! full circle. Occlusion is not modelled.

use std::f64::consts::{PI, SQRT_2, TAU};

use estimation::Gaussian;
use settings::{Degrees, SettingsError};

settings::settings! {
    /// A ring, or a sector of one, around the sensor.
    #[derive(Copy)]
    pub struct FieldOfView {
        check FieldOfView::check;
        /// Nearest and farthest horizontal distance from the sensor.
        range_m: [f64; 2];
        /// First and last bearing, clockwise from north. Without the key, all bearings.
        sector_deg: Option<[Degrees; 2]> = None, in [-360, 360];
        /// Position of the sensor, east and north. Without the key, the position stated by the sensor's detections;
        /// before the first statement, nothing counts as inside.
        position_m: Option<[f64; 2]> = None, in [-1e7, 1e7];
    }
}

impl FieldOfView {
    fn check(&self) -> Result<(), SettingsError> {
        let [near, far] = self.range_m;
        // Written so that NaN is rejected.
        if near >= 0.0 && far > near {
            return Ok(());
        }
        let what = format!("[{near}, {far}]: write the nearest and the farthest range, from 0 on");
        Err(SettingsError::new("range_m", what))
    }

    /// Width of the sector, radians.
    pub(crate) fn width_rad(&self) -> f64 {
        match self.sector_deg {
            None => TAU,
            Some([from, to]) => {
                let width = (to.rad() - from.rad()).rem_euclid(TAU);
                if width == 0.0 { TAU } else { width }
            }
        }
    }

    pub(crate) fn area_m2(&self) -> f64 {
        let [near, far] = self.range_m;
        0.5 * self.width_rad() * (far * far - near * near)
    }

    /// Whether a place is inside, seen from `sensor_m` unless the sensor's place is fixed.
    pub(crate) fn contains(&self, place_m: [f64; 2], sensor_m: Option<[f64; 2]>) -> bool {
        let Some([east, north]) = self.position_m.or(sensor_m) else {
            return false;
        };
        let (east, north) = (place_m[0] - east, place_m[1] - north);
        let [near, far] = self.range_m;
        let in_sector = || {
            self.sector_deg
                .is_none_or(|[from, _]| (east.atan2(north) - from.rad()).rem_euclid(TAU) <= self.width_rad())
        };
        (near..=far).contains(&east.hypot(north)) && in_sector()
    }

    /// Probability that a target is inside, seen from `sensor_m` unless the sensor's place is fixed.
    pub(crate) fn holds(&self, target: &Gaussian, sensor_m: Option<[f64; 2]>) -> f64 {
        let Some([east, north]) = self.position_m.or(sensor_m) else {
            return 0.0;
        };
        let (east, north) = (target.mean[0] - east, target.mean[1] - north);
        let range = east.hypot(north);
        let [xx, xy, _, yy, ..] = target.position_covariance();
        let (sin, cos) = if range > 0.0 {
            (east / range, north / range)
        } else {
            (0.0, 1.0)
        };
        let along = sin * sin * xx + 2.0 * sin * cos * xy + cos * cos * yy;
        let across = cos * cos * xx - 2.0 * sin * cos * xy + sin * sin * yy;
        let [near, far] = self.range_m;
        let in_range = between(near - range, far - range, along.max(0.0).sqrt());
        in_range * self.in_sector(east.atan2(north), across.max(0.0).sqrt() / range.max(1e-3))
    }

    fn in_sector(&self, bearing: f64, sigma: f64) -> f64 {
        let Some([from, _]) = self.sector_deg else { return 1.0 };
        let from = from.rad();
        let width = self.width_rad();
        // The bearing is unknown if the position may be on any side of the sensor.
        if sigma > 1.0 {
            return width / TAU;
        }
        let from_middle = (bearing - from - 0.5 * width + PI).rem_euclid(TAU) - PI;
        // The sector ends at a bearing and begins again a full circle later.
        let once = |shift: f64| {
            between(
                -0.5 * width - from_middle + shift,
                0.5 * width - from_middle + shift,
                sigma,
            )
        };
        (once(-TAU) + once(0.0) + once(TAU)).min(1.0)
    }
}

/// Standard deviations beyond which [`normal`] is 1, to the last bit, and beyond which [`normal`] is 0.
const ALL_BELOW: f64 = 8.5;
const NONE_BELOW: f64 = -40.0;

/// Probability that a normal deviate of mean 0 lies between.
pub(crate) fn between(from: f64, to: f64, sigma: f64) -> f64 {
    // Nearly all targets are so far inside or outside that nothing has to be computed.
    if sigma > 0.0 {
        if to <= NONE_BELOW * sigma || from >= ALL_BELOW * sigma {
            return 0.0;
        }
        if from <= -ALL_BELOW * sigma && to >= ALL_BELOW * sigma {
            return 1.0;
        }
    }
    let below = |value: f64| {
        if sigma > 0.0 {
            normal(value / sigma)
        } else {
            f64::from(u8::from(value >= 0.0))
        }
    };
    (below(to) - below(from)).clamp(0.0, 1.0)
}

/// Probability that a standard normal deviate is below `value`, to 1e-7 (Abramowitz and Stegun, 7.1.26).
fn normal(value: f64) -> f64 {
    let x = value.abs() / SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let series = [
        0.254_829_592,
        -0.284_496_736,
        1.421_413_741,
        -1.453_152_027,
        1.061_405_429,
    ];
    let sum = series.iter().rev().fold(0.0, |sum, factor| (sum + factor) * t);
    let tail = 0.5 * sum * (-x * x).exp();
    if value < 0.0 { tail } else { 1.0 - tail }
}

#[cfg(test)]
mod tests {
    use messages::Covariance;

    use super::*;

    fn target(east: f64, north: f64, sigma_m: f64) -> Gaussian {
        Gaussian {
            mean: [east, north, 0.0, 0.0, 0.0, 0.0],
            covariance: Covariance::diagonal([sigma_m; 3], [1.0; 3]),
        }
    }

    const RING: FieldOfView = FieldOfView {
        range_m: [10.0, 100.0],
        sector_deg: None,
        position_m: None,
    };

    /// The shortcuts change no bit.
    #[test]
    fn far_inside_and_far_outside_nothing_has_to_be_computed() {
        assert_eq!((normal(ALL_BELOW), normal(NONE_BELOW)), (1.0, 0.0));
        assert_eq!(1.0 - normal(-ALL_BELOW), 1.0);
        for (from, to) in [
            (-17.1, 17.1),
            (17.1, 20.0),
            (-90.0, -80.2),
            (-16.9, 17.1),
            (-17.1, 16.9),
            (16.9, 30.0),
        ] {
            let computed = (normal(to / 2.0) - normal(from / 2.0)).clamp(0.0, 1.0);
            assert_eq!(between(from, to, 2.0).to_bits(), computed.to_bits(), "{from} {to}");
        }
    }

    #[test]
    fn the_normal_distribution() {
        for (value, expected) in [(0.0, 0.5), (1.0, 0.841_344_7), (-1.0, 0.158_655_3), (-3.0, 0.001_349_9)] {
            assert!((normal(value) - expected).abs() < 2e-7, "{value}: {}", normal(value));
        }
    }

    #[test]
    fn a_ring_ends_as_softly_as_the_target_is_known() {
        let at = Some([1000.0, -500.0]);
        for (away, sigma, expected) in [
            (50.0, 2.0, 1.0),
            (100.0, 2.0, 0.5),
            (102.0, 2.0, 0.158_655),
            (120.0, 2.0, 0.0),
            (10.0, 1.0, 0.5),
            (2.0, 0.5, 0.0),
            (120.0, 20.0, 0.158_655),
            (100.0, 0.0, 1.0),
            (100.1, 0.0, 0.0),
        ] {
            let found = RING.holds(&target(1000.0 + 0.6 * away, -500.0 + 0.8 * away, sigma), at);
            assert!((found - expected).abs() < 1e-5, "{away} {sigma}: {found}");
        }
        assert_eq!(
            RING.holds(&target(50.0, 0.0, 1.0), None),
            0.0,
            "nobody knows from where it looks"
        );
        let fixed = FieldOfView {
            position_m: Some([0.0, 0.0]),
            ..RING
        };
        assert!(fixed.holds(&target(50.0, 0.0, 1.0), at) > 0.99);
    }

    #[test]
    fn a_sector_may_lie_across_the_south() {
        let sector = |degrees: [f64; 2]| FieldOfView {
            sector_deg: Some(degrees.map(Degrees::of)),
            ..RING
        };
        let seen = |view: FieldOfView, degrees: f64, sigma_m: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            view.holds(&target(50.0 * sin, 50.0 * cos, sigma_m), Some([0.0; 2]))
        };
        let south = sector([150.0, 210.0]);
        for (bearing, expected) in [
            (180.0, 1.0),
            (-179.0, 1.0),
            (150.0, 0.5),
            (-150.0, 0.5),
            (90.0, 0.0),
            (0.0, 0.0),
        ] {
            assert!((seen(south, bearing, 1.0) - expected).abs() < 1e-4, "{bearing}");
            assert!(
                (seen(sector([150.0, -150.0]), bearing, 1.0) - expected).abs() < 1e-4,
                "{bearing}"
            );
        }
        // Nearly a full circle: the probability beyond one side of the gap is seen on the other side.
        let gap = sector([1.0, 359.0]);
        assert!((seen(gap, 0.0, 5.0) - 0.86).abs() < 0.01, "{}", seen(gap, 0.0, 5.0));
        let close = south.holds(&target(0.0, 12.0, 15.0), Some([0.0; 2]));
        assert!(
            close < 0.17 && close > 0.05,
            "a sixth of the round, if not too near: {close}"
        );
        assert_eq!(sector([0.0, 360.0]).width_rad(), TAU);
        assert!((sector([150.0, -150.0]).area_m2() - PI * (1e4 - 1e2) / 6.0).abs() < 1e-6);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(RING.check().is_ok());
        for range_m in [[-1.0, 5.0], [5.0, 5.0], [f64::NAN, 5.0], [0.0, f64::NAN]] {
            assert!(FieldOfView { range_m, ..RING }.check().is_err(), "{range_m:?}");
        }
        assert!(
            FieldOfView {
                range_m: [0.0, f64::INFINITY],
                ..RING
            }
            .check()
            .is_ok()
        );
    }
}
