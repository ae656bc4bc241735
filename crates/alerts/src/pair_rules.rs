//! Rules about two targets: `conflict` (both minima are violated at the same time) and `approach` (the horizontal one).
//!
//! Most pairs are far apart, so that a few comparisons of means and four standard deviations exclude them. For each of
//! the others the futures of both are compared one by one. A future is straight between the points at which one of both
//! changes its motion; on each such piece the distance is a quadratic function of time, and the difference of heights a
//! linear one, so the first violation is found exactly, however short it is.

use crate::board::Finding;
use crate::futures::{Draws, Future, Side};
use crate::settings::{AlertSettings, FOOT_M, KNOT_MPS};
use crate::target::{Target, along_ground};

use messages::{AlertKind, alert_value_bits};

/// Standard deviations within which a pair is compared.
const SIGMAS: f64 = 4.0;
/// Probability of a turn below which the pair counts as flying straight in the first comparison.
const TURN_MIN: f64 = 0.02;
/// Time between two points of a turn, seconds, and the most points of a turn.
const TURN_STEP_S: f64 = 4.0;
const TURN_STEPS_MAX: f64 = 24.0;
/// Futures after which those of a clear case are enough.
const FIRST: u32 = 32;
/// Greatest age of a state that is compared, seconds.
const AGE_MAX_S: f64 = 60.0;
/// Level above which the greater vertical minimum counts (ICAO Doc 4444, 5.3.2), metres of pressure altitude.
const HIGH_M: f64 = 41_000.0 * FOOT_M;
/// Standard deviations of its speed by which a vessel moves.
const MOVING_SIGMAS: f64 = 2.0;

/// What a rule compares.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairRule {
    distance_m: f64,
    /// Vertical minima, below and above FL 410, metres; infinite if heights do not count.
    vertical_m: [f64; 2],
    look_ahead_s: f64,
    vertical_s: f64,
    /// Speed up to which a vessel lies still, m/s; negative if none does.
    still_mps: f64,
}

/// The motion of the other target relative to the first one.
struct Relative<'a> {
    one: &'a Future,
    other: &'a Future,
    /// Time from the state's time to now, seconds.
    age_s: [f64; 2],
    /// Place at which the ground's direction counts, metres.
    middle_m: [f64; 2],
}

impl PairRule {
    pub(crate) fn of(settings: &AlertSettings) -> Self {
        let is_conflict = settings.kind.0 == AlertKind::Conflict;
        let vertical_m = |feet: f64| match is_conflict {
            true => (feet - settings.vertical_tolerance_ft).max(0.0) * FOOT_M,
            false => f64::INFINITY,
        };
        Self {
            distance_m: settings.distance_m(),
            vertical_m: [settings.vertical_ft, settings.vertical_high_ft].map(vertical_m),
            look_ahead_s: settings.look_ahead_s(),
            vertical_s: settings.vertical_look_ahead_s.s(),
            still_mps: if is_conflict {
                -1.0
            } else {
                settings.still_kn * KNOT_MPS
            },
        }
    }

    /// Distance at which a target of this speed may come to matter to one of another, metres.
    pub(crate) fn reach_m(&self, speeds_mps: f64) -> f64 {
        self.distance_m + speeds_mps * self.look_ahead_s
    }

    fn is_still(&self, target: &Target) -> bool {
        target.speed_mps()
            <= self
                .still_mps
                .max(MOVING_SIGMAS * target.speed_sigma_mps() * f64::from(self.still_mps >= 0.0))
    }

