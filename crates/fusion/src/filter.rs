//! The system filter: one per target, fed with the measurements behind all sensor tracks.
//!
//! Every system track has a system filter, with any rule: reports are compared with the filter, and its innovations
//! show the accuracy of the sources. Measurements have independent errors, so that no assumption about the
//! correlation of sources is needed. The filter keeps the contribution of each source to the present estimate as a
//! share, which decays with the contributions of other sources.
//!
//! A target flies straight most of the time, and turns sometimes. A filter prepared for turns discards most of its
//! knowledge on straight legs; several sensors even worsen this, because more measurements per second shorten its
//! memory. Therefore two filters run in parallel: one for steady motion, and one with the process noise of turns
//! (module `manoeuvres`). Their probabilities follow from their predictions of the measurements (interacting multiple
//! models).
//!
//! A single innovation far outside its covariance (a blunder) gets a small weight, but is not rejected: a rejection
//! would lose a target at an unexpected place.
//!
//! Source: H. A. P. Blom, Y. Bar-Shalom, *The interacting multiple model algorithm for systems with Markovian switching
//! coefficients*, IEEE Transactions on Automatic Control 33 (1988); P. J. Huber, *Robust Statistics* (Wiley, 1981), for
//! the weighing down.

use estimation::{AxisNoise, Gaussian, Symmetric3};
use kept::kept;
use messages::{
    AXES, HorizontalMovement, LongitudinalMovement, Movement, NS_PER_S, STATE_LEN, SensorTrack, VerticalMovement,
    movement_bits, sensor_track_bits,
};
use serde::{Deserialize, Serialize};

use crate::measurement::{Measurement, gaussian_of};
use crate::motion::Motion;
use crate::state::State;

/// Normalised innovation squared beyond which a measurement is weighed down.
const BLUNDER: f64 = 30.0;
/// Number of motion models.
pub(crate) const MODES: usize = 2;
/// Process noise of steady motion, relative to that of turns.
const STEADY: f64 = 4e-4;
/// Mean duration of turns, seconds.
const TURN_S: f64 = 15.0;
/// Probabilities of the models at the start.
const PRIOR: [f64; MODES] = [0.8, 0.2];
/// Rate of climb below which a target flies level, m/s.
const LEVEL_MPS: f64 = 1.5;
/// Time over which changes of velocity are averaged, seconds.
const ACCELERATION_S: f64 = 6.0;
/// Smallest probability of a model: it must be able to come back.
const PROBABILITY_MIN: f64 = 1e-4;
/// Probabilities of a turn below which a target surely flies straight, and above which it surely turns.
const SURELY_STRAIGHT: f64 = 0.1;
const SURELY_TURNING: f64 = 0.5;

/// State of a target's filter at a time.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Filter {
    pub(crate) time_ns: i64,
    /// All models together.
    pub(crate) estimate: Gaussian,
    pub(crate) has_height: bool,
    modes: [Gaussian; MODES],
    probability: [f64; MODES],
    /// Whether the target was last known to fly straight, not to turn.
    is_straight: bool,
    /// Change of the estimated velocity over the last seconds, m/s².
    acceleration_mps2: [f64; AXES],
}

kept! {
    /// A filter as a checkpoint keeps it.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct KeptFilter {
        time_ns: i64,
        estimate: Gaussian,
        has_height: bool,
        probability: [f64; MODES],
    }
}

/// How well the model that surely held foretold a measurement: normalised innovation squared in the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Fit {
    Straight(f64),
    Turning(f64),
    /// Neither did.
    Undecided,
}

/// Difference between a measurement and its prediction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Innovation {
    /// East and north, metres.
    pub(crate) residual_m: [f64; 2],
    /// Covariance of the residual (xx, xy, yy), m².
    pub(crate) covariance_m2: [f64; 3],
    /// Weight of the measurement in the new horizontal position, in [0, 1]; 0 if it was not used.
    pub(crate) gain: f64,
    pub(crate) fit: Fit,
    /// Time for which the target is expected to have flown straight since the last measurement, s.
    pub(crate) straight_s: f64,
    /// Whether the target, which surely flew straight, surely turns.
    pub(crate) begins_turn: bool,
}

