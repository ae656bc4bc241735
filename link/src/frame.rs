//! Samples from the frame of one deployment into that of another.

use frames::{FrameChange, Geodetic, SystemFrame};
use messages::{Covariance, FrameOrigin, SensorTrack, SystemTrack, WideArea, sensor_track_bits, wide_area_bits};

/// Distance of two origins below which they are the same, metres.
const SAME_M: f64 = 1e-6;

/// Returns the change from the frame at `origin` to `own`: `None` for an invalid origin, `Some(None)` for equal
/// frames.
pub(crate) fn change(origin: &FrameOrigin, own: &SystemFrame) -> Option<Option<FrameChange>> {
    let place = Geodetic::from_degrees(origin.latitude_deg, origin.longitude_deg, origin.height_m).ok()?;
    let away = own.to_local(place).into_iter().all(|distance| distance.abs() < SAME_M);
    Some((!away).then(|| FrameChange::between(&SystemFrame::at(place), own)))
}

/// A sample with positions in the system frame.
pub(crate) trait Placed {
    /// Moves it into another frame.
    fn change_frame(&mut self, change: &FrameChange);
}

impl Placed for SensorTrack {
    fn change_frame(&mut self, change: &FrameChange) {
        if self.is_incomplete() && !self.gives_trace() {
            // Turned, the variance of 0 of an unknown component would be a small one, and claim to be known well.
            *self = self.completed([None; 2]);
        }
        let has_height = self.has(sensor_track_bits::HEIGHT);
        self.position_m = at_height(change.position(self.position_m), has_height);
        self.measured_m = match (self.has(sensor_track_bits::PLATFORM), self.measured_m) {
            // The norths of two frames differ by less than a cell of a coverage is wide.
            (true, [east, north, heading_rad]) => {
                let [east, north, _] = change.position([east, north, 0.0]);
                [east, north, heading_rad]
            }
            (false, measured_m) => at_height(change.position(measured_m), has_height),
        };
        self.velocity_mps = at_height(change.direction(self.velocity_mps), has_height);
        self.covariance = turned(&self.covariance, change, has_height);
        let acceleration = self.movement.acceleration_mps2.map(f64::from);
        self.movement.acceleration_mps2 = change.direction(acceleration).map(|value| value as f32);
    }
}

impl Placed for SystemTrack {
    fn change_frame(&mut self, change: &FrameChange) {
        let has_height = self.height_valid != 0;
        self.position_m = at_height(change.position(self.position_m), has_height);
        self.velocity_mps = at_height(change.direction(self.velocity_mps), has_height);
        self.covariance = turned(&self.covariance, change, has_height);
        let acceleration = self.movement.acceleration_mps2.map(f64::from);
        self.movement.acceleration_mps2 = change.direction(acceleration).map(|value| value as f32);
    }
}

impl Placed for WideArea {
    fn change_frame(&mut self, change: &FrameChange) {
        self.position_m = change.position(self.position_m);
        self.velocity_mps = change.direction(self.velocity_mps);
        if self.valid & wide_area_bits::ORIGIN != 0 {
            let [east, north] = self.origin_m;
            let [east, north, _] = change.position([east, north, 0.0]);
            self.origin_m = [east, north];
        }
    }
}

/// Without a height, the vertical components caused by the tilt of the frames are meaningless.
fn at_height([east, north, up]: [f64; 3], has_height: bool) -> [f64; 3] {
    [east, north, if has_height { up } else { 0.0 }]
}

