//! Motion models of targets: steady flight and manoeuvres (HT-13).
//!
//! By default a target flies straight, disturbed by a weak white-noise acceleration. A filter with this assumption
//! alone loses turning targets; a filter with strong noise has wide gates, takes in more clutter and smooths less.
//! Therefore two filters run side by side, one for steady flight and one for manoeuvres with a stronger noise. Each
//! detection weighs both filters by likelihood (interacting multiple models). A detection's likelihood is the weighted
//! sum of both; the detection is in the gate if it is in the gate of either.
//!
//! Limit: a long turn is followed as a manoeuvre of unknown direction, not as a circle, unless coordinated turns are
//! configured ([`crate::turn`]).
//!
//! Source: H. A. P. Blom, Y. Bar-Shalom, *The interacting multiple model algorithm for systems with Markovian switching
//! coefficients*, IEEE Transactions on Automatic Control 33 (1988).

use estimation::{AxisNoise, Gaussian};
use kept::{Get, Kept, Put, kept};
use messages::{AXES, STATE_LEN};

use crate::initiation::{Initiation, first_state};
use crate::log_sum::log_add;
use crate::measurement::{DetectionMeasurement, MeasurementInnovation, middle};
use crate::turn::{TurnRate, TurnSettings};

/// Least part of the accelerations that slow targets have.
const SLOW_SHARE_MIN: f64 = 0.1;
/// Smallest probability of a model: the probability must be able to rise again.
const PROBABILITY_MIN: f64 = 1e-3;

settings::settings! {
    /// Models of motion (HT-13).
    #[derive(Copy)]
    pub struct MotionSettings {
        /// Spectral density of the accelerations in steady flight: horizontal, vertical.
        process_noise_m2ps3: [f64; 2] = [5.0, 1.0], in [1e-9, 1e6];
        /// Speed below which the horizontal accelerations of both models are weaker, with the square of the speed and
        /// at least a tenth in spectral density: boats do not accelerate like aircraft. Uncertain speeds count as fast.
        slow_mps: Option<f64> = Some(20.0), in [1e-3, 1e3];
        /// Second model, of manoeuvring targets.
        manoeuvres: ManoeuvreSettings = ManoeuvreSettings::default();
    }

    /// Model of targets that manoeuvre.
    #[derive(Copy)]
    pub struct ManoeuvreSettings {
        /// Whether the tracker uses this model.
        enabled: bool = true;
        /// Spectral density of the accelerations: horizontal, vertical.
        process_noise_m2ps3: [f64; 2] = [100.0, 10.0], in [1e-9, 1e6];
        /// Mean durations of steady flight and of a manoeuvre.
        durations_s: [f64; 2] = [60.0, 10.0], in [1e-3, 1e6];
        /// Model of coordinated turns in addition. Without this model, a manoeuvre is a random acceleration in any
        /// direction.
        turn: Option<TurnSettings> = None;
    }
}

impl MotionSettings {
    /// Spectral density of the accelerations of a target in this state: horizontal, vertical; `of_fast` is that of fast
    /// targets.
    fn noise_at(&self, state: &Gaussian, of_fast: [f64; 2]) -> [f64; 2] {
        let [horizontal, vertical] = of_fast;
        let Some(slow_mps) = self.slow_mps else {
            return [horizontal, vertical];
        };
        let speed2 = [AXES, AXES + 1].map(|row| state.mean[row].powi(2) + state.covariance.get(row, row));
        let share = (speed2[0] + speed2[1]) / (slow_mps * slow_mps);
        [horizontal * share.clamp(SLOW_SHARE_MIN, 1.0), vertical]
    }

    /// The model of targets that manoeuvre; `None` if there is none.
    pub(crate) fn manoeuvres(&self) -> Option<&ManoeuvreSettings> {
        Some(&self.manoeuvres).filter(|manoeuvres| manoeuvres.enabled)
    }
}