    /// Judges a pair at a time; `None` if nothing is ahead.
    pub(crate) fn judge(&self, one: &Target, other: &Target, now_ns: i64, work: &mut PairWork) -> Option<Finding> {
        let age_s = [one, other].map(|target| (now_ns - target.time_ns) as f64 * 1e-9);
        if age_s.iter().any(|age_s| *age_s > AGE_MAX_S) {
            return None;
        }
        let needs_heights = self.vertical_m[0].is_finite();
        if needs_heights && (one.height.is_none() || other.height.is_none()) {
            return None;
        }
        let still = [one, other].map(|target| self.still_mps >= 0.0 && self.is_still(target));
        if still == [true, true] {
            return None;
        }
        let is_high = [one, other]
            .iter()
            .any(|target| target.pressure_altitude_m().is_some_and(|m| m > HIGH_M));
        let vertical_m = self.vertical_m[usize::from(is_high)];
        let middle_m = [0, 1].map(|axis| 0.5 * (one.place_m[axis] + other.place_m[axis]));
        let means = [(one, still[0]), (other, still[1])].map(|(target, still)| {
            let mean = Future::mean(target, self.vertical_s);
            if still { mean.still() } else { mean }
        });
        let mean = Relative {
            one: &means[0],
            other: &means[1],
            age_s,
            middle_m,
        };
        if !self.is_near(&mean, one, other, vertical_m) {
            return None;
        }
        let limits = (self.distance_m, vertical_m);
        let now = mean.first_violation(limits, 0.0, &mut work.times);
        let (mut violations, mut sum_s) = (0u32, 0.0);
        let others = work.draws.futures(Side::Other, other, self.vertical_s);
        let ones = work.draws.futures(Side::One, one, self.vertical_s);
        let mut count = 0u32;
        for (of_one, of_other) in ones.zip(others) {
            // The rest of a pair whose futures agree so far would not change what follows from them.
            if count == FIRST && (violations == 0 || violations == FIRST) {
                break;
            }
            count += 1;
            let relative = Relative {
                one: &if still[0] { of_one.still() } else { of_one },
                other: &if still[1] { of_other.still() } else { of_other },
                age_s,
                middle_m,
            };
            if let Some(time_s) = relative.first_violation(limits, self.look_ahead_s, &mut work.times) {
                violations += 1;
                sum_s += time_s;
            }
        }
        if violations == 0 && now.is_none() {
            return None;
        }
        let closest = mean.closest(self.look_ahead_s, &mut work.times);
        let present = mean.at(0.0);
        let has_happened = now.is_some();
        Some(Finding {
            probability: match has_happened {
                true => 1.0,
                false => f64::from(violations) / f64::from(count),
            },
            time_to_s: if has_happened {
                0.0
            } else {
                sum_s / f64::from(violations.max(1))
            },
            distance_m: present.0[0].hypot(present.0[1]),
            least_distance_m: closest.0,
            vertical_m: present.1.abs(),
            least_vertical_m: closest.1.abs(),
            valid: alert_value_bits::DISTANCE
                | if needs_heights { alert_value_bits::VERTICAL } else { 0 }
                | if has_happened { 0 } else { alert_value_bits::PREDICTED },
            ..Finding::default()
        })
    }

    /// Whether the minima may be violated, by means and standard deviations.
    fn is_near(&self, mean: &Relative<'_>, one: &Target, other: &Target, vertical_m: f64) -> bool {
        let sigma_m = one.place_sigma_m().hypot(other.place_sigma_m());
        let sigma_mps = one.velocity_sigma_mps().hypot(other.velocity_sigma_mps());
        let ahead_s = self.look_ahead_s;
        let (from_m, from_height_m) = mean.at(0.0);
        let distance_m = from_m[0].hypot(from_m[1]);
        let speeds_mps = one.speed_mps() + other.speed_mps();
        let limit_m = self.distance_m + SIGMAS * sigma_m;
        if distance_m > limit_m + (speeds_mps + SIGMAS * sigma_mps) * ahead_s {
            return false;
        }
        if vertical_m.is_finite() {
            let [low, high] = [one, other].map(|target| target.height.map_or([0.0; 3], |height| height.covariance));
            let (sigma2_m2, sigma2_mps2) = (low[0] + high[0], low[2] + high[2]);
            let vertical_s = self.vertical_s.min(ahead_s);
            let climb_m = (mean.one.height_m(self.vertical_s) - mean.other.height_m(self.vertical_s)
                + mean.other.height_m(0.0)
                - mean.one.height_m(0.0))
            .abs();
            let margin_m = SIGMAS * (sigma2_m2.max(0.0).sqrt() + sigma2_mps2.max(0.0).sqrt() * vertical_s);
            if from_height_m.abs() > vertical_m + climb_m + margin_m {
                return false;
            }
        }
        if [one, other].iter().any(|target| target.turn_probability >= TURN_MIN) {
            return true;
        }
        let to_m = mean.at(ahead_s).0;
        let (closest_m, share) = least_distance(from_m, to_m);
        closest_m <= limit_m + SIGMAS * sigma_mps * share * ahead_s
    }
}

