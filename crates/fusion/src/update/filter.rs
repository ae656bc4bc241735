//! The system filter of a target, fed with the measurements behind all sensor tracks.
//!
//! Every system track has a system filter, with any rule: reports are compared with the filter, and the innovations
//! show the accuracy of the sources. Measurements have independent errors: no assumption about the correlation of
//! sources is needed. The contribution of each source to the present estimate is kept as a share, and decays with the
//! contributions of other sources.
//!
//! The plane and the vertical have separate filters (modules `plane_filter` and `vertical_filter`): the vertical has no
//! effect on the plane. The estimate joins both, without correlation between them.
//!
//! A single innovation far outside the covariance (a blunder) gets a small weight, but is not rejected: a rejection
//! would lose a target at an unexpected place.
//!
//! Source: P. J. Huber, *Robust Statistics* (Wiley, 1981), for the weighing down.

use estimation::{Gaussian, Plane, Rotation, Vertical};
use kept::kept;
use messages::{
    AXES, HorizontalMovement, LongitudinalMovement, Movement, NS_PER_S, STATE_LEN, SensorTrack,
    UNKNOWN_CLIMB_SIGMA_MPS, VerticalMovement, movement_bits, sensor_track_bits,
};
use serde::{Deserialize, Serialize};
use source_models::{FilterInnovation, Fit, Manoeuvre, Measurement, Motion, gaussian_of};

use crate::state::State;
use crate::update::plane_filter::{AGILE, Course, PlaneFilter, STEADY};
use crate::update::vertical_filter::VerticalFilter;

/// Normalised innovation squared beyond which a measurement is weighed down.
const BLUNDER: f64 = 30.0;
/// Number of motion models in messages.
pub(crate) const MODES: usize = 8;
/// Numbers of kept probabilities: of groups of models of the plane, and of models of the vertical.
const PLANE_MODES: usize = 4;
const VERTICAL_MODES: usize = 3;
/// Speed above which a target has a rate of turn, m/s.
const MOVING_MPS: f64 = 3.0;
/// Rate of climb below which a target flies level, m/s.
const LEVEL_MPS: f64 = 1.5;
/// Time over which changes of velocity are averaged, seconds.
const ACCELERATION_S: f64 = 6.0;
/// Time after which half of the rate of a turn is expected, seconds: the turn may end before the next measurement.
const TURN_S: f64 = 4.0;
/// Probabilities of a manoeuvre: surely straight flight below the first, surely a manoeuvre above the second.
const SURELY_STRAIGHT: f64 = 0.1;
const SURELY_TURNING: f64 = 0.5;
/// Variance of the rate of climb at the first observation of a target's height, m²/s².
const VERTICAL_SPEED_M2PS2: f64 = UNKNOWN_CLIMB_SIGMA_MPS * UNKNOWN_CLIMB_SIGMA_MPS;

/// State of a target's filter at a time.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct TargetFilter {
    pub(crate) time_ns: i64,
    /// All models together.
    pub(crate) estimate: Gaussian,
    pub(crate) has_height: bool,
    plane: PlaneFilter,
    vertical: VerticalFilter,
    /// Expected motion of the target in the plane; `None` before the first measurement.
    course: Option<Course>,
    /// Whether the target was last known to fly straight, not to turn.
    is_straight: bool,
    /// Change of the estimated velocity over the last seconds, m/s².
    acceleration_mps2: [f64; AXES],
}

kept! {
    /// The part of a filter in a checkpoint.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct KeptFilter {
        time_ns: i64,
        estimate: Gaussian,
        has_height: bool,
        plane: [f64; PLANE_MODES],
        vertical: [f64; VERTICAL_MODES],
    }
}

impl TargetFilter {
    pub(crate) fn new(time_ns: i64, estimate: Gaussian, has_height: bool) -> Self {
        let (plane, vertical) = parts_of(&estimate);
        let mut filter = Self {
            time_ns,
            estimate,
            has_height,
            plane: PlaneFilter::new(plane),
            vertical: VerticalFilter::new(vertical),
            course: None,
            is_straight: false,
            acceleration_mps2: [0.0; AXES],
        };
        // The plane and the vertical are uncorrelated.
        filter.estimate.covariance = Default::default();
        filter.set_plane(&plane);
        filter.set_vertical(&vertical);
        filter
    }