impl Filter {
    pub(crate) fn new(time_ns: i64, estimate: Gaussian, has_height: bool) -> Self {
        Self {
            time_ns,
            estimate,
            has_height,
            modes: [estimate; MODES],
            probability: PRIOR,
            is_straight: false,
            acceleration_mps2: [0.0; AXES],
        }
    }

    /// A kept filter: its models start with the same estimate, and differ afterwards.
    pub(crate) fn resumed(kept: &KeptFilter) -> Self {
        Self {
            probability: kept.probability,
            ..Self::new(kept.time_ns, kept.estimate, kept.has_height)
        }
    }

    /// Part of it that a checkpoint keeps.
    #[inline]
    pub(crate) fn kept(&self) -> KeptFilter {
        KeptFilter {
            time_ns: self.time_ns,
            estimate: self.estimate,
            has_height: self.has_height,
            probability: self.probability,
        }
    }

    /// All information in a report.
    pub(crate) fn of_report(report: &SensorTrack) -> Self {
        let has_height = report.has(sensor_track_bits::HEIGHT);
        Self::new(report.time_of_measurement_ns, gaussian_of(report), has_height)
    }

    /// Whether the estimate can be used: all of it finite, and no variance below 0.
    pub(crate) fn is_sound(&self) -> bool {
        let Gaussian { mean, covariance } = &self.estimate;
        mean.iter().chain(&covariance.upper).all(|value| value.is_finite())
            && (0..STATE_LEN).all(|index| covariance.get(index, index) >= 0.0)
    }

    /// Returns the estimate in the form of rules and messages.
    pub(crate) fn state(&self) -> State {
        State::of_estimate(self.time_ns, &self.estimate, self.has_height)
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
        let factor = self.probability[0] * STEADY + self.probability[1];
        let seconds = ns as f64 / NS_PER_S;
        self.estimate.moved(seconds, noise_over(motion, factor, seconds))
    }

    /// The position of [`Self::at`], metres.
    pub(crate) fn place_at(&self, time_ns: i64) -> [f64; AXES] {
        let seconds = (time_ns - self.time_ns) as f64 / NS_PER_S;
        std::array::from_fn(|axis| self.estimate.mean[axis] + seconds * self.estimate.mean[axis + AXES])
    }

    /// Follows a point of the target from now on that lies so far, east and north, from the one before, metres.
    pub(crate) fn shift(&mut self, by_m: [f64; 2]) {
        for estimate in self.modes.iter_mut().chain([&mut self.estimate]) {
            for (position, by) in estimate.mean.iter_mut().zip(by_m) {
                *position += by;
            }
        }
    }

    /// Whether its position is known better than the other's.
    pub(crate) fn is_surer_than(&self, other: &Self) -> bool {
        let trace = |filter: &Self| {
            let [xx, _, _, yy, ..] = filter.estimate.position_covariance();
            xx + yy
        };
        trace(self) < trace(other)
    }

    /// Brings the models forward to `time_ns`, never back; whether they have moved. The estimate stays behind.
    fn advance_models(&mut self, time_ns: i64, motion: &Motion) -> bool {
        if time_ns <= self.time_ns {
            return false;
        }
        let seconds = (time_ns - self.time_ns) as f64 / NS_PER_S;
        self.mix(seconds, motion.steady_s);
        self.modes[0].advance(seconds, noise_over(motion, STEADY, seconds));
        self.modes[1].advance(seconds, noise_over(motion, 1.0, seconds));
        self.time_ns = time_ns;
        true
    }

    /// Targets may have begun or ended to manoeuvre in `seconds`.
    fn mix(&mut self, seconds: f64, steady_s: f64) {
        let leave = [steady_s, TURN_S].map(|duration| seconds / (seconds + duration));
        let stay = [1.0 - leave[0], 1.0 - leave[1]];
        let [p, q] = self.probability;
        // Probability of each model afterwards, by where it comes from.
        let steady = p * stay[0] + q * leave[1];
        let turn = p * leave[0] + q * stay[1];
        let [a, b] = &mut self.modes;
        Gaussian::exchange(a, b, [q * leave[1] / steady, q * stay[1] / turn]);
        self.probability = [steady, turn];
    }