/// What judging of pairs needs again and again.
#[derive(Clone, Debug)]
pub(crate) struct PairWork {
    pub(crate) draws: Draws,
    times: Vec<f64>,
}

impl PairWork {
    pub(crate) fn new() -> Self {
        Self {
            draws: Draws::new(),
            times: Vec::new(),
        }
    }
}

impl Relative<'_> {
    /// Vector from the first target to the other one along the ground, and the difference of heights, metres, after a
    /// time from now.
    fn at(&self, time_s: f64) -> ([f64; 2], f64) {
        let [one_s, other_s] = self.age_s.map(|age_s| age_s + time_s);
        let (from, to) = (self.one.place_m(one_s), self.other.place_m(other_s));
        let vector = along_ground(self.middle_m, [to[0] - from[0], to[1] - from[1]]);
        (vector, self.other.height_m(other_s) - self.one.height_m(one_s))
    }

    /// Puts the times between which both move straight into `times`, seconds from now.
    fn pieces(&self, until_s: f64, times: &mut Vec<f64>) {
        times.clear();
        times.extend([0.0, until_s]);
        for (future, age_s) in [(self.one, self.age_s[0]), (self.other, self.age_s[1])] {
            times.push(future.climb_end_s() - age_s);
            let turn_s = (future.turn_end_s() - age_s).min(until_s);
            if turn_s > 0.0 {
                let step_s = TURN_STEP_S.max(turn_s / TURN_STEPS_MAX);
                let steps = (turn_s / step_s).ceil() as usize;
                times.extend((1..=steps).map(|step| (step as f64 * step_s).min(turn_s)));
            }
        }
        times.retain(|time_s| (0.0..=until_s).contains(time_s));
        times.sort_unstable_by(f64::total_cmp);
    }

    /// First time within which both limits are violated, seconds from now.
    fn first_violation(&self, limits: (f64, f64), until_s: f64, times: &mut Vec<f64>) -> Option<f64> {
        let mut from = self.at(0.0);
        if is_violated(from, limits) {
            return Some(0.0);
        }
        self.pieces(until_s, times);
        for piece in times.windows(2) {
            let length_s = piece[1] - piece[0];
            if length_s <= 0.0 {
                continue;
            }
            let to = self.at(piece[1]);
            if let Some(share) = first_share(from, to, limits) {
                return Some(piece[0] + share * length_s);
            }
            from = to;
        }
        None
    }

    /// Least distance along the ground within a time, and the difference of heights then, metres.
    fn closest(&self, until_s: f64, times: &mut Vec<f64>) -> (f64, f64) {
        let mut from = self.at(0.0);
        let mut least = (from.0[0].hypot(from.0[1]), from.1);
        self.pieces(until_s, times);
        for piece in times.windows(2) {
            let to = self.at(piece[1]);
            let (distance_m, share) = least_distance(from.0, to.0);
            if distance_m < least.0 {
                least = (distance_m, from.1 + share * (to.1 - from.1));
            }
            from = to;
        }
        least
    }
}

fn is_violated((vector, height_m): ([f64; 2], f64), (distance_m, vertical_m): (f64, f64)) -> bool {
    vector[0].hypot(vector[1]) < distance_m && height_m.abs() < vertical_m
}

/// Least distance from the origin of a straight way between two points, and the share of the way to it.
fn least_distance(from: [f64; 2], to: [f64; 2]) -> (f64, f64) {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length2 = way[0] * way[0] + way[1] * way[1];
    let share = match length2 > 0.0 {
        true => (-(from[0] * way[0] + from[1] * way[1]) / length2).clamp(0.0, 1.0),
        false => 0.0,
    };
    ((from[0] + share * way[0]).hypot(from[1] + share * way[1]), share)
}