    /// Creates a filter from a kept part: all models start with the same estimate, and differ afterwards.
    pub(crate) fn resumed(kept: &KeptFilter) -> Self {
        let (plane, vertical) = parts_of(&kept.estimate);
        Self {
            plane: PlaneFilter::with(plane, kept.plane),
            vertical: VerticalFilter::with(vertical, kept.vertical),
            ..Self::new(kept.time_ns, kept.estimate, kept.has_height)
        }
    }

    /// Returns the part for a checkpoint.
    #[inline]
    pub(crate) fn kept(&self) -> KeptFilter {
        KeptFilter {
            time_ns: self.time_ns,
            estimate: self.estimate,
            has_height: self.has_height,
            plane: self.plane.probabilities(),
            vertical: self.vertical.probabilities(),
        }
    }

    /// Creates a filter from all information in a report.
    pub(crate) fn of_report(report: &SensorTrack) -> Self {
        let has_height = report.has(sensor_track_bits::HEIGHT);
        Self::new(report.time_of_measurement_ns, gaussian_of(report), has_height)
    }

    /// Whether the estimate can be used: all values finite, and no variance below 0.
    pub(crate) fn is_sound(&self) -> bool {
        let Gaussian { mean, covariance } = &self.estimate;
        mean.iter().chain(&covariance.upper).all(|value| value.is_finite())
            && (0..STATE_LEN).all(|index| covariance.get(index, index) >= 0.0)
    }

    /// Returns the estimate in the form of rules and messages.
    pub(crate) fn state(&self) -> State {
        State::of_estimate(self.time_ns, &self.estimate, self.has_height)
    }

    /// Writes [`Self::state_at`] into `state`.
    #[inline]
    pub(crate) fn write_state_at(&self, time_ns: i64, motion: &Motion, state: &mut State) {
        if time_ns == self.time_ns {
            let estimate = &self.estimate;
            (state.time_ns, state.has_height) = (time_ns, self.has_height);
            (state.position_m, state.velocity_mps) = (estimate.position_m(), estimate.velocity_mps());
            state.covariance = estimate.covariance;
        } else {
            *state = self.state_at(time_ns, motion);
        }
    }

    /// Returns [`Self::at`] in the form of rules and messages.
    #[inline]
    pub(crate) fn state_at(&self, time_ns: i64, motion: &Motion) -> State {
        if time_ns == self.time_ns {
            return self.state();
        }
        State::of_estimate(time_ns, &self.at(time_ns, motion), self.has_height)
    }

    /// The estimate at `time_ns`, later or earlier.
    pub(crate) fn at(&self, time_ns: i64, motion: &Motion) -> Gaussian {
        let ns = time_ns - self.time_ns;
        if ns == 0 {
            return self.estimate;
        }
        let seconds = ns as f64 / NS_PER_S;
        let (mut plane, mut vertical) = parts_of(&self.estimate);
        let course = self.course.unwrap_or_else(|| self.plane.course(motion));
        if course.variance_m2ps4 > 0.0 {
            let [_, _, vx, vy] = plane.mean;
            let speed_mps = (vx * vx + vy * vy).sqrt().max(motion.slow_mps);
            // The turn may end meanwhile.
            let rate_radps = course.left_mps2 / (speed_mps * (1.0 + seconds.abs() / TURN_S));
            plane.turn(&Rotation::new(rate_radps, seconds));
        } else {
            plane.advance(seconds);
        }
        // An unknown acceleration counts as white noise with the same variance of the velocity.
        let density_m2ps3 = course.density_m2ps3 + 0.5 * course.variance_m2ps4 * seconds.abs();
        plane.disturb_evenly(density_m2ps3, seconds);
        vertical.advance(seconds, self.vertical.density_m2ps3(motion));
        let mut gaussian = self.estimate;
        write_plane(&mut gaussian, &plane);
        write_vertical(&mut gaussian, &vertical);
        gaussian
    }