/// Returns the covariance of a rotated state: rotation × covariance × transpose, for position and velocity alike.
/// Without a height, the vertical variances are meaningless and remain unchanged.
fn turned(covariance: &Covariance, change: &FrameChange, has_height: bool) -> Covariance {
    let axes = if has_height { 3 } else { 2 };
    let rotation = change.rotation();
    let mut result = *covariance;
    for (row_block, column_block) in [(0, 0), (0, 3), (3, 3)] {
        for row in 0..axes {
            for column in 0..axes {
                let terms = (0..axes).flat_map(|i| (0..axes).map(move |j| (i, j)));
                let sum = terms.map(|(i, j)| {
                    rotation[row][i] * covariance.get(row_block + i, column_block + j) * rotation[column][j]
                });
                result.set(row_block + row, column_block + column, sum.sum());
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(latitude_deg: f64, longitude_deg: f64) -> (FrameOrigin, SystemFrame) {
        let place = Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).unwrap();
        let origin = FrameOrigin {
            latitude_deg,
            longitude_deg,
            height_m: 0.0,
        };
        (origin, SystemFrame::at(place))
    }

    #[test]
    fn a_track_is_at_the_same_place_and_as_uncertain_along_its_own_axes() {
        let ((origin, one), (_, other)) = (frame(41.3, 2.0), frame(41.9, 4.0));
        let change = change(&origin, &other).unwrap().unwrap();
        let mut track = SensorTrack {
            valid: sensor_track_bits::HEIGHT | sensor_track_bits::VELOCITY | sensor_track_bits::VERTICAL_RATE,
            position_m: [3e4, -2e4, 9e3],
            velocity_mps: [200.0, 30.0, -5.0],
            covariance: Covariance::diagonal([100.0, 20.0, 30.0], [3.0, 2.0, 1.0]),
            ..SensorTrack::default()
        };
        let (before, trace) = (track, track.covariance.trace(0..3));
        track.change_frame(&change);
        let (there, here) = (one.to_geodetic(before.position_m), other.to_geodetic(track.position_m));
        assert!((there.latitude_deg() - here.latitude_deg()).abs() < 1e-9);
        assert!((there.height_m() - here.height_m()).abs() < 1e-4);
        assert!(
            (track.covariance.trace(0..3) - trace).abs() < 1e-6 * trace,
            "a rotation keeps the trace"
        );
        assert!(
            track.covariance.get(0, 1).abs() > 10.0,
            "and turns the ellipse by the meridians' angle"
        );
        let back = super::change(&frame(41.9, 4.0).0, &one).unwrap().unwrap();
        track.change_frame(&back);
        for axis in 0..3 {
            assert!((track.position_m[axis] - before.position_m[axis]).abs() < 1e-4);
            assert!((track.velocity_mps[axis] - before.velocity_mps[axis]).abs() < 1e-9);
        }
    }

    #[test]
    fn what_is_unknown_here_is_unknown_there() {
        let ((origin, _), (_, other)) = (frame(41.3, 2.0), frame(41.9, 4.0));
        let change = change(&origin, &other).unwrap().unwrap();
        let mut track = SensorTrack {
            valid: sensor_track_bits::HEIGHT,
            position_m: [3e4, -2e4, 9e3],
            covariance: Covariance::diagonal([10.0; 3], [0.0; 3]),
            ..SensorTrack::default()
        };
        track.change_frame(&change);
        for component in 3..6 {
            assert!(!track.states(component) && track.covariance.get(component, component) > 100.0);
        }
        let mut of_trace = SensorTrack {
            valid: sensor_track_bits::HEIGHT | sensor_track_bits::TRACE,
            trace_m2: 800.0,
            ..SensorTrack::default()
        };
        of_trace.change_frame(&change);
        assert_eq!(of_trace.covariance, Covariance::default());
    }

    #[test]
    fn within_one_frame_nothing_is_touched_and_no_place_is_no_frame() {
        let (origin, own) = frame(41.3, 2.0);
        assert_eq!(change(&origin, &own), Some(None));
        let nowhere = FrameOrigin {
            latitude_deg: 99.0,
            ..origin
        };
        assert_eq!(change(&nowhere, &own), None);
    }

    #[test]
    fn without_a_height_the_track_stays_in_the_plane() {
        let ((origin, _), (_, other)) = (frame(41.3, 2.0), frame(41.9, 4.0));
        let change = change(&origin, &other).unwrap().unwrap();
        let mut track = SensorTrack {
            position_m: [3e4, -2e4, 0.0],
            covariance: Covariance::diagonal([100.0, 20.0, 1e6], [3.0, 2.0, 1e6]),
            ..SensorTrack::default()
        };
        track.change_frame(&change);
        assert_eq!((track.position_m[2], track.covariance.get(2, 2)), (0.0, 1e12));
        assert!(track.covariance.get(0, 0) < 1.1e4);
    }
}