    /// Makes the first `N` components of the estimate those of the models together.
    fn combine<const N: usize>(&mut self) {
        let [a, b] = &self.modes;
        self.estimate.mix::<N>(a, b, self.probability[1]);
    }

    /// Compares the measurement of `time_ns` with the estimate and, if `use_it`, updates the estimate. A measurement
    /// older than the filter is extrapolated with the estimated velocity, with a larger uncertainty.
    pub(crate) fn take(
        &mut self,
        measurement: &Measurement,
        time_ns: i64,
        motion: &Motion,
        use_it: bool,
    ) -> Option<Innovation> {
        let before_mps = self.estimate.velocity_mps();
        let passed_s = (time_ns - self.time_ns).max(0) as f64 / NS_PER_S;
        let mut behind = self.advance_models(time_ns, motion);
        if behind {
            // All that a measurement is compared with; the rest follows when it has been used.
            self.combine::<AXES>();
        }
        let late_s = (self.time_ns - time_ns) as f64 / NS_PER_S;
        let (mut z, mut r) = (measurement.position_m, measurement.covariance_m2);
        if late_s > 0.0 {
            let velocity = self.estimate.velocity_mps();
            for (z, velocity) in z.iter_mut().zip(velocity) {
                *z += velocity * late_s;
            }
            for (r, spread) in r.iter_mut().zip(self.estimate.velocity_covariance()) {
                *r += spread * late_s * late_s;
            }
        }
        if measurement.axes == AXES && !self.has_height {
            if std::mem::take(&mut behind) {
                self.combine::<STATE_LEN>();
            }
            self.begin_height(z[2], r[5]);
        }
        let was_straight = self.is_straight;
        let mut innovation = if measurement.axes == AXES {
            self.update::<AXES>(z, r, use_it)
        } else {
            self.update::<2>(z, r, use_it)
        };
        if behind && !(use_it && innovation.is_some()) {
            self.combine::<STATE_LEN>();
        }
        if let Some(innovation) = &mut innovation {
            innovation.straight_s = passed_s * self.probability[0];
            innovation.begins_turn = was_straight && !self.is_straight;
        }
        let fading = 1.0 / (1.0 + passed_s / ACCELERATION_S);
        for (axis, acceleration) in self.acceleration_mps2.iter_mut().enumerate() {
            let change_mps = self.estimate.mean[axis + AXES] - before_mps[axis];
            *acceleration = (*acceleration + change_mps / ACCELERATION_S) * fading;
        }
        innovation
    }

    /// Returns the probabilities of the motion models, in the order of `MotionMode`.
    pub(crate) fn mode_probabilities(&self) -> [f32; MODES] {
        self.probability.map(|probability| probability as f32)
    }

    /// How the target moves, as far as that is sure.
    pub(crate) fn movement(&self) -> Movement {
        let [vx, vy, climb_mps] = self.estimate.velocity_mps();
        let [ax, ay, _] = self.acceleration_mps2;
        let speed_mps = vx.hypot(vy).max(f64::MIN_POSITIVE);
        let (along, to_left) = ((vx * ax + vy * ay) / speed_mps, (vx * ay - vy * ax) / speed_mps);
        let mut movement = Movement::default();
        let turn = self.probability[1];
        if turn < SURELY_STRAIGHT {
            movement.horizontal = HorizontalMovement::Straight as u8;
            movement.longitudinal = LongitudinalMovement::Constant as u8;
            movement.valid = movement_bits::ACCELERATION;
        } else if turn > SURELY_TURNING {
            movement.acceleration_mps2 = [ax as f32, ay as f32, 0.0];
            movement.valid = movement_bits::ACCELERATION;
            // One of the two is what the target surely does; the other may be noise.
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
            let uncertain_mps = 2.0 * self.estimate.velocity_covariance()[5].max(0.0).sqrt();
            let vertical = match climb_mps {
                climb if climb > uncertain_mps.max(LEVEL_MPS) => VerticalMovement::Climb,
                climb if climb < -uncertain_mps.max(LEVEL_MPS) => VerticalMovement::Descend,
                climb if climb.abs() < LEVEL_MPS && uncertain_mps < 2.0 * LEVEL_MPS => VerticalMovement::Level,
                _ => VerticalMovement::Unknown,
            };
            movement.vertical = vertical as u8;
        }
        movement
    }