kept! {
    /// Position and velocity of a target by each model.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct TargetMotion {
        steady: Gaussian,
        /// Manoeuvring state; equal to the steady state without a manoeuvring model.
        turning: Gaussian,
        /// Turn rate of the turning model; [`TurnRate::NONE`] where there are no coordinated turns.
        turn: TurnRate,
        /// Probability of a manoeuvre; 0 without a manoeuvring model.
        turning_probability: f64,
        speed: SpeedKnowledge,
    }
}

/// Meaning of the two states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SpeedKnowledge {
    /// Steady flight and manoeuvre.
    Known,
    /// A slow and a fast target, seen once.
    Unknown,
    /// The same, seen a second time.
    Found,
}

impl Kept for SpeedKnowledge {
    const WORDS: usize = 1;

    fn put(&self, to: &mut Put<'_>) {
        to.word(*self as u64);
    }

    fn get(from: &mut Get<'_>) -> Option<Self> {
        let all = [Self::Known, Self::Unknown, Self::Found];
        all.get(usize::try_from(from.word()?).ok()?).copied()
    }
}

impl TargetMotion {
    /// After a first measurement; `None` of a direction alone.
    pub(crate) fn first(
        measurement: &DetectionMeasurement,
        guess: &Initiation,
        settings: &MotionSettings,
    ) -> Option<Self> {
        let fast = first_state(measurement, guess)?;
        let begun = Self::begun(fast, settings);
        let Some(speed_sigma_mps) = guess.slow_sigma_mps.filter(|_| settings.manoeuvres.enabled) else {
            return Some(begun);
        };
        let slow = Initiation {
            speed_sigma_mps,
            ..*guess
        };
        Some(Self {
            steady: first_state(measurement, &slow)?,
            turning_probability: 0.5,
            speed: SpeedKnowledge::Unknown,
            ..begun
        })
    }

    /// Begins with the same state in both models.
    pub(crate) fn begun(state: Gaussian, settings: &MotionSettings) -> Self {
        let prior = |manoeuvres: &ManoeuvreSettings| {
            let [steady_s, turning_s] = manoeuvres.durations_s;
            turning_s / (steady_s + turning_s)
        };
        Self {
            steady: state,
            turning: state,
            turn: settings
                .manoeuvres()
                .and_then(|manoeuvres| manoeuvres.turn)
                .map_or(TurnRate::NONE, |turn| TurnRate::begun(&turn)),
            turning_probability: settings.manoeuvres().map_or(0.0, prior),
            speed: SpeedKnowledge::Known,
        }
    }

    /// `seconds` later, or earlier.
    pub(crate) fn moved(&self, seconds: f64, settings: &MotionSettings) -> Self {
        let Some(manoeuvres) = settings.manoeuvres() else {
            let steady = self.steady.moved(
                seconds,
                noise(settings.noise_at(&self.steady, settings.process_noise_m2ps3), seconds),
            );
            return Self { steady, ..*self };
        };
        match self.speed {
            SpeedKnowledge::Known => (),
            // A target does not become slow or fast.
            SpeedKnowledge::Unknown => {
                let noise = noise(settings.process_noise_m2ps3, seconds);
                return Self {
                    steady: self.steady.moved(seconds, noise),
                    turning: self.turning.moved(seconds, noise),
                    ..*self
                };
            }
            SpeedKnowledge::Found => return Self::begun(self.estimate(), settings).moved(seconds, settings),
        }
        // Targets may have begun or ended to manoeuvre.
        let [steady_s, turning_s] = manoeuvres.durations_s;
        let time = seconds.abs();
        let (p, q) = (1.0 - self.turning_probability, self.turning_probability);
        let (begins, ends) = (p * time / (time + steady_s), q * time / (time + turning_s));
        let (steady, turning) = (p - begins + ends, q - ends + begins);
        let mixed = |from_turning: f64| Gaussian::mixture(&self.steady, &self.turning, from_turning);
        let (straight, still) = (mixed(ends / steady), (q - ends) / turning);
        let moved = |state: Gaussian, of_fast| state.moved(seconds, noise(settings.noise_at(&state, of_fast), seconds));
        let (turned, turn) = match &manoeuvres.turn {
            None => (moved(mixed(still), manoeuvres.process_noise_m2ps3), self.turn),
            Some(turn) => {
                let state = mixed(still);
                let density = settings.noise_at(&state, manoeuvres.process_noise_m2ps3);
                self.turned(state, still, seconds, density, turn)
            }
        };
        Self {
            steady: moved(straight, settings.process_noise_m2ps3),
            turning: turned,
            turn,
            turning_probability: turning,
            speed: SpeedKnowledge::Known,
        }
    }

