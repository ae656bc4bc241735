//! Closed path, travelled for ever; the position at any time needs no integration.
//!
//! Waypoints are joined by straight legs. Each corner is rounded by an arc of the waypoint's turn radius, tangent
//! to both legs. Speed is constant in a turn and changes at a constant rate along a leg, from one waypoint's speed
//! to the next. Height changes along a leg by half a cosine wave, so vertical speed has no step. Each segment's
//! state is then an elementary function of the time since its start, and any time is reduced to one lap.

use std::f64::consts::PI;

/// Straight legs and turns shorter than this are omitted, metres.
const SEGMENT_MIN_M: f64 = 1e-6;

/// A corner of the path, or a point on a leg where speed or height has a given value.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Waypoint {
    /// East, north, metres.
    pub(crate) position_m: [f64; 2],
    /// Height while turning here, metres.
    pub(crate) height_m: f64,
    /// Speed while turning here, m/s; 0 only on a straight course.
    pub(crate) speed_mps: f64,
    /// Radius of the arc, metres.
    pub(crate) turn_radius_m: f64,
    /// Duration of a stop here, seconds (with speed 0 only).
    pub(crate) stop_s: f64,
}

/// Position and velocity east, north, up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kinematics {
    pub(crate) position_m: [f64; 3],
    pub(crate) velocity_mps: [f64; 3],
}

/// Closed path, see the module's documentation.
#[derive(Clone, Debug)]
pub(crate) struct ClosedPath {
    segments: Vec<Segment>,
    lap_s: f64,
}

#[derive(Clone, Copy, Debug)]
struct Segment {
    begin_s: f64,
    duration_s: f64,
    course: Course,
    height_m: f64,
    climb_m: f64,
}

#[derive(Clone, Copy, Debug)]
enum Course {
    Straight {
        start_m: [f64; 2],
        direction: [f64; 2],
        speed_mps: f64,
        acceleration_mps2: f64,
    },
    Turn {
        centre_m: [f64; 2],
        radius_m: f64,
        /// Direction from centre to target at the start, counter-clockwise from east.
        start_rad: f64,
        /// Positive for a left turn.
        rate_radps: f64,
    },
}

impl ClosedPath {
    /// Creates the path through `waypoints` in order and back to the first.
    ///
    /// # Panics
    /// If the arcs of neighbouring corners overlap, or a turn has speed 0: the program makes all paths, so this is
    /// a fault of the program.
    pub(crate) fn new(waypoints: &[Waypoint]) -> Self {
        let count = waypoints.len();
        let corner = |index: usize| Corner::new([count - 1, 0, 1].map(|step| waypoints[(index + step) % count]));
        let mut path = Self {
            segments: Vec::with_capacity(3 * count),
            lap_s: 0.0,
        };
        for index in 0..count {
            let (here, next) = (corner(index), corner(index + 1));
            let waypoint = waypoints[index];
            path.push_turn(&waypoint, &here);
            path.push_stop(&waypoint, &here);
            path.push_leg(&waypoint, &here, &waypoints[(index + 1) % count], &next);
        }
        path
    }

    /// Returns the duration of one lap, seconds.
    pub(crate) fn lap_s(&self) -> f64 {
        self.lap_s
    }

    /// Returns the state `time_s` after the start of a lap, of any lap.
    pub(crate) fn at(&self, time_s: f64) -> Kinematics {
        let time_s = time_s.rem_euclid(self.lap_s);
        let index = self
            .segments
            .partition_point(|segment| segment.begin_s <= time_s)
            .saturating_sub(1);
        self.segments[index].at(time_s - self.segments[index].begin_s)
    }

    fn push(&mut self, duration_s: f64, course: Course, height_m: f64, climb_m: f64) {
        self.segments.push(Segment {
            begin_s: self.lap_s,
            duration_s,
            course,
            height_m,
            climb_m,
        });
        self.lap_s += duration_s;
    }