/// Share of a piece, on which both differences change linearly, from which on both limits are violated.
fn first_share(from: ([f64; 2], f64), to: ([f64; 2], f64), (distance_m, vertical_m): (f64, f64)) -> Option<f64> {
    let way = [to.0[0] - from.0[0], to.0[1] - from.0[1]];
    // |from + s·way|² = distance²
    let a = way[0] * way[0] + way[1] * way[1];
    let half_b = from.0[0] * way[0] + from.0[1] * way[1];
    let c = from.0[0] * from.0[0] + from.0[1] * from.0[1] - distance_m * distance_m;
    let horizontal = match a > 0.0 {
        true => {
            let discriminant = half_b * half_b - a * c;
            if discriminant <= 0.0 {
                return None;
            }
            let root = discriminant.sqrt();
            [(-half_b - root) / a, (-half_b + root) / a]
        }
        false if c < 0.0 => [0.0, 1.0],
        false => return None,
    };
    let climb_m = to.1 - from.1;
    let vertical = if climb_m == 0.0 || vertical_m.is_infinite() {
        match from.1.abs() < vertical_m {
            true => [0.0, 1.0],
            false => return None,
        }
    } else {
        let ends = [(-vertical_m - from.1) / climb_m, (vertical_m - from.1) / climb_m];
        [ends[0].min(ends[1]), ends[0].max(ends[1])]
    };
    let first = horizontal[0].max(vertical[0]).max(0.0);
    let last = horizontal[1].min(vertical[1]).min(1.0);
    (first < last).then_some(first)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::futures::tests::{frame, state};

    fn conflict() -> PairRule {
        PairRule::of(&AlertSettings::default())
    }

    fn judge(rule: &PairRule, one: &messages::SystemTrack, other: &messages::SystemTrack) -> Option<Finding> {
        let [one, other] = [one, other].map(|track| Target::of(track, &frame()).unwrap());
        rule.judge(&one, &other, 0, &mut PairWork::new())
    }

    #[test]
    fn two_that_meet_head_on_have_the_time_of_the_first_violation() {
        let one = state(1, [-40_000.0, 0.0, 10_000.0], [200.0, 0.0, 0.0], [20.0, 0.5]);
        let other = state(2, [40_000.0, 3_000.0, 10_000.0], [-200.0, 0.0, 0.0], [20.0, 0.5]);
        // 9,260 m apart while 3,000 m beside each other: 8,761 m along the way of 80 km at 400 m/s.
        let expected_s = (80_000.0 - (9_260.0f64.powi(2) - 3_000.0f64.powi(2)).sqrt()) / 400.0;
        assert!(expected_s > 125.0 && judge(&conflict(), &one, &other).is_none_or(|found| found.probability < 0.1));
        let nearer = state(1, [-6_000.0, 0.0, 10_000.0], [200.0, 0.0, 0.0], [20.0, 0.5]);
        let found = judge(&conflict(), &nearer, &other).unwrap();
        let expected_s = expected_s - 34_000.0 / 400.0;
        assert!(
            found.probability == 1.0 && (found.time_to_s - expected_s).abs() < 1.0,
            "{found:?} {expected_s}"
        );
        assert!(
            (found.least_distance_m - 3_000.0).abs() < 30.0 && found.least_vertical_m < 130.0,
            "{found:?}"
        );
    }

    #[test]
    fn a_thousand_feet_apart_is_no_conflict_and_two_thousand_are_needed_above_flight_level_410() {
        let at = |height_m: f64, number| state(number, [0.0, 0.0, height_m], [200.0, 0.0, 0.0], [20.0, 0.5]);
        assert!(judge(&conflict(), &at(9_000.0, 1), &at(9_304.8, 2)).is_none_or(|found| found.probability < 0.5));
        let found = judge(&conflict(), &at(9_000.0, 1), &at(9_240.0, 2)).unwrap();
        assert_eq!((found.probability, found.time_to_s), (1.0, 0.0));
        let found = judge(&conflict(), &at(12_600.0, 1), &at(13_000.0, 2)).unwrap();
        assert_eq!(found.probability, 1.0);
    }

    #[test]
    fn an_uncertain_velocity_makes_an_uncertain_conflict() {
        let one = state(1, [0.0, 0.0, 9_000.0], [0.0; 3], [20.0, 0.5]);
        // Passes 12 km beside; 80 s ahead, 46 m/s across are needed.
        let mut other = state(2, [-20_000.0, 12_000.0, 9_000.0], [250.0, 0.0, 0.0], [20.0, 50.0]);
        other.covariance.set(5, 5, 0.25);
        let found = judge(&conflict(), &one, &other).unwrap();
        assert!((0.1..0.5).contains(&found.probability), "{found:?}");
        let steady = state(2, [-20_000.0, 12_000.0, 9_000.0], [250.0, 0.0, 0.0], [20.0, 0.5]);
        assert!(judge(&conflict(), &one, &steady).is_none());
    }

    #[test]
    fn a_climb_counts_for_the_vertical_look_ahead_only() {
        let one = state(1, [0.0, 0.0, 9_000.0], [200.0, 0.0, 0.0], [5.0, 0.2]);
        let below = |height_m| state(2, [0.0, 1_000.0, height_m], [200.0, 0.0, 10.0], [5.0, 0.2]);
        // 400 m below, it needs 12.6 s to come within 274 m; 600 m below, 33 s.
        let found = judge(&conflict(), &one, &below(8_600.0)).unwrap();
        assert!(
            found.probability > 0.9 && (found.time_to_s - 12.6).abs() < 2.0,
            "{found:?}"
        );
        assert!(judge(&conflict(), &one, &below(8_400.0)).is_none_or(|found| found.probability < 0.1));
    }

    #[test]
    fn vessels_that_lie_still_do_not_approach_each_other() {
        let rule = PairRule::of(&AlertSettings {
            kind: crate::settings::Kind(AlertKind::Approach),
            ..AlertSettings::default()
        });
        let vessel = |number, x, speed| {
            let mut track = state(number, [x, 0.0, 0.0], [speed, 0.0, 0.0], [5.0, 0.1]);
            track.identity = messages::Identity::default().with_mmsi(211_000_000 + number);
            track.height_valid = 0;
            track
        };
        assert!(judge(&rule, &vessel(1, 0.0, 0.2), &vessel(2, 500.0, -0.2)).is_none());
        let found = judge(&rule, &vessel(1, 0.0, 0.2), &vessel(2, 3_000.0, -5.0)).unwrap();
        let expected_s = (3_000.0 - 926.0) / 5.0;
        assert!(
            found.probability == 1.0 && (found.time_to_s - expected_s).abs() < 10.0,
            "{found:?}"
        );
    }

    proptest! {
        /// The exact search finds what steps of a hundredth find, and nothing else.
        #[test]
        fn the_first_violation_is_that_of_small_steps(
            from in [-2.0f64..2.0, -2.0..2.0], to in [-2.0f64..2.0, -2.0..2.0], heights in [-3.0f64..3.0, -3.0..3.0],
        ) {
            let limits = (1.0, 1.0);
            let at = |share: f64| {
                let place = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
                (place, heights[0] + share * (heights[1] - heights[0]))
            };
            let stepped = (0..=1000).map(|step| f64::from(step) * 1e-3).find(|share| is_violated(at(*share), limits));
            let exact = first_share(at(0.0), at(1.0), limits);
            match (stepped, exact) {
                (Some(stepped), Some(exact)) => prop_assert!((stepped - exact).abs() <= 1.1e-3, "{stepped} {exact}"),
                (Some(stepped), None) => prop_assert!(false, "missed at {stepped}"),
                (None, Some(exact)) => prop_assert!(is_violated(at(exact + 1e-9), (1.0 + 1e-6, 1.0 + 1e-6)), "{exact}"),
                (None, None) => {}
            }
        }
    }
}