    /// Moves the turning state along the circle; `still` is the part that was turning before.
    fn turned(
        &self,
        mut state: Gaussian,
        still: f64,
        seconds: f64,
        density_m2ps3: [f64; 2],
        turn: &TurnSettings,
    ) -> (Gaussian, TurnRate) {
        let begun = TurnRate::begun(turn);
        let mut rate = TurnRate::mixture((&begun, &self.steady), (&self.turn, &self.turning), still);
        rate.turn(&mut state, seconds, turn);
        (state.moved(0.0, noise(density_m2ps3, seconds)), rate)
    }

    /// Compares with a measurement: the smaller distance, and the density by both models.
    pub(crate) fn innovation(&self, measurement: &DetectionMeasurement) -> Option<MeasurementInnovation> {
        let steady = measurement.innovation(&self.steady);
        if self.turning_probability == 0.0 {
            return steady;
        }
        both(
            steady?,
            measurement.innovation(&self.turning)?,
            self.turning_probability,
        )
    }

    /// Updates with a measurement; `None`, and no change, if that cannot be done in numbers.
    pub(crate) fn update(&mut self, measurement: &DetectionMeasurement) -> Option<MeasurementInnovation> {
        let mut updated = *self;
        let steady = measurement.update(&mut updated.steady)?;
        let innovation = if self.turning_probability == 0.0 {
            steady
        } else {
            let turning = if self.turn == TurnRate::NONE {
                measurement.update(&mut updated.turning)?
            } else {
                measurement.update_turning(&mut updated.turning, &mut updated.turn)?
            };
            let innovation = both(steady, turning, self.turning_probability)?;
            let share = self.turning_probability.ln() + turning.log_likelihood - innovation.log_likelihood;
            if updated.speed == SpeedKnowledge::Unknown {
                updated.speed = SpeedKnowledge::Found;
            }
            updated.turning_probability = share.exp().clamp(PROBABILITY_MIN, 1.0 - PROBABILITY_MIN);
            innovation
        };
        *self = updated;
        Some(innovation)
    }

    /// The motion of a target that leaves a target of this motion: manoeuvring as likely as not, and for the mean
    /// duration of a manoeuvre.
    pub(crate) fn leaving(mut self, settings: &MotionSettings) -> Self {
        let Some(manoeuvres) = settings.manoeuvres() else {
            return self;
        };
        let [horizontal, vertical] = manoeuvres.process_noise_m2ps3;
        for (axis, density) in [horizontal, horizontal, vertical].into_iter().enumerate() {
            let row = AXES + axis;
            let variance = self.turning.covariance.get(row, row) + density * manoeuvres.durations_s[1];
            self.turning.covariance.set(row, row, variance);
        }
        self.turning_probability = self.turning_probability.max(0.5);
        self
    }

    /// The motion of a target that has left a target of this motion [like this](Self::leaving), `seconds` ago: since
    /// then, the change of velocity has moved the leaving target in the plane.
    pub(crate) fn left(self, seconds: f64, settings: &MotionSettings) -> Self {
        let mut left = self.leaving(settings);
        for row in 0..AXES - 1 {
            let covariance = &mut left.turning.covariance;
            let [place, both, velocity] = [(row, row), (row, AXES + row), (AXES + row, AXES + row)];
            let [of_place, of_both, of_velocity] =
                [place, both, velocity].map(|(row, column)| covariance.get(row, column));
            let change = of_velocity - self.turning.covariance.get(velocity.0, velocity.1);
            covariance.set(place.0, place.1, of_place + change * seconds * seconds);
            covariance.set(both.0, both.1, of_both + change * seconds);
        }
        left
    }

