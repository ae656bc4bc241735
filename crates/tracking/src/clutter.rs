//! Clutter density of a sensor, estimated during operation.
//!
//! Operators rarely have a figure for the clutter density, but a count gives the density: detections outside the gates
//! of all confirmed tracks are false or begin tracks, and beginnings are few. The density is the mean number of such
//! detections per scan over about [`SCANS`] scans, divided by the area that the sensor covers. The area is the field of
//! view. Without a field of view, or with detections outside, the area is the smallest rectangle around all detections.
//! The rectangle of a sensor without a field of view that shows little but a single target is as small as the target's
//! path; the few detections look like dense clutter. No side is shorter than a detection's measured place is wide
//! ([`PLACE_SIGMAS`]): equal places of targets at rest would otherwise be clutter of any density, and start no track.
//! For clutter in patches the density is too low, and too many tentative tracks begin.

use std::f64::consts::FRAC_PI_2;

use observations::DetectionKind;

use crate::initiation::Initiation;
use crate::measurement::DetectionMeasurement;

/// Scans over which numbers are averaged.
const SCANS: f64 = 20.0;
/// Smallest mean number of false detections per scan: none seen so far does not mean never.
const COUNT_MIN: f64 = 0.1;
/// Shortest side of the rectangle, standard deviations of the most exact place: three to each side.
const PLACE_SIGMAS: f64 = 6.0;

/// Area that a sensor covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SensorArea {
    /// Width of all bearings, radians.
    pub(crate) width_rad: f64,
    /// Area in the plane, square metres, if known and finite.
    pub(crate) area_m2: Option<f64>,
}

/// Estimate of a sensor's false detections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClutterEstimate {
    /// Mean number per scan.
    count: f64,
    scans: f64,
    /// Rectangle around all detections: west, south, east, north, metres.
    box_m: [f64; 4],
    /// Smallest standard deviation of a place, metres: a single bad place must not widen the rectangle.
    sigma_m: f64,
}

impl ClutterEstimate {
    pub(crate) const NONE: Self = Self {
        count: 0.0,
        scans: 0.0,
        box_m: [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY],
        sigma_m: f64::INFINITY,
    };

    /// Takes the places of a scan's detections into the rectangle.
    pub(crate) fn see(&mut self, measurement: &DetectionMeasurement) {
        if let Some(([east, north], sigma_m)) = measurement.place() {
            self.sigma_m = self.sigma_m.min(sigma_m);
            let [w, s, e, n] = self.box_m;
            self.box_m = [w.min(east), s.min(north), e.max(east), n.max(north)];
        }
    }

    /// Learns that a scan had `outside` detections outside confirmed tracks' gates.
    pub(crate) fn count(&mut self, outside: usize) {
        self.scans = (self.scans + 1.0).min(SCANS);
        self.count += (outside as f64 - self.count) / self.scans;
    }

    /// False detections per scan and square metre, or radian, of a sensor that sees so much; `present` are in the scan
    /// at hand.
    pub(crate) fn density(&self, present: usize, extent: SensorArea) -> f64 {
        let count = if self.scans > 0.0 { self.count } else { present as f64 };
        let [w, s, e, n] = self.box_m;
        // A metre more on every side: a single detection has a place, too.
        let area = if e >= w {
            let [width, length] = [e - w + 2.0, n - s + 2.0].map(|side| side.max(PLACE_SIGMAS * self.sigma_m));
            let seen = width * length;
            extent.area_m2.map_or(seen, |area| area.max(seen))
        } else {
            extent.width_rad
        };
        count.max(COUNT_MIN) / area
    }
}

/// Logarithm of the density of false detections per unit of each measured quantity, where there are `density` per
/// square metre, or per radian of bearing.
///
/// In the plane, the area of a ring of range r is proportional to r. Heights, elevations and range rates of false
/// detections are assumed anywhere within the limits assumed of targets.
pub(crate) fn log_density(measurement: &DetectionMeasurement, density: f64, guess: &Initiation) -> f64 {
    let range = measurement.values[0].max(1.0);
    let per_height = 0.5 / guess.height_sigma_m;
    let per_unit = match measurement.kind {
        DetectionKind::Position2 | DetectionKind::Bearing => 1.0,
        DetectionKind::Position3 => per_height,
        DetectionKind::RangeBearing => range,
        DetectionKind::RangeBearingElevation => range * range * per_height,
        DetectionKind::BearingElevation => 1.0 / FRAC_PI_2,
    };
    let per_rate = match measurement.range_rate_mps {
        Some(_) => 1.0 / (6.0 * guess.speed_sigma_mps),
        None => 1.0,
    };
    (density * per_unit * per_rate).ln()
}

#[cfg(test)]
mod tests {
    use observations::Detection;

    use super::*;
    use crate::Tracker;
    use crate::testing::{S, position, settings};

    #[test]
    fn what_is_seen_is_the_field_of_view_or_where_detections_were() {
        let everywhere = SensorArea {
            width_rad: 2.0,
            area_m2: None,
        };
        let ring = |area_m2| SensorArea {
            area_m2: Some(area_m2),
            ..everywhere
        };
        let mut estimate = ClutterEstimate::NONE;
        assert_eq!(estimate.density(4, everywhere), 2.0, "directions: per radian");
        for place in [[0.0, 0.0], [998.0, 498.0]] {
            estimate.see(&DetectionMeasurement::of(&position(0, place[0], place[1]), None).unwrap());
        }
        estimate.count(2);
        assert!((estimate.density(9, everywhere) - 2.0 / (1000.0 * 500.0)).abs() < 1e-12);
        // The path of a single target is not counted as clutter area; detections outside the field of view count,
        // too.
        assert!((estimate.density(9, ring(1e6)) - 2e-6).abs() < 1e-12);
        assert!((estimate.density(9, ring(10.0)) - 2.0 / (1000.0 * 500.0)).abs() < 1e-12);
    }
    #[test]
    fn equal_places_cover_what_their_errors_do() {
        let everywhere = SensorArea {
            width_rad: 2.0,
            area_m2: None,
        };
        let mut estimate = ClutterEstimate::NONE;
        for (north, sigma_m) in [(0.0, 1e9), (0.0, 20.0), (998.0, 30.0)] {
            let mut detection = position(0, 5.0, north);
            detection.sigmas = Some([sigma_m, sigma_m, 0.0, 0.0]);
            estimate.see(&DetectionMeasurement::of(&detection, None).unwrap());
        }
        estimate.count(3);
        assert!((estimate.density(3, everywhere) - 3.0 / (120.0 * 1000.0)).abs() < 1e-12);
    }

    /// Three targets at rest north of each other, and a single target, of a sensor without known properties.
    #[test]
    fn equal_detections_of_targets_at_rest_become_tracks() {
        for targets in [1, 3] {
            let mut chosen = settings();
            chosen.sensors[0].model.clutter_density = None;
            let mut tracker = Tracker::new(chosen).unwrap();
            for second in 0..30 {
                let still = |target| position(second * S, 100.0, 3000.0 * target as f64);
                let detections: Vec<Detection> = (0..targets).map(still).collect();
                tracker.scan(1, second * S, &detections).unwrap();
            }
            assert_eq!(tracker.tracks().len(), targets);
        }
    }
}
