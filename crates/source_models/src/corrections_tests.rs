use estimation::Gaussian;
use messages::{AXES, Covariance};
use test_support::Random;

use super::*;

/// A standard normal deviate.
fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * random.between(1e-12, 1.0).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.unit()).cos()
}

/// Errors of a simulated sensor at the origin, along and across the line of sight, metres, at a distance.
type Errors = fn(f64) -> [f64; 2];

const RADAR: Errors = |distance_m| [50.0, 0.002 * distance_m];
const CIRCLE: Errors = |_| [40.0, 40.0];
const ELLIPSE: Errors = |_| [30.0, 120.0];
const HEIGHT_M: f64 = 25.0;

/// A track before and after a measurement, the measurement, and its covariance.
struct Step {
    before: Gaussian,
    after: Gaussian,
    measured_m: [f64; AXES],
    covariance_m2: Plane,
}

/// A correction by Kalman's rule of a tracker that states any covariance below that of the measurement.
fn step(random: &mut Random, errors: Errors, turns: bool) -> Step {
    let (distance_m, bearing) = (random.between(2e4, 1e5), random.between(0.0, std::f64::consts::TAU));
    let direction = [bearing.cos(), bearing.sin()];
    let [along, across] = errors(distance_m).map(|sigma| sigma * sigma);
    let gains = [random.between(0.2, 0.8), random.between(0.2, 0.8)];
    let covariance_m2 = along_and_across([along, across], direction);
    let stated = along_and_across([gains[0] * along, gains[1] * across], direction);
    // The innovation has the covariance R·(R − P)⁻¹·R.
    let innovation = [along, across].map(f64::sqrt);
    let innovation: [f64; 2] =
        std::array::from_fn(|axis| normal(random) * innovation[axis] / (1.0 - gains[axis]).sqrt());
    let innovation = if turns {
        innovation.map(|value| 6.0 * value)
    } else {
        innovation
    };
    let [x, y] = direction;
    let innovation = [
        x * innovation[0] - y * innovation[1],
        y * innovation[0] + x * innovation[1],
    ];
    let u = product(inverse(covariance_m2).unwrap(), innovation);
    let moved = product(stated, u);
    let (height_gain, up) = (0.5, normal(random) * HEIGHT_M / 0.5f64.sqrt());
    let before = Gaussian::new(
        [distance_m * x, distance_m * y, 5000.0],
        [120.0, -90.0, 2.0],
        &Covariance::diagonal([1e3; AXES], [10.0; AXES]),
    );
    let mut covariance = Covariance::diagonal([1.0; AXES], [20.0; AXES]);
    for (row, column, value) in [
        (0, 0, stated[0]),
        (0, 1, stated[1]),
        (1, 1, stated[2]),
        (2, 2, height_gain * HEIGHT_M * HEIGHT_M),
        (0, 3, 0.1 * stated[0]),
        (1, 4, 0.1 * stated[2]),
        (0, 4, 0.1 * stated[1]),
        (1, 3, 0.1 * stated[1]),
    ] {
        covariance.set(row, column, value);
    }
    const SECONDS: f64 = 4.0;
    let place = before.position_m();
    let velocity = before.velocity_mps();
    let predicted: [f64; AXES] = std::array::from_fn(|axis| place[axis] + SECONDS * velocity[axis]);
    let after = Gaussian::new(
        [
            predicted[0] + moved[0],
            predicted[1] + moved[1],
            predicted[2] + height_gain * up,
        ],
        [velocity[0] + 0.1 * moved[0], velocity[1] + 0.1 * moved[1], velocity[2]],
        &covariance,
    );
    Step {
        before,
        after,
        measured_m: [
            predicted[0] + innovation[0],
            predicted[1] + innovation[1],
            predicted[2] + up,
        ],
        covariance_m2,
    }
}

impl Step {
    fn corrected(&self, place_m: Option<[f64; 2]>) -> Corrected<'_> {
        Corrected::of((&self.before, 4.0), (&self.after, true), place_m)
    }
}

/// What is known after `count` corrections, of which every tenth is a turn's if the targets turn.
fn learned(errors: Errors, place_m: Option<[f64; 2]>, count: usize, turns: bool) -> (Corrections, Random) {
    let (mut known, mut random) = (Corrections::default(), Random::new(7));
    for number in 0..count {
        let step = step(&mut random, errors, turns && number % 10 == 9);
        known.learn(&step.corrected(place_m), 10);
    }
    (known, random)
}