    /// The place between two targets, model by model.
    pub(crate) fn middle(one: &Self, other: &Self) -> Self {
        Self {
            steady: middle(&one.steady, &other.steady),
            turning: middle(&one.turning, &other.turning),
            turning_probability: 0.5 * (one.turning_probability + other.turning_probability),
            ..*one
        }
    }

    /// Updates with a detection between this and another target; `None`, and no change, if that cannot be done in
    /// numbers.
    pub(crate) fn update_half(&mut self, other: &Self, measurement: &DetectionMeasurement) -> Option<()> {
        let (mut updated, other) = (*self, other.estimate());
        let steady = measurement.update_half(&mut updated.steady, &other)?;
        if self.turning_probability > 0.0 {
            let turning = measurement.update_half(&mut updated.turning, &other)?;
            let innovation = both(steady, turning, self.turning_probability)?;
            let share = self.turning_probability.ln() + turning.log_likelihood - innovation.log_likelihood;
            updated.turning_probability = share.exp().clamp(PROBABILITY_MIN, 1.0 - PROBABILITY_MIN);
        }
        *self = updated;
        Some(())
    }

    /// Lets all standard deviations be larger by a factor.
    pub(crate) fn widen(&mut self, factor: f64) {
        for state in [&mut self.steady, &mut self.turning] {
            state
                .covariance
                .upper
                .iter_mut()
                .for_each(|element| *element *= factor * factor);
        }
    }

    /// Mixture of both models.
    pub(crate) fn estimate(&self) -> Gaussian {
        if self.turning_probability == 0.0 {
            return self.steady;
        }
        Gaussian::mixture(&self.steady, &self.turning, self.turning_probability)
    }

    /// Mean of both models together.
    pub(crate) fn mean(&self) -> [f64; STATE_LEN] {
        let (p, q) = (1.0 - self.turning_probability, self.turning_probability);
        std::array::from_fn(|place| p * self.steady.mean[place] + q * self.turning.mean[place])
    }

    /// State of the wider model, used for the position in the plane, with variances and covariance.
    pub(crate) fn widest(&self) -> &Gaussian {
        if self.turning_probability == 0.0 {
            &self.steady
        } else {
            &self.turning
        }
    }

    /// Mixture of two motions with the given weight of the second, model by model.
    pub(crate) fn mixture(a: &Self, b: &Self, weight_of_b: f64) -> Self {
        let weight = |of_a: f64, of_b: f64| {
            let (of_a, of_b) = (of_a * (1.0 - weight_of_b), of_b * weight_of_b);
            if of_a + of_b > 0.0 {
                of_b / (of_a + of_b)
            } else {
                weight_of_b
            }
        };
        let (p, q) = (a.turning_probability, b.turning_probability);
        Self {
            steady: Gaussian::mixture(&a.steady, &b.steady, weight(1.0 - p, 1.0 - q)),
            turning: Gaussian::mixture(&a.turning, &b.turning, weight(p, q)),
            turn: if a.turn == TurnRate::NONE {
                TurnRate::NONE
            } else {
                TurnRate::mixture((&a.turn, &a.turning), (&b.turn, &b.turning), weight(p, q))
            },
            turning_probability: p * (1.0 - weight_of_b) + q * weight_of_b,
            speed: if a.speed == b.speed {
                a.speed
            } else {
                SpeedKnowledge::Found
            },
        }
    }
}

pub(crate) fn noise(density_m2ps3: [f64; 2], seconds: f64) -> [AxisNoise; 3] {
    let [horizontal, vertical] = density_m2ps3.map(|density| AxisNoise::white(density, seconds));
    [horizontal, horizontal, vertical]
}

