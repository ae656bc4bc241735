use estimation::{FirstVelocity, Gaussian, NearlyConstantVelocity};
use test_support::Random;

use super::*;

/// Constant covariance that the source states.
const STATED: [f64; AXES] = [40.0, 40.0, 60.0];
const PERIOD_S: f64 = 4.0;
const FIRST: FirstVelocity = FirstVelocity {
    horizontal_sigma_mps: 150.0,
    vertical_sigma_mps: 15.0,
};

/// A source with a nearly-constant-velocity filter, which states a constant covariance.
struct Tracker {
    random: Random,
    /// Standard deviations along the first axis of its errors and across it, and of the height.
    sigma_m: [f64; AXES],
    /// Direction of the first axis, from east.
    angle: f64,
}

/// A recovered measurement beside the true one: error of its position along both axes and in height, and its variances
/// there; variances of the report as the filter has them beside those found.
struct Compared {
    error_m: [f64; AXES],
    variance_m2: [f64; AXES],
    report: Vec<(f64, f64)>,
}

impl Tracker {
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.random.unit()).sum::<f64>() - 6.0
    }

    /// Follows a target for `looks` looks, each of which is a report but every seventh, which sees nothing.
    fn follow(&mut self, gain: &mut TrackerGain, looks: u32) -> Vec<Compared> {
        let (sin, cos) = self.angle.sin_cos();
        let [a, b, c] = self.sigma_m.map(|sigma| sigma * sigma);
        let r = [
            a * cos * cos + b * sin * sin,
            0.0,
            0.0,
            a * sin * sin + b * cos * cos,
            0.0,
            c,
        ];
        let r = [r[0], (a - b) * sin * cos, r[2], r[3], r[4], r[5]];
        let model = NearlyConstantVelocity::new(20.0, 2.0);
        let stated = Covariance::diagonal(STATED, [15.0, 15.0, 4.0]);
        let mut evidence = GainEvidence::default();
        let mut track: Option<Gaussian> = None;
        let mut found = Vec::new();
        let mut idle = 0;
        for step in 0..looks {
            let seconds = PERIOD_S * f64::from(step);
            let noise: [f64; AXES] = std::array::from_fn(|axis| self.sigma_m[axis] * self.normal());
            let z = [
                200.0 * seconds + noise[0] * cos - noise[1] * sin,
                -100.0 * seconds + noise[0] * sin + noise[1] * cos,
                5000.0 + 3.0 * seconds + noise[2],
            ];
            let Some(before) = track else {
                track = Some(Gaussian::from_first_position::<3>(z, &r, FIRST));
                continue;
            };
            let predicted = model.predicted(&before, PERIOD_S);
            let mut updated = predicted;
            if step % 7 == 6 {
                idle += 1;
                track = Some(predicted);
                continue;
            }
            updated.update_position::<3>(z, &r).unwrap();
            track = Some(updated);
            let change = Change {
                position_m: std::array::from_fn(|axis| updated.mean[axis] - predicted.mean[axis]),
                velocity_mps: std::array::from_fn(|axis| updated.mean[axis + AXES] - before.mean[axis + AXES]),
                seconds: PERIOD_S * f64::from(1 + std::mem::take(&mut idle)),
                has_height: true,
            };
            let Some(undone) = gain.take(&mut evidence, &change, &stated) else {
                continue;
            };
            assert!(undone.covariance.upper.iter().all(|value| value.is_finite()));
            let (innovation, covariance) = undone.measurement.unwrap();
            let error: [f64; AXES] = std::array::from_fn(|axis| predicted.mean[axis] + innovation[axis] - z[axis]);
            let [xx, xy, _, yy, _, zz] = covariance;
            let along = |cos: f64, sin: f64| xx * cos * cos + 2.0 * xy * cos * sin + yy * sin * sin;
            found.push(Compared {
                error_m: [
                    error[0] * cos + error[1] * sin,
                    error[1] * cos - error[0] * sin,
                    error[2],
                ],
                variance_m2: [along(cos, sin), along(-sin, cos), zz],
                report: [(0, 0), (1, 1), (0, 3), (1, 4), (3, 3), (4, 4)]
                    .map(|(row, column)| (updated.covariance.get(row, column), undone.covariance.get(row, column)))
                    .to_vec(),
            });
        }
        found
    }
}

