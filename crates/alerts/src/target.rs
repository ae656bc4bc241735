//! A target as the rules see it: over the ground, with a height, and with what is uncertain about both.
//!
//! Places are those on the ground below the target, east and north in the system frame ([`areas::below`]). Far from
//! the origin the frame's plane is inclined to the ground: [`along_ground`] removes that from the vector between two
//! targets.

use areas::{Level, below};
use frames::SystemFrame;
use messages::{MotionMode, SystemTrack, TrackState};

use crate::settings::{FOOT_M, Traffic};

/// Radius of the Earth, metres.
const EARTH_M: f64 = 6_371_000.0;
/// Time over which the velocity over the ground is taken, seconds.
const STEP_S: f64 = 1.0;
/// Speed above which a target without an address or a level is an aircraft, metres per second: no vessel reaches it.
const AIRBORNE_MPS: f64 = 40.0;
/// Speed up to which a target with an address may be a vehicle or taxi, metres per second.
const TAXI_MPS: f64 = 25.0;
/// Standard deviations by which it is faster, as a new track of a vehicle is not.
const TAXI_SIGMAS: f64 = 2.0;
/// Rate of turn below which there is no turn to continue, radians per second.
const TURN_MIN_RADPS: f64 = 2e-3;
/// Metres of pressure altitude in a flight level.
const FLIGHT_LEVEL_M: f64 = 100.0 * FOOT_M;

/// Height of a target, and its change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Height {
    /// Above the ellipsoid, metres.
    pub(crate) height_m: f64,
    /// Rate of climb, metres per second.
    pub(crate) climb_mps: f64,
    /// Covariance: of the height (m²), of both (m²/s), of the rate (m²/s²).
    pub(crate) covariance: [f64; 3],
    /// Probability of steady flight, and the variance of the rate in it, m²/s².
    pub(crate) steady: Option<(f64, f64)>,
}

/// State of a target at its reference time.
#[derive(Clone, Debug)]
pub(crate) struct Target {
    pub(crate) number: u32,
    /// Reference time, UTC, nanoseconds.
    pub(crate) time_ns: i64,
    /// Place on the ground below, metres.
    pub(crate) place_m: [f64; 2],
    /// Velocity of this place, metres per second.
    pub(crate) velocity_mps: [f64; 2],
    /// Covariance of place and velocity, in the order x, y, vx, vy.
    pub(crate) covariance: [[f64; 4]; 4],
    /// Probability of straight flight, and the covariance of the velocity in it: xx, xy, yy, m²/s².
    pub(crate) steady: Option<(f64, [f64; 3])>,
    /// Rate of turn, counter-clockwise from above, radians per second; 0 if there is none to continue.
    pub(crate) turn_radps: f64,
    /// Probability that the turn goes on.
    pub(crate) turn_probability: f64,
    pub(crate) height: Option<Height>,
    /// Altitude above mean sea level as far as known, metres.
    altitude_m: Option<f64>,
    /// Pressure altitude, metres.
    pressure_altitude_m: Option<f64>,
    pub(crate) is_on_ground: bool,
    is_aircraft: bool,
}

impl Target {
    /// Of a state; `None` of one that is not shown, or has no usable numbers.
    pub(crate) fn of(track: &SystemTrack, frame: &SystemFrame) -> Option<Self> {
        let is_shown = [TrackState::Confirmed, TrackState::Coasted]
            .map(|state| state.code())
            .contains(&track.state);
        let numbers = track
            .position_m
            .iter()
            .chain(&track.velocity_mps)
            .chain(&track.covariance.upper);
        if !is_shown || !numbers.into_iter().all(|number| number.is_finite()) {
            return None;
        }
        let place_m = below(frame, track.position_m);
        let moves = track.velocity_valid != 0;
        let velocity_mps = match moves {
            true => {
                let next = std::array::from_fn(|axis| track.position_m[axis] + STEP_S * track.velocity_mps[axis]);
                let next_m = below(frame, next);
                [0, 1].map(|axis| (next_m[axis] - place_m[axis]) / STEP_S)
            }
            false => [0.0; 2],
        };
        let element = |row: usize, column: usize| {
            let of = |index: usize| if index < 2 { index } else { index + 1 };
            track.covariance.get(of(row), of(column))
        };
        let turn_radps = -f64::from(track.turn_rate_radps);
        let turns = moves && turn_radps.abs() >= TURN_MIN_RADPS;
        let turning = [MotionMode::LeftTurn, MotionMode::RightTurn].map(|mode| track.mode_probabilities[mode as usize]);
        let has_height = track.height_valid != 0;
        let height = has_height.then(|| height(track, frame, moves));
        let height_m = height.map(|height| height.height_m);
        let speed_mps = velocity_mps[0].hypot(velocity_mps[1]);
        let is_vessel = track.identity.mmsi().is_some();
        let pressure_altitude_m = track
            .level_m()
            .or_else(|| Some(height_m? + track.pressure_offset().unwrap_or_default()));
        Some(Self {
            number: track.track_number,
            time_ns: track.reference_time_ns,
            place_m,
            velocity_mps,
            covariance: std::array::from_fn(|row| std::array::from_fn(|column| element(row, column))),
            steady: track.steady_velocity(),
            turn_radps: if turns { turn_radps } else { 0.0 },
            turn_probability: if turns {
                f64::from(turning[0] + turning[1]).clamp(0.0, 1.0)
            } else {
                0.0
            },
            height,
            altitude_m: track.altitude().or(track.level_m()).or(height_m),
            pressure_altitude_m,
            is_on_ground: track.on_ground != 0,
            is_aircraft: !is_vessel
                && (track.identity.address().is_some() || track.level_valid != 0 || speed_mps > AIRBORNE_MPS),
        })
    }