    fn update<const D: usize>(&mut self, z: [f64; AXES], mut r: Symmetric3, use_it: bool) -> Option<Innovation> {
        let expected = self.estimate.position_covariance();
        let squared = self.estimate.squared_distance::<D>(z, &r)?;
        let mut innovation = Innovation {
            residual_m: [z[0] - self.estimate.mean[0], z[1] - self.estimate.mean[1]],
            covariance_m2: [expected[0] + r[0], expected[1] + r[1], expected[3] + r[3]],
            gain: 0.0,
            fit: Fit::Undecided,
            straight_s: 0.0,
            begins_turn: false,
        };
        if !use_it {
            return Some(innovation);
        }
        if squared > BLUNDER {
            r.iter_mut().for_each(|value| *value *= squared / BLUNDER);
        }
        innovation.fit = self.fit(z, &r);
        let mut likelihood = [0.0; MODES];
        for (mode, likelihood) in self.modes.iter_mut().zip(&mut likelihood) {
            let own = mode.update_position::<D>(z, &r)?;
            *likelihood = -0.5 * (own.squared_distance + own.log_determinant);
        }
        // Only the difference matters, and a huge one must not become 0/0.
        let ratio = (likelihood[1] - likelihood[0]).clamp(-50.0, 50.0).exp();
        let turn = self.probability[1] * ratio / (self.probability[0] + self.probability[1] * ratio);
        let turn = turn.clamp(PROBABILITY_MIN, 1.0 - PROBABILITY_MIN);
        self.probability = [1.0 - turn, turn];
        let limit = if self.is_straight {
            SURELY_TURNING
        } else {
            SURELY_STRAIGHT
        };
        self.is_straight = turn < limit;
        self.combine::<STATE_LEN>();
        let after = self.estimate.position_covariance();
        innovation.gain = (1.0 - (after[0] + after[3]) / (expected[0] + expected[3])).clamp(0.0, 1.0);
        Some(innovation)
    }

    /// How well the model that surely holds foretells a measurement.
    fn fit(&self, z: [f64; AXES], r: &Symmetric3) -> Fit {
        let of = |mode: &Gaussian| {
            let p = mode.position_covariance();
            let residual = [z[0] - mode.mean[0], z[1] - mode.mean[1]];
            association::distance::squared2(residual, [p[0] + r[0], p[1] + r[1], p[3] + r[3]])
        };
        let [steady, turning] = &self.modes;
        match self.probability[1] {
            turn if turn > SURELY_TURNING => Fit::Turning(of(turning)),
            turn if turn < SURELY_STRAIGHT => Fit::Straight(of(steady)),
            _ => Fit::Undecided,
        }
    }

    /// The first source that observes height has come.
    fn begin_height(&mut self, height_m: f64, variance_m2: f64) {
        const VERTICAL_SPEED_M2PS2: f64 = 400.0;
        self.has_height = true;
        for estimate in self.modes.iter_mut().chain([&mut self.estimate]) {
            estimate.replace_vertical([height_m, 0.0], [variance_m2, VERTICAL_SPEED_M2PS2]);
        }
    }
}

/// White noise over `seconds`, `factor` times as strong as `noise`.
fn noise_over(motion: &Motion, factor: f64, seconds: f64) -> [AxisNoise; AXES] {
    motion
        .turns
        .density_m2ps3
        .map(|density| AxisNoise::white(density * factor, seconds))
}