/// Root mean square of the error of recovered positions and of the ratio of the standard deviations, both relative.
fn recovered(errors: Errors, place_m: Option<[f64; 2]>, turns: bool) -> [f64; 2] {
    let (known, mut random) = learned(errors, place_m, 3000, turns);
    assert!(known.is_used());
    let (mut error, mut ratio) = (0.0, 0.0);
    const TRIED: usize = 500;
    for _ in 0..TRIED {
        let step = step(&mut random, errors, false);
        let found = known.measurement(&step.corrected(place_m)).unwrap();
        let inverse = inverse(step.covariance_m2).unwrap();
        let off = [0, 1].map(|axis| found.position_m[axis] - step.measured_m[axis]);
        let weighed = product(inverse, off);
        error += off[0] * weighed[0] + off[1] * weighed[1];
        let [xx, _, yy] = step.covariance_m2;
        ratio += ((found.covariance_m2[0] + found.covariance_m2[3]) / (xx + yy))
            .ln()
            .powi(2)
            / 4.0;
        assert!(
            (found.position_m[2] - step.measured_m[2]).abs()
                < 0.3 * HEIGHT_M + 0.2 * (step.measured_m[2] - 5008.0).abs()
        );
    }
    [error, ratio].map(|sum| (sum / TRIED as f64).sqrt())
}

#[test]
fn measurements_and_their_errors_come_back_in_each_shape() {
    for (name, errors, place_m, [error_max, ratio_max]) in [
        ("circle", CIRCLE, None, [0.15, 0.12]),
        ("circle with a place", CIRCLE, Some([0.0; 2]), [0.15, 0.12]),
        ("ellipse", ELLIPSE, Some([0.0; 2]), [0.15, 0.12]),
        ("radar", RADAR, Some([0.0; 2]), [0.15, 0.12]),
        // Without the place of the sensor, the stated covariance shows the shape, not the size.
        ("radar without a place", RADAR, None, [0.8, 0.4]),
    ] {
        let [error, ratio] = recovered(errors, place_m, false);
        assert!(error < error_max && ratio < ratio_max, "{name}: {error}, {ratio}");
    }
}

#[test]
fn targets_that_turn_hide_little() {
    let [error, ratio] = recovered(RADAR, Some([0.0; 2]), true);
    assert!(error < 0.35 && ratio < 0.3, "{error}, {ratio}");
}

#[test]
fn a_tracker_that_obeys_another_rule_is_left_alone() {
    let (mut known, mut random) = (Corrections::default(), Random::new(8));
    for _ in 0..500 {
        let mut step = step(&mut random, CIRCLE, false);
        // A measured velocity.
        step.after.mean[AXES] += 5.0 * normal(&mut random);
        known.learn(&step.corrected(None), 10);
    }
    assert!(!known.is_used());
    let (mut known, mut random) = learned(CIRCLE, None, 200, false);
    assert!(known.is_used());
    for _ in 0..2000 {
        let mut step = step(&mut random, CIRCLE, false);
        step.after.mean[AXES] += 5.0 * normal(&mut random);
        known.learn(&step.corrected(None), 10);
    }
    assert!(!known.is_used(), "the tracker has changed");
}

#[test]
fn predictions_and_new_tracks_teach_nothing() {
    let (mut known, mut random) = (Corrections::default(), Random::new(9));
    for _ in 0..200 {
        let mut step = step(&mut random, CIRCLE, false);
        known.learn(&step.corrected(None), REPORTS_MIN - 1);
        let predicted = Corrected::of((&step.before, 4.0), (&step.after, true), None).predicted_m;
        step.after.mean[..AXES].copy_from_slice(&predicted);
        known.learn(&step.corrected(None), 10);
        assert!(known.measurement(&step.corrected(None)).is_none());
    }
    assert!(!known.is_used());
}

/// Ships, whose heights never change, for days; and covariances of which a variance is 0.
#[test]
fn heights_that_stay_and_variances_of_0_leave_finite_values() {
    let (mut known, mut random) = (Corrections::default(), Random::new(10));
    let mut measured = 0;
    for number in 0..400_000 {
        let mut step = step(&mut random, CIRCLE, false);
        step.after.mean[2] = 5000.0 + 4.0 * 2.0;
        if number % 2 == 0 {
            step.after.covariance.set(2, 2, 0.0);
        }
        if number % 1000 == 0 {
            step.after.covariance.set(0, 0, 0.0);
        }
        let corrected = step.corrected(Some([0.0; 2]));
        known.learn(&corrected, 10);
        // By chance, a correction may be as short as a repeated prediction.
        if number > 1000
            && number % 1000 != 0
            && let Some(found) = known.measurement(&corrected)
        {
            assert!(
                found
                    .covariance_m2
                    .iter()
                    .all(|value| value.is_finite() && value.abs() < 1e6)
            );
            assert!((found.position_m[2] - 5008.0).abs() < 1e-6);
            measured += 1;
        }
    }
    assert!(measured > 390_000);
    assert!(known.is_used());
}
