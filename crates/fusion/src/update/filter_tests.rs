//! Tests of the system filter: turns, climbs, and that the vertical does not touch the plane.

use estimation::{Gaussian, is_usable};
use messages::{Covariance, MotionMode};
use proptest::prelude::*;
use source_models::{Measurement, Motion};
use test_support::Random;

use crate::testing::models;
use crate::update::filter::TargetFilter;

const NS: f64 = 1e9;
/// Time between two measurements, s, and their standard deviations, m.
const STEP_S: f64 = 1.2;
const SIGMA_M: f64 = 40.0;
const SIGMA_HEIGHT_M: f64 = 8.0;

/// A target and its filter.
struct Flight {
    filter: TargetFilter,
    motion: Motion,
    random: Random,
    time_s: f64,
    position_m: [f64; 3],
    speed_mps: f64,
    course_rad: f64,
}

impl Flight {
    fn new(seed: u64) -> Self {
        let mut covariance = Covariance::diagonal([SIGMA_M, SIGMA_M, SIGMA_HEIGHT_M], [10.0, 10.0, 5.0]);
        // As a radar has that measures elevations.
        covariance.set(0, 2, 0.5 * SIGMA_M * SIGMA_HEIGHT_M);
        let start = Gaussian::new([0.0, 0.0, 5000.0], [150.0, 0.0, 0.0], &covariance);
        Self {
            filter: TargetFilter::new(0, start, true),
            motion: *models(1.0).motion([150.0, 0.0, 0.0]),
            random: Random::new(seed),
            time_s: 0.0,
            position_m: [0.0, 0.0, 5000.0],
            speed_mps: 150.0,
            course_rad: 0.0,
        }
    }

    fn noise(&mut self, sigma_m: f64) -> f64 {
        // The sum of twelve has a variance of 1.
        (0..12).map(|_| self.random.between(-0.5, 0.5)).sum::<f64>() * sigma_m
    }

    /// Flies on with a lateral acceleration to the left and a rate of climb, and is measured.
    fn fly(&mut self, seconds: f64, left_mps2: f64, climb_mps: f64) {
        const PARTS: u32 = 24;
        let until_s = self.time_s + seconds;
        while self.time_s < until_s {
            for _ in 0..PARTS {
                let part_s = STEP_S / f64::from(PARTS);
                self.course_rad += left_mps2 / self.speed_mps * part_s;
                self.position_m[0] += self.speed_mps * self.course_rad.cos() * part_s;
                self.position_m[1] += self.speed_mps * self.course_rad.sin() * part_s;
                self.position_m[2] += climb_mps * part_s;
            }
            self.time_s += STEP_S;
            let [x, y, z] = self.position_m;
            let position_m = [
                x + self.noise(SIGMA_M),
                y + self.noise(SIGMA_M),
                z + self.noise(SIGMA_HEIGHT_M),
            ];
            self.take(position_m);
        }
    }

    fn take(&mut self, position_m: [f64; 3]) {
        let (r, height) = (SIGMA_M * SIGMA_M, SIGMA_HEIGHT_M * SIGMA_HEIGHT_M);
        let measurement = Measurement {
            position_m,
            covariance_m2: [r, 0.0, 0.0, r, 0.0, height],
            axes: 3,
            has_waited: false,
        };
        let time_ns = (self.time_s * NS) as i64;
        self.filter
            .take(&measurement, time_ns, &self.motion, true)
            .expect("usable");
    }

    fn probability(&self, mode: MotionMode) -> f32 {
        self.filter.mode_probabilities()[mode as usize]
    }

    fn error_m(&self) -> f64 {
        let [x, y, _] = self.filter.estimate.position_m();
        (x - self.position_m[0]).hypot(y - self.position_m[1])
    }
}

/// Mean over some flights.
fn mean(of: impl Fn(u64) -> f64) -> f64 {
    (1..=20).map(of).sum::<f64>() / 20.0
}