    fn push_turn(&mut self, waypoint: &Waypoint, corner: &Corner) {
        if corner.tangent_m < SEGMENT_MIN_M {
            return;
        }
        assert!(waypoint.speed_mps > 0.0, "a turn needs speed");
        let radius_m = waypoint.turn_radius_m;
        let left = corner.turn_rad.signum();
        let begin = corner.begin_m();
        let [east, north] = corner.incoming;
        let centre_m = [begin[0] - left * radius_m * north, begin[1] + left * radius_m * east];
        let course = Course::Turn {
            centre_m,
            radius_m,
            start_rad: (begin[1] - centre_m[1]).atan2(begin[0] - centre_m[0]),
            rate_radps: left * waypoint.speed_mps / radius_m,
        };
        let duration_s = corner.turn_rad.abs() * radius_m / waypoint.speed_mps;
        self.push(duration_s, course, waypoint.height_m, 0.0);
    }

    fn push_stop(&mut self, waypoint: &Waypoint, corner: &Corner) {
        if waypoint.stop_s <= 0.0 {
            return;
        }
        assert!(waypoint.speed_mps == 0.0, "a stop needs speed 0");
        let course = Course::Straight {
            start_m: waypoint.position_m,
            direction: corner.outgoing,
            speed_mps: 0.0,
            acceleration_mps2: 0.0,
        };
        self.push(waypoint.stop_s, course, waypoint.height_m, 0.0);
    }

    fn push_leg(&mut self, from: &Waypoint, start: &Corner, to: &Waypoint, end: &Corner) {
        let distance = norm(difference(to.position_m, from.position_m));
        let length_m = distance - start.tangent_m - end.tangent_m;
        assert!(length_m > -SEGMENT_MIN_M, "arcs of two corners overlap");
        if length_m < SEGMENT_MIN_M {
            assert!(
                from.height_m == to.height_m && from.speed_mps == to.speed_mps,
                "no leg on which to change height or speed"
            );
            return;
        }
        let (v0, v1) = (from.speed_mps, to.speed_mps);
        let course = Course::Straight {
            start_m: start.end_m(),
            direction: start.outgoing,
            speed_mps: v0,
            acceleration_mps2: (v1 * v1 - v0 * v0) / (2.0 * length_m),
        };
        let duration_s = 2.0 * length_m / (v0 + v1);
        self.push(duration_s, course, from.height_m, to.height_m - from.height_m);
    }
}

impl Segment {
    fn at(&self, time_s: f64) -> Kinematics {
        let ([x, y], [vx, vy]) = self.course.at(time_s);
        let phase = PI * time_s / self.duration_s;
        Kinematics {
            position_m: [x, y, self.height_m + self.climb_m * 0.5 * (1.0 - phase.cos())],
            velocity_mps: [vx, vy, self.climb_m * 0.5 * PI / self.duration_s * phase.sin()],
        }
    }
}

impl Course {
    fn at(&self, time_s: f64) -> ([f64; 2], [f64; 2]) {
        match *self {
            Self::Straight {
                start_m,
                direction,
                speed_mps,
                acceleration_mps2,
            } => {
                let way = speed_mps * time_s + 0.5 * acceleration_mps2 * time_s * time_s;
                let speed = speed_mps + acceleration_mps2 * time_s;
                (
                    [start_m[0] + direction[0] * way, start_m[1] + direction[1] * way],
                    direction.map(|component| component * speed),
                )
            }
            Self::Turn {
                centre_m,
                radius_m,
                start_rad,
                rate_radps,
            } => {
                let (sin, cos) = (start_rad + rate_radps * time_s).sin_cos();
                let speed = radius_m * rate_radps;
                (
                    [centre_m[0] + radius_m * cos, centre_m[1] + radius_m * sin],
                    [-speed * sin, speed * cos],
                )
            }
        }
    }
}

/// Bend of the path at a waypoint.
struct Corner {
    at_m: [f64; 2],
    incoming: [f64; 2],
    outgoing: [f64; 2],
    /// Angle from incoming to outgoing direction; positive to the left.
    turn_rad: f64,
    /// Distance from the waypoint to the start and end of the arc.
    tangent_m: f64,
}

