//! Sources with moving sensors: places of targets relative to such a source (BF-2).
//!
//! The coverage of a radar on a ship lies around the ship. Learned by place, the coverage would stay at the ship's
//! former places: the ship's silence would count against targets out of its present sight, and not against targets in
//! sight. Places of such a source are therefore relative to its platform, and turned by its heading for sensors fixed
//! to the hull. The reports of the source's tracker state the platform's place ([`sensor_track_bits::PLATFORM`]), so
//! the result depends on the reports alone.
//!
//! Limit: after [`PLACE_HOLDS_NS`] without a report, the place of a source is unknown. Its silence then proves nothing,
//! and teaches nothing.

use kept::kept;
use messages::{SensorTrack, sensor_track_bits};
use serde::{Deserialize, Serialize};

use crate::settings::CoverageArea;

/// Validity time of the latest stated place of a platform, nanoseconds: ships move less than a cell of the coverage
/// meanwhile.
const PLACE_HOLDS_NS: i64 = 60_000_000_000;
/// Largest accepted coordinate of a platform, metres.
const PLACE_MAX_M: f64 = 1e7;

kept! {
    /// Platform of a source, as stated by the latest report.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    pub(crate) struct SourcePose {
        place_m: [f64; 2],
        heading_rad: f64,
        time_ns: i64,
    }
}

/// Platforms of the moving sources.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct MovingSources(Vec<Option<SourcePose>>);

impl MovingSources {
    /// For this number of sources, without any movement so far.
    pub(crate) fn new(sources: usize) -> Self {
        Self(vec![None; sources])
    }

    /// Platform of a moving source.
    pub(crate) fn pose_mut(&mut self, source: usize) -> &mut Option<SourcePose> {
        &mut self.0[source]
    }

    /// Stores the platform stated by a report.
    #[inline]
    pub(crate) fn note(&mut self, report: &SensorTrack) {
        if report.has(sensor_track_bits::PLATFORM) {
            self.moved(report);
        }
    }

    #[cold]
    fn moved(&mut self, report: &SensorTrack) {
        let [east, north, heading_rad] = report.measured_m;
        let time_ns = report.time_of_measurement_ns;
        let is_believed = east.hypot(north) <= PLACE_MAX_M && heading_rad.is_finite();
        let pose = &mut self.0[usize::from(report.source)];
        if is_believed && pose.is_none_or(|latest| latest.time_ns <= time_ns) {
            *pose = Some(SourcePose {
                place_m: [east, north],
                heading_rad,
                time_ns,
            });
        }
    }

    /// Whether the source moves.
    #[inline]
    pub(crate) fn moves(&self, source: u16) -> bool {
        self.0[usize::from(source)].is_some()
    }

    /// A place relative to `source` at `now_ns`, with the configured coverage `area`, if any; `None` if the source's
    /// own place is unknown. For a source at rest, the place is unchanged.
    #[inline]
    pub(crate) fn seen_from(
        &self,
        source: u16,
        position_m: [f64; 3],
        now_ns: i64,
        area: Option<&CoverageArea>,
    ) -> Option<[f64; 3]> {
        let Some(pose) = &self.0[usize::from(source)] else {
            return Some(position_m);
        };
        // Corners are places on the ground.
        if area.is_some_and(|area| !area.polygon_m.is_empty()) {
            return Some(position_m);
        }
        let is_known = now_ns.saturating_sub(pose.time_ns) <= PLACE_HOLDS_NS;
        let around_m = area.map_or([0.0; 2], |area| area.place_m);
        is_known.then(|| pose.relative(position_m, around_m))
    }
}

impl SourcePose {
    /// The place to the right of the platform and before it, beside `around_m`.
    fn relative(&self, [x, y, z]: [f64; 3], around_m: [f64; 2]) -> [f64; 3] {
        let (east, north) = (x - self.place_m[0], y - self.place_m[1]);
        let (sin, cos) = self.heading_rad.sin_cos();
        [
            around_m[0] + east * cos - north * sin,
            around_m[1] + east * sin + north * cos,
            z,
        ]
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use test_support::S;

    use super::*;

    fn stated(time_s: i64, measured_m: [f64; 3]) -> SensorTrack {
        SensorTrack {
            time_of_measurement_ns: time_s * S,
            source: 1,
            valid: sensor_track_bits::PLATFORM,
            measured_m,
            ..SensorTrack::default()
        }
    }

    fn seen(sources: &MovingSources, now_s: i64) -> Option<[i64; 2]> {
        let place = sources.seen_from(1, [2000.0, 500.0, 7.0], now_s * S, None)?;
        Some([place[0].round() as i64, place[1].round() as i64])
    }

    #[test]
    fn a_place_is_seen_from_the_latest_stated_place_and_by_the_bow() {
        let mut sources = MovingSources::new(2);
        assert_eq!((seen(&sources, 0), sources.moves(1)), (Some([2000, 500]), false));
        sources.note(&SensorTrack {
            valid: sensor_track_bits::MEASURED,
            ..stated(1, [9.0; 3])
        });
        assert!(!sources.moves(1));
        sources.note(&stated(10, [1000.0, 400.0, 0.0]));
        assert_eq!(seen(&sources, 10), Some([1000, 100]));
        // To the east, places to the north are on the left.
        sources.note(&stated(11, [1000.0, 400.0, FRAC_PI_2]));
        assert_eq!(seen(&sources, 11), Some([-100, 1000]));
        for wrong in [
            stated(9, [0.0; 3]),
            stated(12, [f64::NAN, 0.0, 0.0]),
            stated(12, [2e7, 0.0, 0.0]),
        ] {
            sources.note(&wrong);
            assert_eq!(seen(&sources, 12), Some([-100, 1000]));
        }
        assert_eq!(seen(&sources, 71), Some([-100, 1000]));
        assert_eq!(seen(&sources, 72), None, "nothing has been stated for a minute");
    }

    #[test]
    fn a_configured_range_moves_and_corners_on_the_ground_do_not() {
        let mut sources = MovingSources::new(2);
        sources.note(&stated(0, [1000.0, 400.0, 0.0]));
        let mut area = CoverageArea {
            place_m: [50.0, 60.0],
            ..CoverageArea::none()
        };
        let place = |area: &CoverageArea| sources.seen_from(1, [2000.0, 500.0, 0.0], 0, Some(area));
        assert_eq!(place(&area), Some([1050.0, 160.0, 0.0]));
        area.polygon_m = vec![[0.0; 2]; 3];
        assert_eq!(place(&area), Some([2000.0, 500.0, 0.0]));
    }
}