fn tracker(sigma_m: [f64; AXES], angle: f64) -> Tracker {
    Tracker {
        random: Random::new(7),
        sigma_m,
        angle,
    }
}

/// What was found of the last of `tracks` tracks of 25 reports each, once it is old.
fn found(gain: &mut TrackerGain, tracker: &mut Tracker, tracks: u32) -> Vec<Compared> {
    let mut last = Vec::new();
    for _ in 0..tracks {
        last = tracker.follow(gain, 25);
    }
    assert!(last.len() > 15, "not undone");
    last.drain(..12);
    last
}

/// The median over the reports of the standard deviation found on one axis, relative to the true one. A report after a
/// look without a detection shows a variance up to four times too small.
fn ratio(found: &[Compared], axis: usize, sigma_m: f64) -> f64 {
    let mut ratios: Vec<f64> = found
        .iter()
        .map(|compared| compared.variance_m2[axis].sqrt() / sigma_m)
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios[ratios.len() / 2]
}

#[test]
fn measurements_and_the_shape_of_their_errors_come_back() {
    for (sigma_m, angle) in [
        ([50.0, 300.0, 75.0], 0.4),
        ([30.0, 90.0, 45.0], 2.0),
        ([80.0, 80.0, 120.0], 0.0),
        ([240.0, 40.0, 60.0], 1.2),
    ] {
        let mut gain = TrackerGain::default();
        let found = found(&mut gain, &mut tracker(sigma_m, angle), 30);
        for axis in 0..2 {
            let squares: f64 = found
                .iter()
                .map(|compared| compared.error_m[axis] * compared.error_m[axis])
                .sum();
            let error = (squares / found.len() as f64).sqrt() / sigma_m[axis];
            assert!(error < 0.25, "{sigma_m:?}, axis {axis}: {error}");
            let ratio = ratio(&found, axis, sigma_m[axis]);
            assert!((0.75..1.35).contains(&ratio), "{sigma_m:?}, axis {axis}: {ratio}");
        }
        let (expected, got) = found[found.len() / 2].report[0];
        assert!((0.4 * expected..2.5 * expected).contains(&got), "{expected} {got}");
    }
}

#[test]
fn errors_that_grow_or_shrink_are_followed() {
    let mut gain = TrackerGain::default();
    for sigma_m in [[50.0, 100.0, 75.0], [100.0, 200.0, 150.0], [25.0, 50.0, 40.0]] {
        let found = found(&mut gain, &mut tracker(sigma_m, 0.7), 80);
        for axis in 0..2 {
            let ratio = ratio(&found, axis, sigma_m[axis]);
            assert!((0.7..1.4).contains(&ratio), "{sigma_m:?}, axis {axis}: {ratio}");
        }
    }
}

#[test]
fn a_dozen_young_tracks_are_enough() {
    let mut gain = TrackerGain::default();
    let mut tracker = tracker([50.0, 300.0, 75.0], 0.4);
    assert_eq!(gain.first(&Covariance::default()), None);
    for _ in 0..12 {
        tracker.follow(&mut gain, 4);
    }
    assert!(gain.is_undone());
    let first = gain.first(&Covariance::diagonal(STATED, [15.0; AXES])).unwrap();
    let expected_m2 = 0.5 * (50.0 * 50.0 + 300.0 * 300.0);
    let ratio = (first.get(0, 0) / expected_m2).sqrt();
    assert!((0.6..1.6).contains(&ratio), "{ratio}");
    assert!(first.get(3, 3) > 50.0 * 50.0, "the first velocity is a guess");
    assert!(gain.claim().unwrap() > 10.0);
    let [long, short] = gain.plane_sigma_m().unwrap();
    assert!(long >= short && (30.0..600.0).contains(&short), "{long} {short}");
}