    /// Whether the target counts for a rule about such traffic.
    pub(crate) fn is_of(&self, traffic: Traffic) -> bool {
        match traffic {
            Traffic::Air => {
                let slowest_mps = self.speed_mps() - TAXI_SIGMAS * self.speed_sigma_mps();
                self.is_aircraft && !self.is_on_ground && slowest_mps > TAXI_MPS
            }
            Traffic::Sea => !self.is_aircraft && !self.is_on_ground,
            Traffic::All => true,
        }
    }

    /// Speed over ground, metres per second.
    pub(crate) fn speed_mps(&self) -> f64 {
        self.velocity_mps[0].hypot(self.velocity_mps[1])
    }

    /// Standard deviation of the speed over ground, metres per second: the smaller one of straight flight if it is the
    /// more probable.
    pub(crate) fn speed_sigma_mps(&self) -> f64 {
        let [xx, yy] = match self.steady {
            Some((probability, [xx, _, yy])) if probability > 0.5 => [xx, yy],
            _ => [self.covariance[2][2], self.covariance[3][3]],
        };
        (0.5 * (xx + yy)).max(0.0).sqrt()
    }

    /// Standard deviation of the place in its worst direction, metres, or more.
    pub(crate) fn place_sigma_m(&self) -> f64 {
        (self.covariance[0][0] + self.covariance[1][1]).max(0.0).sqrt()
    }

    /// Standard deviation of the velocity in its worst direction, metres per second, or more.
    pub(crate) fn velocity_sigma_mps(&self) -> f64 {
        (self.covariance[2][2] + self.covariance[3][3]).max(0.0).sqrt()
    }

    /// Height above a level, metres, and its standard deviation; `None` of a target without a height.
    pub(crate) fn above(&self, level: Level) -> Option<(f64, f64)> {
        let (own_m, level_m) = match level {
            Level::Flight(level) => (self.pressure_altitude_m?, level * FLIGHT_LEVEL_M),
            Level::Sea(height_m) => (self.altitude_m?, height_m),
        };
        let sigma_m = self.height.map_or(0.0, |height| height.covariance[0].max(0.0).sqrt());
        Some((own_m - level_m, sigma_m))
    }

    /// Pressure altitude, metres.
    pub(crate) fn pressure_altitude_m(&self) -> Option<f64> {
        self.pressure_altitude_m
    }
}

fn height(track: &SystemTrack, frame: &SystemFrame, moves: bool) -> Height {
    let vertical = frame.vertical(track.position_m, track.velocity_mps);
    let climb_mps = match moves {
        true => vertical.climb_mps,
        false => f64::from(track.climb_rate_mps),
    };
    Height {
        height_m: vertical.height_m,
        climb_mps,
        covariance: [(2, 2), (2, 5), (5, 5)].map(|(row, column)| track.covariance.get(row, column)),
        steady: track.steady_climb(),
    }
}

/// Turns a vector of the frame's plane at a place on the ground into one along the ground there, metres: the plane is
/// inclined towards the ground away from the origin, which shortens vectors from and to the origin.
pub(crate) fn along_ground(place_m: [f64; 2], [east, north]: [f64; 2]) -> [f64; 2] {
    let from_origin2 = place_m[0] * place_m[0] + place_m[1] * place_m[1];
    if from_origin2 < 1.0 {
        return [east, north];
    }
    let cosine = (1.0 - (from_origin2 / (EARTH_M * EARTH_M)).min(0.75)).sqrt();
    let radial = (place_m[0] * east + place_m[1] * north) / from_origin2 * (1.0 / cosine - 1.0);
    [east + radial * place_m[0], north + radial * place_m[1]]
}

#[cfg(test)]
mod tests {
    use frames::Geodetic;

    use super::*;

    #[test]
    fn distances_far_from_the_origin_are_those_on_the_ground() {
        let frame = SystemFrame::at(Geodetic::from_degrees(46.0, 7.0, 0.0).unwrap());
        // A minute of latitude at 52° is 1,854.6 m to 0.1 m; 667 km north of the origin the plane shows less.
        let place = |latitude| {
            below(
                &frame,
                frame.to_local(Geodetic::from_degrees(latitude, 7.0, 10_000.0).unwrap()),
            )
        };
        let (one, other) = (place(52.0), place(52.0 + 1.0 / 60.0));
        let shown = [other[0] - one[0], other[1] - one[1]];
        assert!(shown[1] < 1845.0, "{shown:?}");
        let true_m = along_ground(one, shown);
        assert!((true_m[1] - 1854.6).abs() < 1.5 && true_m[0].abs() < 0.1, "{true_m:?}");
    }

    #[test]
    fn levels_count_as_aircraft_read_them() {
        let frame = SystemFrame::at(Geodetic::from_degrees(46.0, 7.0, 0.0).unwrap());
        let track = SystemTrack {
            state: TrackState::Confirmed.code(),
            height_valid: 1,
            level: 4 * 95,
            level_valid: 1,
            altitude_m: 2_800.0,
            qnh_hpa: 1003.0,
            position_m: [0.0, 0.0, 2_950.0],
            ..SystemTrack::default()
        };
        let target = Target::of(&track, &frame).unwrap();
        let above = |text: &str| target.above(text.parse().unwrap()).unwrap().0;
        assert!(above("FL95").abs() < 0.1 && (above("2700 m") - 100.0).abs() < 1e-3);
        let ended = SystemTrack {
            state: TrackState::Terminated.code(),
            ..track
        };
        assert!(Target::of(&ended, &frame).is_none());
    }
}