#[test]
fn turns_to_either_side_are_recognised_followed_and_left() {
    for side in [1.0, -1.0] {
        let (mode, other) = if side > 0.0 {
            (MotionMode::LeftTurn, MotionMode::RightTurn)
        } else {
            (MotionMode::RightTurn, MotionMode::LeftTurn)
        };
        let mut straight = [0.0; 2];
        for seed in 1..=20 {
            let mut flight = Flight::new(seed);
            flight.fly(60.0, 0.0, 0.0);
            straight[0] += flight.probability(MotionMode::Steady) / 20.0;
            flight.fly(18.0, 6.0 * side, 0.0);
            assert!(
                flight.probability(mode) > 5.0 * flight.probability(other),
                "seed {seed}"
            );
            let sum: f32 = flight.filter.mode_probabilities()[..5].iter().sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
            // Clockwise is positive.
            let [rate, sigma] = flight.filter.turn_rate().expect("it moves");
            assert!(
                (rate + side * 6.0 / 150.0).abs() < 3.0 * sigma && sigma < 0.05,
                "{rate} {sigma}"
            );
            flight.fly(60.0, 0.0, 0.0);
            straight[1] += flight.probability(MotionMode::Steady) / 20.0;
        }
        assert!(straight.iter().all(|mean| *mean > 0.8), "{straight:?}");
    }
}

