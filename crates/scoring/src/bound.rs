//! Best possible accuracy of a bearings-only fix.
//!
//! The Cramér–Rao bound is the smallest covariance of any unbiased estimate: the inverse of the information in the
//! bearings. A bearing gives only the emitter's offset across its line, with an error of sigma times the range.
//! Along the line, information results from the different directions of the lines. (Bar-Shalom, Li and Kirubarajan,
//! *Estimation with Applications to Tracking and Navigation*, section 2.7.)
//!
//! The bounds apply to the scripted cases with known geometry, see [`crate::FixCase`].

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};

/// Number of bearings of case `fixed`.
const FIXED_BEARINGS: usize = 61;
/// Distance of its emitter from the middle of the baseline, metres.
const FIXED_RANGE_M: f64 = 50e3;

/// Half axes of the aircraft's ellipse in case `drop`, east and north, metres.
const ELLIPSE_M: [f64; 2] = [8e3, 4e3];
/// Speed of the aircraft along the ellipse, m/s.
const AIRCRAFT_MPS: f64 = 100.0;
/// Number of straight pieces that approximate the ellipse.
const ELLIPSE_PIECES: usize = 20_000;
/// Bearings of case `drop`: time between two bearings, seconds, and their number.
const DROP_PERIOD_S: f64 = 2.0;
const DROP_BEARINGS: usize = 1801;
/// Standard deviation of its bearings, degrees.
const DROP_SIGMA_DEG: f64 = 2.0;
/// Drift of the transmitter of case `drop`: m/s, and degrees clockwise from north.
const DRIFT_MPS: f64 = 4.0;
const DRIFT_COURSE_DEG: f64 = 60.0;
/// Minimum distance for a bearing, metres.
const RANGE_MIN_M: f64 = 1.0;

/// Lowest possible standard deviations for a fixed emitter 50 km broadside of a straight baseline, after 61
/// bearings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BroadsideBound {
    /// Along the line of sight from the middle of the baseline, metres.
    pub(crate) range_m: f64,
    /// Across it, metres.
    pub(crate) cross_m: f64,
}

impl BroadsideBound {
    /// Computes the bound for a baseline of `baseline_m` metres and bearings with a standard deviation of
    /// `sigma_rad`; `None` if the bearings do not fix a point.
    pub(crate) fn new(baseline_m: f64, sigma_rad: f64) -> Option<Self> {
        let mut information = Matrix2::zeros();
        for bearing in 0..FIXED_BEARINGS {
            let along = bearing as f64 / (FIXED_BEARINGS - 1) as f64 - 0.5;
            let slope = bearing_slope(Vector2::new(-along * baseline_m, FIXED_RANGE_M)) / sigma_rad;
            information += slope * slope.transpose();
        }
        let covariance = information.try_inverse()?;
        Some(Self {
            range_m: covariance[(1, 1)].sqrt(),
            cross_m: covariance[(0, 0)].sqrt(),
        })
    }
}

/// Returns the lowest possible root mean square position error, metres, at the end of case `drop`, for an estimate
/// that assumes straight motion.
pub(crate) fn straight_bound_m() -> Option<f64> {
    let ellipse = Ellipse::new();
    let (sin, cos) = DRIFT_COURSE_DEG.to_radians().sin_cos();
    let drift_mps = DRIFT_MPS * Vector2::new(sin, cos);
    let end_s = (DROP_BEARINGS - 1) as f64 * DROP_PERIOD_S;
    let mut information = Matrix4::zeros();
    for bearing in 0..DROP_BEARINGS {
        let time_s = bearing as f64 * DROP_PERIOD_S;
        let line = drift_mps * time_s - ellipse.at(AIRCRAFT_MPS * time_s);
        if line.norm() <= RANGE_MIN_M {
            continue;
        }
        let slope = bearing_slope(line) / DROP_SIGMA_DEG.to_radians();
        // Velocities are scaled to metres per whole run: then all four unknowns have the same magnitude.
        let moved = slope * ((time_s - end_s) / end_s);
        let slope = Vector4::new(slope[0], slope[1], moved[0], moved[1]);
        information += slope * slope.transpose();
    }
    let covariance = information.try_inverse()?;
    Some((covariance[(0, 0)] + covariance[(1, 1)]).sqrt())
}