fn both(
    steady: MeasurementInnovation,
    turning: MeasurementInnovation,
    turning_probability: f64,
) -> Option<MeasurementInnovation> {
    let of_steady = (1.0 - turning_probability).ln() + steady.log_likelihood;
    let of_turning = turning_probability.ln() + turning.log_likelihood;
    Some(MeasurementInnovation {
        dimension: steady.dimension,
        squared_distance: steady.squared_distance.min(turning.squared_distance),
        log_likelihood: log_add(of_steady, of_turning),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::position;

    const TWO_MODELS: MotionSettings = MotionSettings {
        slow_mps: None,
        process_noise_m2ps3: [0.1, 0.1],
        manoeuvres: ManoeuvreSettings {
            enabled: true,
            process_noise_m2ps3: [50.0, 1.0],
            durations_s: [60.0, 10.0],
            turn: None,
        },
    };
    const ONE_MODEL: MotionSettings = MotionSettings {
        manoeuvres: ManoeuvreSettings {
            enabled: false,
            ..TWO_MODELS.manoeuvres
        },
        ..TWO_MODELS
    };

    /// Flown east at 50 m/s for 20 s, then round by 9° each second. Returns whether every detection was in the gate,
    /// and the probabilities of a manoeuvre before and during the turn.
    fn flown(settings: &MotionSettings) -> (bool, f64, f64) {
        let guess = Initiation {
            new_target_share: 0.04,
            speed_sigma_mps: 50.0,
            slow_sigma_mps: None,
            climb_sigma_mps: 1.0,
            height_sigma_m: 100.0,
            crossing_s: None,
            crossing_detections: 10,
        };
        let (mut place, mut course) = ([0.0, 0.0], 0.0f64);
        let measured = |[east, north]: [f64; 2]| DetectionMeasurement::of(&position(0, east, north), None).unwrap();
        let mut motion = TargetMotion::begun(first_state(&measured(place), &guess).unwrap(), settings);
        let (mut all_in_gate, mut before) = (true, 0.0);
        for second in 0..26 {
            if second >= 20 {
                course += 9f64.to_radians();
            } else {
                before = motion.turning_probability;
            }
            place = [place[0] + 50.0 * course.cos(), place[1] - 50.0 * course.sin()];
            motion = motion.moved(1.0, settings);
            let compared = motion.innovation(&measured(place)).unwrap();
            assert_eq!(motion.update(&measured(place)).unwrap(), compared);
            assert!(estimation::is_usable(&motion.estimate().covariance));
            all_in_gate &= compared.squared_distance < 9.21;
        }
        (all_in_gate, before, motion.turning_probability)
    }

    #[test]
    fn a_turn_is_noticed_and_followed() {
        let (followed, before, turning) = flown(&TWO_MODELS);
        assert!(
            followed && before < 0.1 && turning > 0.8,
            "{followed} {before} {turning}"
        );
        let (followed, ..) = flown(&ONE_MODEL);
        assert!(!followed, "the turn is too much for steady flight");
    }

    /// Mean squared prediction error in the last 15 s of a long circle.
    fn circled(turn: Option<TurnSettings>) -> f64 {
        let mut settings = TWO_MODELS;
        settings.manoeuvres.turn = turn;
        let guess = Initiation {
            new_target_share: 0.04,
            speed_sigma_mps: 50.0,
            slow_sigma_mps: None,
            climb_sigma_mps: 1.0,
            height_sigma_m: 100.0,
            crossing_s: None,
            crossing_detections: 10,
        };
        let at = |second: usize| {
            let (sin, cos) = (0.1 * second as f64).sin_cos();
            DetectionMeasurement::of(&position(0, 500.0 * cos, 500.0 * sin), None).unwrap()
        };
        let mut motion = TargetMotion::begun(first_state(&at(0), &guess).unwrap(), &settings);
        let mut sum = 0.0;
        for second in 1..=30 {
            motion = motion.moved(1.0, &settings);
            let expected = motion.estimate().mean;
            let measured = at(second).values;
            motion.update(&at(second)).unwrap();
            assert!(estimation::is_usable(&motion.turning.covariance), "{second}");
            if second > 15 {
                sum += (expected[0] - measured[0]).powi(2) + (expected[1] - measured[1]).powi(2);
            }
        }
        assert!(
            turn.is_none() || (motion.turn.rate - 0.1).abs() < 0.02,
            "{:?}",
            motion.turn
        );
        sum / 15.0
    }

    #[test]
    fn a_coordinated_turn_is_followed_on_its_circle() {
        let turn = TurnSettings {
            rate_sigma_radps: 0.1,
            rate_noise_rad2ps3: 1e-4,
        };
        let (straight, turned) = (circled(None), circled(Some(turn)));
        assert!(turned < 0.5 * straight, "{turned} {straight}");
    }

    #[test]
    fn the_second_detection_shows_how_fast_a_target_is() {
        let guess = Initiation {
            new_target_share: 0.04,
            speed_sigma_mps: 100.0,
            slow_sigma_mps: Some(5.0),
            climb_sigma_mps: 1.0,
            height_sigma_m: 100.0,
            crossing_s: None,
            crossing_detections: 10,
        };
        let seen = |second: f64, speed: f64| DetectionMeasurement::of(&position(0, speed * second, 0.0), None).unwrap();
        for (speed, fast_from, fast_to) in [(4.0, 0.0, 0.3), (80.0, 0.99, 1.0)] {
            let first = TargetMotion::first(&seen(0.0, speed), &guess, &TWO_MODELS).unwrap();
            let mut motion = first.moved(2.0, &TWO_MODELS);
            assert_eq!(motion.turning_probability, 0.5);
            let compared = motion.innovation(&seen(2.0, speed)).unwrap();
            let plain = TargetMotion::first(
                &seen(0.0, speed),
                &Initiation {
                    new_target_share: 0.04,
                    slow_sigma_mps: None,
                    ..guess
                },
                &TWO_MODELS,
            );
            let alone = plain
                .unwrap()
                .moved(2.0, &TWO_MODELS)
                .innovation(&seen(2.0, speed))
                .unwrap();
            let gain = compared.log_likelihood - alone.log_likelihood;
            assert!(if speed < 10.0 { gain > 2.0 } else { gain > -0.8 }, "{speed}: {gain}");
            motion.update(&seen(2.0, speed)).unwrap();
            let fast = motion.turning_probability;
            assert!(fast >= fast_from && fast <= fast_to, "{speed}: {fast}");
            let estimate = motion.estimate();
            assert!((estimate.mean[3] - speed).abs() < 5.0, "{:?}", estimate.mean);
            let next = motion.moved(2.0, &TWO_MODELS);
            assert!(next.turning_probability < 0.5, "from now on it is about manoeuvres");
        }
    }

    #[test]
    fn slow_targets_manoeuvre_less() {
        let settings = MotionSettings {
            slow_mps: Some(20.0),
            ..TWO_MODELS
        };
        let grown = |speed_mps: f64| {
            let state = Gaussian {
                mean: [0.0, 0.0, 0.0, speed_mps, 0.0, 0.0],
                covariance: messages::Covariance::diagonal([1.0; 3], [1e-3; 3]),
            };
            let moved = TargetMotion::begun(state, &settings).moved(1.0, &settings);
            [&moved.steady, &moved.turning].map(|state| state.covariance.get(3, 3))
        };
        for (speed_mps, share) in [(40.0, 1.0), (10.0, 0.25), (2.0, 0.1)] {
            let [steady, turning] = grown(speed_mps);
            assert!((steady - 0.1 * share).abs() < 1e-4, "{speed_mps}: {steady}");
            assert!((turning - 50.0 * share).abs() < 1e-3, "{speed_mps}: {turning}");
        }
    }

    #[test]
    fn one_model_is_the_plain_filter() {
        let guess = Initiation {
            new_target_share: 0.04,
            speed_sigma_mps: 50.0,
            slow_sigma_mps: None,
            climb_sigma_mps: 1.0,
            height_sigma_m: 100.0,
            crossing_s: None,
            crossing_detections: 10,
        };
        let measurement = DetectionMeasurement::of(&position(0, 10.0, 20.0), None).unwrap();
        let state = first_state(&measurement, &guess).unwrap();
        let mut motion = TargetMotion::begun(state, &ONE_MODEL).moved(2.0, &ONE_MODEL);
        let mut plain = state.moved(2.0, noise([0.1, 0.1], 2.0));
        assert_eq!(motion.estimate(), plain);
        assert_eq!(motion.update(&measurement), measurement.update(&mut plain));
        assert_eq!(motion.estimate(), plain);
        let same = TargetMotion::mixture(&motion, &motion, 0.3);
        assert!((same.estimate().mean[0] - plain.mean[0]).abs() < 1e-12);
    }
}