#[test]
fn straight_flight_is_known_better_than_all_motions_together() {
    let steady = |flight: &Flight, velocity_mps: [f64; 3], later_s: f64| {
        let time_ns = flight.filter.time_ns + (later_s * NS) as i64;
        flight
            .filter
            .steady_velocity_m2ps2(time_ns, velocity_mps, &flight.motion)
    };
    let squares = |seed| {
        let mut flight = Flight::new(seed);
        flight.fly(90.0, 0.0, 0.0);
        let estimate = &flight.filter.estimate;
        let [vx, vy, vz] = estimate.velocity_mps();
        let [xx, xy, yy] = steady(&flight, [vx, vy, vz], 0.0);
        let p = |row, column| estimate.covariance.get(row, column);
        assert!(xx < p(3, 3) && yy < p(4, 4), "{xx} {yy}");
        // What is left for manoeuvres.
        let weight = f64::from(flight.probability(MotionMode::Steady));
        let rest = [p(3, 3) - weight * xx, p(3, 4) - weight * xy, p(4, 4) - weight * yy];
        assert!(rest[0] > 0.0 && rest[0] * rest[2] > rest[1] * rest[1], "{rest:?}");
        // About another velocity, by the square of the difference; later, by the noise.
        let aside = [3.0, -3.0].map(|by| steady(&flight, [vx + by, vy, vz], 0.0)[0]);
        assert!((0.5 * (aside[0] + aside[1]) - xx - 9.0).abs() < 1e-9);
        let noise_m2ps2 = 10.0 * flight.motion.steady_m2ps3();
        assert!((steady(&flight, [vx, vy, vz], 10.0)[2] - yy - noise_m2ps2).abs() < 1e-9);
        let [dx, dy] = [vx - 150.0, vy];
        let plane = (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / (2.0 * (xx * yy - xy * xy));
        let climb = flight.filter.steady_climb_m2ps2(vz).expect("known");
        assert!(climb < p(5, 5), "{climb}");
        [plane, vz * vz / climb]
    };
    let nees = [0, 1].map(|group: usize| mean(|seed| squares(seed)[group]));
    assert!(nees.iter().all(|mean| (0.1..2.0).contains(mean)), "{nees:?}");
}

#[test]
fn in_turns_the_error_is_hardly_beyond_that_of_a_measurement() {
    let error_m = |left_mps2: f64| {
        mean(|seed| {
            let mut flight = Flight::new(seed);
            flight.fly(60.0, 0.0, 0.0);
            flight.fly(15.0, left_mps2, 0.0);
            flight.error_m()
        })
    };
    // A measurement is off by 50 m on average.
    for left_mps2 in [3.0, 6.0, 15.0, 30.0] {
        let mean_m = error_m(left_mps2);
        assert!(mean_m < 65.0, "{left_mps2} m/s²: {mean_m} m");
    }
    assert!(error_m(0.0) < 20.0);
}

#[test]
fn the_place_expected_later_is_on_the_arc() {
    let off_m = |is_expected: bool| {
        mean(|seed| {
            let mut flight = Flight::new(seed);
            flight.fly(60.0, 0.0, 0.0);
            flight.fly(15.0, 7.0, 0.0);
            let later_ns = ((flight.time_s + 5.0) * NS) as i64;
            let expected = flight.filter.at(later_ns, &flight.motion).position_m();
            let straight = flight.filter.place_at(later_ns);
            // Where it will be, without another measurement.
            let radius_m = 150.0 * 150.0 / 7.0;
            let (from, to) = (flight.course_rad, flight.course_rad + 7.0 / 150.0 * 5.0);
            let [x, y, _] = flight.position_m;
            let place = [
                x + radius_m * (to.sin() - from.sin()),
                y - radius_m * (to.cos() - from.cos()),
            ];
            let found = if is_expected { expected } else { straight };
            (found[0] - place[0]).hypot(found[1] - place[1])
        })
    };
    let (expected_m, straight_m) = (off_m(true), off_m(false));
    assert!(expected_m < 0.93 * straight_m, "{expected_m} {straight_m}");
}

#[test]
fn climbs_begin_and_end() {
    let mut flight = Flight::new(3);
    flight.fly(80.0, 0.0, 0.0);
    assert!(flight.probability(MotionMode::Level) > 0.7);
    let [rate, variance] = flight.filter.climb_rate().expect("height is observed");
    assert!(rate.abs() < 1.0 && variance < 2.5, "{rate} {variance}");
    flight.fly(50.0, 0.0, 12.0);
    assert!(flight.probability(MotionMode::Climb) > 0.7);
    let [rate, variance] = flight.filter.climb_rate().expect("height is observed");
    assert!((rate - 12.0).abs() < 1.0 && variance < 2.5, "{rate} {variance}");
    flight.fly(60.0, 0.0, 0.0);
    assert!(flight.probability(MotionMode::Level) > 0.7);
}

#[test]
fn without_observed_height_nothing_is_stated_of_the_vertical() {
    let flight = Flight::new(1);
    let filter = TargetFilter::new(0, flight.filter.estimate, false);
    assert_eq!(filter.mode_probabilities()[5..], [0.0; 3]);
    assert_eq!(filter.climb_rate(), None);
    assert_eq!(filter.turn_rate(), None, "before the first measurement");
}

#[test]
fn a_resumed_filter_has_the_estimate_and_the_probabilities() {
    let mut flight = Flight::new(5);
    flight.fly(40.0, 0.0, 10.0);
    flight.fly(12.0, 6.0, 10.0);
    let resumed = TargetFilter::resumed(&flight.filter.kept());
    assert_eq!(resumed.estimate, flight.filter.estimate);
    for (mode, (before, after)) in flight
        .filter
        .mode_probabilities()
        .into_iter()
        .zip(resumed.mode_probabilities())
        .enumerate()
    {
        assert!((before - after).abs() < 1e-6, "{mode}: {before} {after}");
    }
}

proptest! {
    #[test]
    fn the_vertical_does_not_touch_the_plane_and_covariances_stay_positive_definite(
        steps in prop::collection::vec((-200.0..200.0f64, -200.0..200.0f64, -300.0..300.0f64, 0.0..12.0f64), 1..40),
    ) {
        let (mut level, mut climbing) = (Flight::new(1), Flight::new(1));
        for (east_m, north_m, up_m, seconds) in steps {
            let x = 150.0 * level.time_s;
            for (flight, height_m) in [(&mut level, 5000.0), (&mut climbing, 5000.0 + up_m)] {
                flight.time_s += seconds;
                flight.take([x + east_m, north_m, height_m]);
            }
            let plane = |flight: &Flight| {
                let [x, y, _, vx, vy, _] = flight.filter.estimate.mean;
                let p = &flight.filter.estimate.covariance.upper;
                let covariance = [0, 1, 3, 4, 6, 8, 9, 15, 16, 18].map(|place| p[place].to_bits());
                ([x, y, vx, vy].map(f64::to_bits), covariance)
            };
            prop_assert_eq!(plane(&level), plane(&climbing));
            prop_assert_eq!(&level.filter.mode_probabilities()[..5], &climbing.filter.mode_probabilities()[..5]);
            for flight in [&level, &climbing] {
                let later = flight.filter.at((flight.time_s * NS) as i64 + 3_000_000_000, &flight.motion);
                prop_assert!(is_usable(&flight.filter.estimate.covariance), "{:?}", flight.filter);
                prop_assert!(is_usable(&later.covariance));
                prop_assert!(flight.filter.is_sound());
                // No correlation between the plane and the vertical.
                let p = &flight.filter.estimate.covariance;
                for (a, b) in [(0, 2), (1, 2), (0, 5), (1, 5), (3, 2), (4, 2), (3, 5), (4, 5)] {
                    prop_assert_eq!(p.get(a, b), 0.0);
                }
            }
        }
    }
}