/// Returns the derivative of a bearing (clockwise from north) by the emitter's position, radians per metre east and
/// north; `line_m` leads from the observer to the emitter.
fn bearing_slope(line_m: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(line_m[1], -line_m[0]) / line_m.norm_squared()
}

/// Ellipse that begins at the origin and is flown at constant speed.
struct Ellipse {
    corners_m: Vec<Vector2<f64>>,
    /// Length of the path to each corner, metres.
    way_m: Vec<f64>,
}

impl Ellipse {
    fn new() -> Self {
        let corner = |piece: usize| {
            let (sin, cos) = (piece as f64 * TAU / ELLIPSE_PIECES as f64).sin_cos();
            Vector2::new(ELLIPSE_M[0] * sin, ELLIPSE_M[1] * (1.0 - cos))
        };
        let corners_m: Vec<_> = (0..=ELLIPSE_PIECES).map(corner).collect();
        let mut way_m = vec![0.0];
        for piece in corners_m.windows(2) {
            way_m.push(way_m[way_m.len() - 1] + (piece[1] - piece[0]).norm());
        }
        Self { corners_m, way_m }
    }

    /// Returns the position after `flown_m` metres, any number of laps, metres.
    fn at(&self, flown_m: f64) -> Vector2<f64> {
        let lap_m = self.way_m[ELLIPSE_PIECES];
        let flown_m = flown_m % lap_m;
        let end = self
            .way_m
            .partition_point(|way_m| *way_m <= flown_m)
            .min(ELLIPSE_PIECES);
        let (from, to) = (self.way_m[end - 1], self.way_m[end]);
        let part = (flown_m - from) / (to - from);
        self.corners_m[end - 1].lerp(&self.corners_m[end], part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published: 1916 m in range, 112 m across; 975 m with twice the baseline; 958 m with half the sigma.
    #[test]
    fn broadside_bounds_are_the_published_ones() {
        let bound = |baseline_m: f64, sigma_deg: f64| BroadsideBound::new(baseline_m, sigma_deg.to_radians()).unwrap();
        let usual = bound(10e3, 1.0);
        assert_eq!((usual.range_m.round(), usual.cross_m.round()), (1916.0, 112.0));
        assert_eq!(bound(20e3, 1.0).range_m.round(), 975.0);
        assert_eq!(bound(10e3, 0.5).range_m.round(), 958.0);
        assert_eq!(BroadsideBound::new(0.0, 0.01), None);
    }

    /// Along the line of sight the spread of directions counts, across it only the number of bearings. With a short
    /// baseline both follow from the spread of the positions: the mean of x² is L²/12 · 62/60.
    #[test]
    fn broadside_bounds_of_a_short_baseline_by_hand() {
        let (baseline_m, sigma_rad) = (100.0, 0.01);
        let bound = BroadsideBound::new(baseline_m, sigma_rad).unwrap();
        let across = sigma_rad * FIXED_RANGE_M / 61f64.sqrt();
        let spread_m = baseline_m * (62.0 / 60.0 / 12.0f64).sqrt();
        let along = across * FIXED_RANGE_M / spread_m;
        assert!((bound.cross_m / across - 1.0).abs() < 1e-5, "{bound:?} {across}");
        assert!((bound.range_m / along - 1.0).abs() < 1e-5, "{bound:?} {along}");
    }

    #[test]
    fn the_ellipse_is_flown_at_constant_speed() {
        let ellipse = Ellipse::new();
        let lap_m = ellipse.way_m[ELLIPSE_PIECES];
        // Ramanujan's formula for the length, good to 1e-5 here.
        let h = (4.0f64 / 12.0).powi(2);
        let length_m = TAU / 2.0 * 12e3 * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()));
        assert!((lap_m / length_m - 1.0).abs() < 1e-5, "{lap_m} {length_m}");
        assert!(ellipse.at(0.0).norm() < 1e-9 && ellipse.at(3.0 * lap_m).norm() < 1e-6);
        assert!((ellipse.at(0.5 * lap_m) - Vector2::new(0.0, 8e3)).norm() < 1e-3);
        let step_m = (ellipse.at(1000.0) - ellipse.at(1001.0)).norm();
        assert!((step_m - 1.0).abs() < 1e-6, "{step_m}");
    }

    #[test]
    fn knowing_the_motion_a_drifting_transmitter_is_found_to_tens_of_metres() {
        let bound_m = straight_bound_m().unwrap();
        assert!((5.0..100.0).contains(&bound_m), "{bound_m}");
    }
}