impl Corner {
    fn new([previous, here, next]: [Waypoint; 3]) -> Self {
        let incoming = unit(difference(here.position_m, previous.position_m));
        let outgoing = unit(difference(next.position_m, here.position_m));
        let cross = incoming[0] * outgoing[1] - incoming[1] * outgoing[0];
        let dot = incoming[0] * outgoing[0] + incoming[1] * outgoing[1];
        let turn_rad = cross.atan2(dot);
        Self {
            at_m: here.position_m,
            incoming,
            outgoing,
            turn_rad,
            tangent_m: here.turn_radius_m * (0.5 * turn_rad.abs()).tan(),
        }
    }

    fn begin_m(&self) -> [f64; 2] {
        std::array::from_fn(|axis| self.at_m[axis] - self.incoming[axis] * self.tangent_m)
    }

    fn end_m(&self) -> [f64; 2] {
        std::array::from_fn(|axis| self.at_m[axis] + self.outgoing[axis] * self.tangent_m)
    }
}

fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn norm([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

fn unit(vector: [f64; 2]) -> [f64; 2] {
    let length = norm(vector);
    vector.map(|component| component / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waypoint(x: f64, y: f64, speed_mps: f64, turn_radius_m: f64) -> Waypoint {
        Waypoint {
            position_m: [x, y],
            speed_mps,
            turn_radius_m,
            ..Waypoint::default()
        }
    }

    /// Rectangle as wide as two turn radii: two legs and two half circles.
    fn racetrack() -> ClosedPath {
        ClosedPath::new(&[
            waypoint(0.0, 0.0, 100.0, 1000.0),
            waypoint(10_000.0, 0.0, 100.0, 1000.0),
            waypoint(10_000.0, 2000.0, 100.0, 1000.0),
            waypoint(0.0, 2000.0, 100.0, 1000.0),
        ])
    }

    #[test]
    fn lap_of_a_racetrack() {
        let path = racetrack();
        let length = 2.0 * 8000.0 + 2.0 * PI * 1000.0;
        assert!((path.lap_s() - length / 100.0).abs() < 1e-9);
        // A quarter turn, then half the eastbound leg.
        let quarter_s = 0.5 * PI * 1000.0 / 100.0;
        let state = path.at(quarter_s + 40.0);
        assert!((state.position_m[0] - 5000.0).abs() < 1e-9);
        assert!(state.position_m[1].abs() < 1e-9);
        assert!((state.velocity_mps[0] - 100.0).abs() < 1e-9);
        let later = path.at(quarter_s + 40.0 + 1000.0 * path.lap_s());
        assert!((later.position_m[0] - 5000.0).abs() < 1e-3);
    }

    #[test]
    fn velocity_is_the_derivative_of_position() {
        let mut stop = waypoint(5000.0, 0.0, 0.0, 0.0);
        stop.stop_s = 20.0;
        let mut high = waypoint(10_000.0, 8000.0, 150.0, 1500.0);
        high.height_m = 1000.0;
        let path = ClosedPath::new(&[
            waypoint(0.0, 0.0, 80.0, 500.0),
            stop,
            waypoint(10_000.0, 0.0, 60.0, 700.0),
            high,
            waypoint(0.0, 8000.0, 80.0, 800.0),
        ]);
        let (step, mut stood) = (1e-3, false);
        let mut time_s = 0.0;
        while time_s < path.lap_s() {
            let (before, now, after) = (path.at(time_s - step), path.at(time_s), path.at(time_s + step));
            for axis in 0..3 {
                let slope = (after.position_m[axis] - before.position_m[axis]) / (2.0 * step);
                assert!(
                    (slope - now.velocity_mps[axis]).abs() < 0.05,
                    "at {time_s} s, axis {axis}"
                );
            }
            stood |= now.velocity_mps == [0.0; 3];
            time_s += 0.37;
        }
        assert!(stood);
    }

    #[test]
    #[should_panic(expected = "overlap")]
    fn arcs_that_overlap_are_refused() {
        ClosedPath::new(&[
            waypoint(0.0, 0.0, 100.0, 2000.0),
            waypoint(3000.0, 0.0, 100.0, 2000.0),
            waypoint(3000.0, 9000.0, 100.0, 2000.0),
            waypoint(0.0, 9000.0, 100.0, 2000.0),
        ]);
    }
}