    /// Velocity east, north, up, m/s.
    #[inline]
    pub(crate) fn velocity_mps(&self) -> [f64; AXES] {
        self.estimate.velocity_mps()
    }

    /// The position of [`Self::at`] in straight flight, metres.
    pub(crate) fn place_at(&self, time_ns: i64) -> [f64; AXES] {
        let seconds = (time_ns - self.time_ns) as f64 / NS_PER_S;
        std::array::from_fn(|axis| self.estimate.mean[axis] + seconds * self.estimate.mean[axis + AXES])
    }

    /// Changes to another point of the target, at this offset from the previous point, east and north, metres.
    pub(crate) fn shift(&mut self, by_m: [f64; 2]) {
        self.plane.shift(by_m);
        for (position, by) in self.estimate.mean.iter_mut().zip(by_m) {
            *position += by;
        }
    }

    /// Changes to another point of the target, at an unknown offset from the previous point with this variance per
    /// axis, m².
    pub(crate) fn blur(&mut self, variance_m2: f64) {
        self.plane.blur(variance_m2);
        let [xx, _, _, _, _, _, yy, ..] = &mut self.estimate.covariance.upper;
        *xx += variance_m2;
        *yy += variance_m2;
    }

    /// Takes position and velocity in the plane from a report of the same time, with the covariance times `factor`.
    /// Height and climb stay.
    pub(crate) fn follow(&mut self, report: &SensorTrack, factor: f64) {
        let (mut plane, _) = parts_of(&gaussian_of(report));
        plane.covariance.iter_mut().for_each(|value| *value *= factor);
        self.plane = PlaneFilter::new(plane);
        self.set_plane(&plane);
        (self.course, self.is_straight) = (None, false);
    }

    /// Multiplies the covariance by a factor above 1.
    pub(crate) fn inflate(&mut self, factor: f64) {
        self.plane.inflate(factor);
        self.vertical.inflate(factor);
        self.estimate
            .covariance
            .upper
            .iter_mut()
            .for_each(|value| *value *= factor);
    }

    /// Variance of the position per horizontal axis, m².
    pub(crate) fn variance_m2(&self) -> f64 {
        let [xx, _, _, yy, ..] = self.estimate.position_covariance();
        0.5 * (xx + yy)
    }

    /// Returns the variances of the velocity by manoeuvres that have begun unnoticed, m²/s²: per horizontal axis, and
    /// of the climb rate.
    #[inline]
    pub(crate) fn unnoticed_m2ps2(&self, motion: &Motion) -> [f64; 2] {
        let height_m2 = self.estimate.position_covariance()[5];
        [
            motion.unnoticed_m2ps2(self.variance_m2()),
            motion.unnoticed_climb_m2ps2(height_m2),
        ]
    }

    /// Whether the position is more certain than the other filter's.
    pub(crate) fn is_surer_than(&self, other: &Self) -> bool {
        self.variance_m2() < other.variance_m2()
    }