#[test]
fn measured_velocities_are_no_gain() {
    // Positions and velocities with independent errors, of targets that fly straight and of targets that speed up.
    for acceleration in [0.0, 5.0] {
        let mut gain = TrackerGain::default();
        let mut source = tracker([10.0, 10.0, 10.0], 0.0);
        for _ in 0..50 {
            let mut evidence = GainEvidence::default();
            for _ in 0..20 {
                let change = Change {
                    position_m: std::array::from_fn(|axis| {
                        10.0 * source.normal() + if axis == 0 { 0.5 * acceleration * 16.0 } else { 0.0 }
                    }),
                    velocity_mps: std::array::from_fn(|axis| {
                        source.normal() + if axis == 0 { acceleration * 4.0 } else { 0.0 }
                    }),
                    seconds: PERIOD_S,
                    has_height: true,
                };
                let undone = gain.take(&mut evidence, &change, &Covariance::diagonal(STATED, STATED));
                assert_eq!(undone, None);
            }
        }
        assert!(!gain.is_undone() && !gain.is_open() && gain.claim().is_none());
    }
}

#[test]
fn a_report_that_repeats_a_prediction_holds_no_measurement() {
    let mut gain = TrackerGain::default();
    found(&mut gain, &mut tracker([50.0, 100.0, 75.0], 0.7), 10);
    let change = Change {
        position_m: [0.0; AXES],
        velocity_mps: [0.0; AXES],
        seconds: PERIOD_S,
        has_height: true,
    };
    let undone = gain.take(
        &mut GainEvidence::default(),
        &change,
        &Covariance::diagonal(STATED, STATED),
    );
    let undone = undone.unwrap();
    assert_eq!(undone.measurement, None);
    assert!(undone.covariance.upper.iter().all(|value| value.is_finite()));
}

#[test]
fn a_source_that_measures_its_velocity_is_given_up_but_each_track_teaches_in_turn() {
    let mut random = Random::new(5);
    let (mut gain, mut evidence) = (TrackerGain::default(), GainEvidence::default());
    let stated = Covariance::diagonal(STATED, [1.0; AXES]);
    for _ in 0..2 * HOPELESS_SAMPLES {
        let mut around = |spread: f64| random.between(-spread, spread);
        let change = Change {
            position_m: [around(40.0), around(40.0), 0.0],
            velocity_mps: [around(1.0), around(1.0), 0.0],
            seconds: PERIOD_S,
            has_height: false,
        };
        assert!(gain.take(&mut evidence, &change, &stated).is_none());
    }
    assert!(gain.is_hopeless());
    let mut smoothing = TrackerGain::default();
    let mut tracker = Tracker {
        random: Random::new(6),
        sigma_m: [40.0, 40.0, 60.0],
        angle: 0.0,
    };
    for _ in 0..10 {
        tracker.follow(&mut smoothing, 30);
        assert!(!smoothing.is_hopeless());
    }
    let minute_ns = 1 << TEACHES_FOR;
    for track in 100..120 {
        let minutes = (0..TEACHES_OF).filter(|minute| teaches(track, minute * minute_ns + 7));
        assert_eq!(minutes.count(), 1, "{track}");
    }
    // What taught nothing has made the track older all the same.
    let mut young = GainEvidence::default();
    young.grow_to(31);
    young.grow_to(4);
    assert_eq!(young.updates, 30);
}

/// Every forecast foretells a climb of 0, which therefore shows no filter: multilateration states heights and no climb.
#[test]
fn heights_without_a_climb_are_not_undone() {
    let stated = Covariance::diagonal(STATED, [15.0, 15.0, 4.0]);
    let (mut gain, mut tracker) = (TrackerGain::default(), tracker([30.0; AXES], 0.0));
    for _ in 0..8 {
        let mut evidence = GainEvidence::default();
        for _ in 0..30 {
            let position_m: [f64; AXES] = std::array::from_fn(|_| 20.0 * tracker.normal());
            let [x, y, _] = position_m.map(|moved_m| 0.3 * moved_m / PERIOD_S);
            let change = Change {
                position_m,
                velocity_mps: [x, y, 0.0],
                seconds: PERIOD_S,
                has_height: true,
            };
            gain.take(&mut evidence, &change, &stated);
        }
    }
    assert!(gain.is_undone());
    assert_eq!(gain.height_sigma_m(), None);
}