    /// Compares the measurement of `time_ns` with the estimate and, if `use_it`, updates the estimate. A measurement
    /// older than the filter is extrapolated with the estimated velocity, with a larger uncertainty.
    #[inline(never)]
    pub(crate) fn take(
        &mut self,
        measurement: &Measurement,
        time_ns: i64,
        motion: &Motion,
        use_it: bool,
    ) -> Option<FilterInnovation> {
        let before_mps = self.estimate.velocity_mps();
        let passed_s = (time_ns - self.time_ns).max(0) as f64 / NS_PER_S;
        let advances = time_ns > self.time_ns;
        let about = parts_of(&self.estimate).0;
        if advances {
            self.plane.advance(passed_s, motion, &about);
            self.time_ns = time_ns;
        }
        let late_s = (self.time_ns - time_ns) as f64 / NS_PER_S;
        // Kept measurements have single precision: a repeated update has to give the same bits.
        let stored_m2 = measurement.covariance_m2.map(|value| f64::from(value as f32));
        let (mut z, mut r) = (measurement.position_m, stored_m2);
        if late_s > 0.0 {
            let velocity = self.estimate.velocity_mps();
            for (z, velocity) in z.iter_mut().zip(velocity) {
                *z += velocity * late_s;
            }
            for (r, spread) in r.iter_mut().zip(self.estimate.velocity_covariance()) {
                *r += spread * late_s * late_s;
            }
        }
        self.take_height(
            measurement.axes == AXES,
            (z[2], r[5]),
            advances.then_some((passed_s, motion)),
            use_it,
        );
        let was_straight = self.is_straight;
        let mut innovation = self.update([z[0], z[1]], [r[0], r[1], r[3]], motion, use_it);
        if advances || innovation.is_none_or(|innovation| innovation.gain > 0.0) {
            let plane = self.plane.combined(&about.mean);
            self.set_plane(&plane);
            self.course = Some(self.plane.course(motion));
        }
        if let Some(innovation) = &mut innovation {
            if use_it {
                let after = self.estimate.position_covariance();
                let before = innovation.covariance_m2[0] + innovation.covariance_m2[2] - r[0] - r[3];
                innovation.gain = (1.0 - (after[0] + after[3]) / before).clamp(0.0, 1.0);
            }
            innovation.straight_s = passed_s * self.plane.steady();
            innovation.begins_turn = was_straight && !self.is_straight;
        }
        let fading = 1.0 / (1.0 + passed_s / ACCELERATION_S);
        for (axis, acceleration) in self.acceleration_mps2.iter_mut().enumerate() {
            let change_mps = self.estimate.mean[axis + AXES] - before_mps[axis];
            *acceleration = (*acceleration + change_mps / ACCELERATION_S) * fading;
        }
        innovation
    }

    /// The vertical part of [`Self::take`]: advances the vertical filter, and uses an observed height.
    fn take_height(
        &mut self,
        is_observed: bool,
        (height_m, variance_m2): (f64, f64),
        advances: Option<(f64, &Motion)>,
        use_it: bool,
    ) {
        if !self.has_height {
            if is_observed {
                self.has_height = true;
                let begun = Vertical {
                    mean: [height_m, 0.0],
                    covariance: [variance_m2, 0.0, VERTICAL_SPEED_M2PS2],
                };
                self.vertical = VerticalFilter::new(begun);
                self.set_vertical(&begun);
            }
            return;
        }
        if let Some((seconds, motion)) = advances {
            self.vertical.advance(seconds, motion);
        }
        let is_used = is_observed && use_it;
        if is_used {
            // An unusable value leaves the models unchanged.
            let _ = self.vertical.update(height_m, variance_m2);
        }
        if is_used || advances.is_some() {
            let vertical = self.vertical.combined();
            self.set_vertical(&vertical);
        }
    }

    /// Probability that the target flies straight.
    #[inline]
    pub(crate) fn steadiness(&self) -> f64 {
        self.plane.steady()
    }

    /// Returns the probabilities of the motion models, in the order of `MotionMode`.
    pub(crate) fn mode_probabilities(&self) -> [f32; MODES] {
        let [steady, agile, left, right] = self.plane.probabilities();
        let [level, climb, change] = if self.has_height {
            self.vertical.probabilities()
        } else {
            [0.0; VERTICAL_MODES]
        };
        [steady, agile, left, right, 0.0, level, climb, change].map(|probability| probability as f32)
    }

    /// Returns the expected square of the error of a velocity at `time_ns` in straight flight, east, east × north and
    /// north, m²/s².
    #[inline]
    pub(crate) fn steady_velocity_m2ps2(&self, time_ns: i64, velocity_mps: [f64; AXES], motion: &Motion) -> [f64; 3] {
        let [east, north, _] = velocity_mps;
        let [xx, xy, yy] = self.plane.steady_square([east, north]);
        let seconds = (time_ns - self.time_ns).abs() as f64 / NS_PER_S;
        let noise_m2ps2 = motion.steady_m2ps3() * seconds;
        [xx + noise_m2ps2, xy, yy + noise_m2ps2]
    }

    /// Returns the expected square of the error of a climb rate while the rate is constant, m²/s²; `None` while the
    /// rate is unknown.
    pub(crate) fn steady_climb_m2ps2(&self, climb_mps: f64) -> Option<f64> {
        let is_known = self.has_height && self.estimate.covariance.knows_climb();
        is_known.then(|| self.vertical.steady_square(climb_mps))
    }

    /// Returns the rate of turn, clockwise from above, and its standard deviation, rad/s; `None` for a nearly
    /// stationary target.
    pub(crate) fn turn_rate(&self) -> Option<[f64; 2]> {
        let course = self.course?;
        let [vx, vy, _] = self.estimate.velocity_mps();
        let speed_mps = (vx * vx + vy * vy).sqrt();
        // A white acceleration averaged over this time has this variance.
        let variance_m2ps4 = course.variance_m2ps4.max(0.0) + course.density_m2ps3 / ACCELERATION_S;
        let rate = [-course.left_mps2, variance_m2ps4.sqrt()].map(|value| value / speed_mps);
        (speed_mps > MOVING_MPS).then_some(rate)
    }

    /// Returns the rate of climb, m/s, and its variance, m²/s²; `None` without observed height, or as long as a single
    /// height leaves the rate unknown.
    pub(crate) fn climb_rate(&self) -> Option<[f64; 2]> {
        let covariance = &self.estimate.covariance;
        let rate = [self.estimate.mean[5], covariance.get(5, 5)];
        (self.has_height && covariance.knows_climb()).then_some(rate)
    }

    /// Returns the movement of the target, as far as certain.
    pub(crate) fn movement(&self) -> Movement {
        let [vx, vy, climb_mps] = self.estimate.velocity_mps();
        let [ax, ay, _] = self.acceleration_mps2;
        let speed_mps = (vx * vx + vy * vy).sqrt().max(f64::MIN_POSITIVE);
        let (along, to_left) = ((vx * ax + vy * ay) / speed_mps, (vx * ay - vy * ax) / speed_mps);
        let mut movement = Movement::default();
        let manoeuvre = 1.0 - self.plane.steady();
        if manoeuvre < SURELY_STRAIGHT {
            movement.horizontal = HorizontalMovement::Straight as u8;
            movement.longitudinal = LongitudinalMovement::Constant as u8;
            movement.valid = movement_bits::ACCELERATION;
        } else if manoeuvre > SURELY_TURNING {
            movement.acceleration_mps2 = [ax as f32, ay as f32, 0.0];
            movement.valid = movement_bits::ACCELERATION;
            // Only the larger component is certain; the other may be noise.
            if to_left.abs() >= along.abs() {
                let is_left = to_left > 0.0;
                let turns = [HorizontalMovement::TurnRight, HorizontalMovement::TurnLeft];
                movement.horizontal = turns[usize::from(is_left)] as u8;
            } else {
                let changes = [LongitudinalMovement::Decreasing, LongitudinalMovement::Increasing];
                movement.longitudinal = changes[usize::from(along > 0.0)] as u8;
            }
        }
        if self.has_height {
            let variance_m2ps2 = self.estimate.velocity_covariance()[5];
            movement.vertical = vertical_movement(climb_mps, variance_m2ps2) as u8;
        }
        movement
    }

    /// The plane part of [`Self::take`]. The gain is 1 for now if the measurement was used.
    fn update(&mut self, z: [f64; 2], mut r: [f64; 3], motion: &Motion, use_it: bool) -> Option<FilterInnovation> {
        let (expected_m, expected_m2) = self.plane.position();
        let residual_m = [z[0] - expected_m[0], z[1] - expected_m[1]];
        let covariance_m2: [f64; 3] = std::array::from_fn(|index| expected_m2[index] + r[index]);
        let squared = association::distance::squared2(residual_m, covariance_m2);
        if !squared.is_finite() {
            return None;
        }
        let mut innovation = FilterInnovation {
            residual_m,
            covariance_m2,
            squared,
            gain: 0.0,
            fit: Fit::Undecided,
            manoeuvre: None,
            straight_s: 0.0,
            begins_turn: false,
        };
        if !use_it {
            return Some(innovation);
        }
        if squared > BLUNDER {
            r.iter_mut().for_each(|value| *value *= squared / BLUNDER);
        }
        innovation.fit = self.fit(z, r);
        self.plane.update(z, r)?;
        let manoeuvre = 1.0 - self.plane.steady();
        let limit = if self.is_straight {
            SURELY_TURNING
        } else {
            SURELY_STRAIGHT
        };
        self.is_straight = manoeuvre < limit;
        if manoeuvre > SURELY_TURNING {
            let [_, agile, left, right] = self.plane.probabilities();
            innovation.manoeuvre = Some(Manoeuvre {
                agile,
                turn: left + right,
                hardness: self.plane.hardness(motion).unwrap_or_default(),
            });
        }
        innovation.gain = 1.0;
        Some(innovation)
    }

    /// Returns the fit of a measurement to the model that surely holds.
    fn fit(&self, z: [f64; 2], r: [f64; 3]) -> Fit {
        let of = |model: usize| {
            let (mean, [xx, xy, yy]) = self.plane.position_of(model);
            let residual = [z[0] - mean[0], z[1] - mean[1]];
            association::distance::squared2(residual, [xx + r[0], xy + r[1], yy + r[2]])
        };
        match self.plane.probabilities() {
            [_, probability, ..] if probability > SURELY_TURNING => Fit::Turning(of(AGILE)),
            [probability, ..] if probability > 1.0 - SURELY_STRAIGHT => Fit::Straight(of(STEADY)),
            _ => Fit::Undecided,
        }
    }

    #[inline]
    fn set_plane(&mut self, plane: &Plane) {
        write_plane(&mut self.estimate, plane);
    }

    #[inline]
    fn set_vertical(&mut self, vertical: &Vertical) {
        write_vertical(&mut self.estimate, vertical);
    }
}

/// Places of the plane's and of the vertical's elements in the upper triangle of a covariance.
const PLANE: [usize; 10] = [0, 1, 3, 4, 6, 8, 9, 15, 16, 18];
const VERTICAL: [usize; 3] = [11, 14, 20];

/// The plane and the vertical of an estimate.
fn parts_of(estimate: &Gaussian) -> (Plane, Vertical) {
    let ([x, y, z, vx, vy, vz], p) = (estimate.mean, &estimate.covariance.upper);
    let plane = Plane {
        mean: [x, y, vx, vy],
        covariance: std::array::from_fn(|element| p[PLANE[element]]),
    };
    let vertical = Vertical {
        mean: [z, vz],
        covariance: std::array::from_fn(|element| p[VERTICAL[element]]),
    };
    (plane, vertical)
}

fn write_plane(estimate: &mut Gaussian, plane: &Plane) {
    let [x, y, vx, vy] = plane.mean;
    for (component, value) in [(0, x), (1, y), (3, vx), (4, vy)] {
        estimate.mean[component] = value;
    }
    for (place, value) in PLANE.into_iter().zip(plane.covariance) {
        estimate.covariance.upper[place] = value;
    }
}

fn write_vertical(estimate: &mut Gaussian, vertical: &Vertical) {
    [estimate.mean[2], estimate.mean[5]] = vertical.mean;
    for (place, value) in VERTICAL.into_iter().zip(vertical.covariance) {
        estimate.covariance.upper[place] = value;
    }
}
/// Returns the vertical movement of a target from a climb rate with this variance, as far as certain.
pub(crate) fn vertical_movement(climb_mps: f64, variance_m2ps2: f64) -> VerticalMovement {
    let uncertain_mps = 2.0 * variance_m2ps2.max(0.0).sqrt();
    match climb_mps {
        climb if climb > uncertain_mps.max(LEVEL_MPS) => VerticalMovement::Climb,
        climb if climb < -uncertain_mps.max(LEVEL_MPS) => VerticalMovement::Descend,
        climb if climb.abs() < LEVEL_MPS && uncertain_mps < 2.0 * LEVEL_MPS => VerticalMovement::Level,
        _ => VerticalMovement::Unknown,
    }
}
