//! Location from arrival times, beside the Cramér–Rao bound: a generator, its bound, and what the locator reaches.

use locating::settings::FilterChoice;
use locating::{BearingRejection, EmitterReport, Locator, MotionModel, Settings};
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use observations::{Arrival, ArrivalTime, Receiver, ReceiverName};

use crate::common::{Noise, S, bearing};

const C: f64 = 299_792_458.0;
/// Standard deviation of a difference of distances.
const SIGMA_M: f64 = 20.0;
const CORNERS: [[f64; 2]; 4] = [[-10e3, -10e3], [10e3, -10e3], [10e3, 10e3], [-10e3, 10e3]];
/// The emitter of the tests, and the reference emitter.
const EMITTER: u32 = 1;
const REFERENCE: u32 = 2;

/// Receivers of a transmission, and what is wrong with their times.
struct Network {
    receivers: Vec<[f64; 2]>,
    /// Clock ahead of the true time at 0, and drift: metres, metres per second.
    clocks: Vec<[f64; 2]>,
    /// Share of arrival times that are late by up to 5 km, and the receivers of the last transmission without such.
    wrong: f64,
    good: Vec<[f64; 2]>,
    noise: Noise,
}

impl Network {
    fn new(receivers: &[[f64; 2]], seed: u64) -> Self {
        Self {
            receivers: receivers.to_vec(),
            clocks: vec![[0.0; 2]; receivers.len()],
            wrong: 0.0,
            good: Vec::new(),
            noise: Noise::new(seed),
        }
    }

    /// Sets the clocks: off by up to a millisecond, and drifting by up to 1e-7.
    fn with_clocks(mut self) -> Self {
        for clock in &mut self.clocks {
            *clock = [3e5 * self.noise.next(), 30.0 * self.noise.next()];
        }
        self
    }

    fn receiver(&self, place: usize) -> Receiver {
        let [east, north] = self.receivers[place];
        Receiver {
            name: ReceiverName::new(&format!("r{place}")).unwrap(),
            position_m: [east, north, 0.0],
        }
    }

    /// The way that the receiver states, with its errors.
    fn way_m(&mut self, place: usize, time_s: f64, emitter: [f64; 2], sigma_m: f64) -> f64 {
        let [offset, drift] = self.clocks[place];
        let is_wrong = self.noise.uniform() < self.wrong;
        let late = if is_wrong {
            200.0 + 4_800.0 * self.noise.uniform()
        } else {
            0.0
        };
        if !is_wrong {
            self.good.push(self.receivers[place]);
        }
        distance(self.receivers[place], emitter) + offset + drift * time_s + late + sigma_m * self.noise.next()
    }

    /// Arrival times at all receivers.
    fn times(&mut self, emitter_id: u32, time_s: f64, emitter: [f64; 2]) -> Vec<Arrival> {
        let sigma_m = SIGMA_M / 2f64.sqrt();
        self.good.clear();
        (0..self.receivers.len())
            .map(|place| {
                let t_s = time_s + self.way_m(place, time_s, emitter, sigma_m) / C;
                let receiver = self.receiver(place);
                let time = ArrivalTime::At { receiver, t_s };
                arrival(emitter_id, time_s, time, sigma_m, emitter)
            })
            .collect()
    }

    /// Differences of all receivers from the first one, with errors of their own.
    fn differences(&mut self, emitter_id: u32, time_s: f64, emitter: [f64; 2]) -> Vec<Arrival> {
        self.good.clear();
        (1..self.receivers.len())
            .map(|place| {
                let way_m = distance(self.receivers[0], emitter) - self.way_m(place, time_s, emitter, SIGMA_M);
                let receivers = [self.receiver(0), self.receiver(place)];
                let tdoa_s = way_m / C;
                let time = ArrivalTime::Between { receivers, tdoa_s };
                arrival(emitter_id, time_s, time, SIGMA_M, emitter)
            })
            .collect()
    }
}

fn arrival(emitter_id: u32, time_s: f64, time: ArrivalTime, sigma_m: f64, emitter: [f64; 2]) -> Arrival {
    Arrival {
        time_of_measurement_ns: (time_s * S as f64).round() as i64,
        emitter_id,
        time,
        sigma_s: sigma_m / C,
        reference_m: (emitter_id == REFERENCE).then_some([emitter[0], emitter[1], 0.0]),
    }
}

fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

fn direction(from: [f64; 2], to: [f64; 2]) -> Vector2<f64> {
    Vector2::new(to[0] - from[0], to[1] - from[1]).normalize()
}

/// Information of one transmission in arrival times at these receivers: the time of transmission is unknown.
fn information_of_times(receivers: &[[f64; 2]], emitter: [f64; 2]) -> Matrix2<f64> {
    let directions: Vec<_> = receivers.iter().map(|at| direction(*at, emitter)).collect();
    let mean = directions.iter().sum::<Vector2<f64>>() / receivers.len() as f64;
    let squares = directions.iter().map(|at| (at - mean) * (at - mean).transpose());
    squares.sum::<Matrix2<f64>>() / (0.5 * SIGMA_M * SIGMA_M)
}

/// Information of one transmission in independent differences from the first receiver.
fn information_of_differences(receivers: &[[f64; 2]], emitter: [f64; 2]) -> Matrix2<f64> {
    information_of_good(receivers[0], &receivers[1..], emitter)
}

/// The same of these differences from the first corner.
fn information_of_good_differences(others: &[[f64; 2]], emitter: [f64; 2]) -> Matrix2<f64> {
    information_of_good(CORNERS[0], others, emitter)
}

fn information_of_good(first: [f64; 2], others: &[[f64; 2]], emitter: [f64; 2]) -> Matrix2<f64> {
    let first = direction(first, emitter);
    let rows = others.iter().map(|at| first - direction(*at, emitter));
    rows.map(|row| row * row.transpose()).sum::<Matrix2<f64>>() / (SIGMA_M * SIGMA_M)
}

/// Root of the sum of both variances.
fn bound_m(information: Matrix2<f64>) -> f64 {
    information
        .try_inverse()
        .expect("the geometry determines a position")
        .trace()
        .sqrt()
}

fn locator(filter: FilterChoice) -> Locator {
    let mut settings = Settings {
        emitters_max: 4,
        ..Settings::default()
    };
    settings.motion.filter = filter;
    Locator::new(settings).unwrap()
}

/// The last report of all.
fn last(locator: &mut Locator, arrivals: impl IntoIterator<Item = Arrival>) -> Option<EmitterReport> {
    let mut last = None;
    for arrival in arrivals {
        while let Some(complete) = locator.complete(Some(arrival.time_of_measurement_ns)) {
            last = complete.unwrap_or(None).or(last);
        }
        last = locator.arrival(&arrival).unwrap_or(None).or(last);
    }
    while let Some(complete) = locator.complete(None) {
        last = complete.unwrap_or(None).or(last);
    }
    last
}

/// Places in and about the square of receivers, and beside one of them.
fn places() -> Vec<[f64; 2]> {
    vec![
        [0.0, 0.0],
        [3e3, -6e3],
        [-9.7e3, -9.8e3],
        [11e3, 10.6e3],
        [18e3, 2e3],
        [-16e3, 21e3],
        [4e3, 40e3],
    ]
}

/// Root mean square of the errors over the bound, and mean of the normalised squared error per degree of freedom.
#[derive(Default)]
struct Score {
    squared: f64,
    normalised: f64,
    runs: f64,
    missing: u32,
}

impl Score {
    fn add(&mut self, report: Option<EmitterReport>, truth: [f64; 2]) {
        let Some(report) = report else {
            self.missing += 1;
            return;
        };
        let [x, y] = [0, 1].map(|axis| report.raw.position_m[axis] - truth[axis]);
        let p = &report.raw.covariance;
        let determinant = p[(0, 0)] * p[(1, 1)] - p[(0, 1)] * p[(0, 1)];
        let squared = (x * x * p[(1, 1)] - 2.0 * x * y * p[(0, 1)] + y * y * p[(0, 0)]) / determinant;
        self.squared += x * x + y * y;
        self.normalised += 0.5 * squared;
        self.runs += 1.0;
    }

    fn ratio(&self, bound_m: f64) -> f64 {
        (self.squared / self.runs).sqrt() / bound_m
    }

    fn consistency(&self) -> f64 {
        self.normalised / self.runs
    }
}

/// Runs per place: a root mean square is known to 4 %.
const RUNS: u64 = 150;

/// Least normalised error: of fixed points, and of mixtures, whose covariance contains a drift. Sixty transmissions in
/// a minute know a place with an unknown velocity half as well as one without.
const EXACT: f64 = 0.7;
const WITH_DRIFT: f64 = 0.12;

/// Checks every place: error over the bound, normalised error (at least `least`), and how many runs may have no fix.
fn check(
    (limit, least): (f64, f64),
    missing_max: u32,
    places: &[[f64; 2]],
    bound: impl Fn([f64; 2]) -> f64,
    run: impl Fn(u64, [f64; 2]) -> Option<EmitterReport>,
) {
    let mut failures = Vec::new();
    for place in places {
        let mut score = Score::default();
        for seed in 0..RUNS {
            score.add(run(seed + 1, *place), *place);
        }
        let (ratio, consistency) = (score.ratio(bound(*place)), score.consistency());
        println!(
            "{place:?}: {ratio:.3} of the bound, {consistency:.2} normalised, {} missing",
            score.missing
        );
        if ratio > limit || !(least..1.4).contains(&consistency) || score.missing > missing_max {
            failures.push((place, ratio, consistency, score.missing));
        }
    }
    assert!(
        failures.is_empty(),
        "place, of the bound, normalised, missing: {failures:?}"
    );
}

#[test]
fn differences_of_four_receivers_reach_the_bound() {
    for filter in [FilterChoice::Auto, FilterChoice::Fixed] {
        check(
            (1.1, EXACT),
            0,
            &places(),
            |place| bound_m(10.0 * information_of_differences(&CORNERS, place)),
            |seed, place| {
                let mut network = Network::new(&CORNERS, seed);
                let rows: Vec<_> = (0..10)
                    .flat_map(|k| network.differences(EMITTER, f64::from(k), place))
                    .collect();
                last(&mut locator(filter), rows)
            },
        );
    }
}

#[test]
fn arrival_times_of_four_receivers_reach_the_bound() {
    let cases = [
        (1, FilterChoice::Auto, EXACT),
        (10, FilterChoice::Auto, EXACT),
        (60, FilterChoice::Auto, WITH_DRIFT),
        (60, FilterChoice::Fixed, EXACT),
    ];
    for (transmissions, filter, least) in cases {
        check(
            (1.1, least),
            0,
            &places(),
            |place| bound_m(f64::from(transmissions) * information_of_times(&CORNERS, place)),
            |seed, place| {
                let mut network = Network::new(&CORNERS, seed);
                let rows: Vec<_> = (0..transmissions)
                    .flat_map(|k| network.times(EMITTER, f64::from(k), place))
                    .collect();
                last(&mut locator(filter), rows)
            },
        );
    }
}

/// A fifth of the times is wrong; the bound is that of the others.
#[test]
fn wrong_arrival_times_are_passed_over() {
    // A wrong difference from the first receiver leaves two others, which fit at two places outside the square.
    for (is_single, places) in [(true, &places()[..6]), (false, &places()[..2])] {
        for place in places {
            let (mut score, mut bound_m2) = (Score::default(), 0.0);
            for seed in 0..RUNS {
                let mut network = Network::new(&CORNERS, seed + 1);
                network.wrong = 0.2;
                let (mut information, mut locator, mut report) = (Matrix2::zeros(), locator(FilterChoice::Auto), None);
                for k in 0..20 {
                    let rows = match is_single {
                        true => network.times(EMITTER, f64::from(k), *place),
                        false => network.differences(EMITTER, f64::from(k), *place),
                    };
                    report = last(&mut locator, rows).or(report);
                    information += match is_single {
                        true if network.good.is_empty() => Matrix2::zeros(),
                        true => information_of_times(&network.good, *place),
                        false => information_of_good_differences(&network.good, *place),
                    };
                }
                score.add(report, *place);
                bound_m2 += bound_m(information).powi(2) / RUNS as f64;
            }
            let (ratio, consistency) = (score.ratio(bound_m2.sqrt()), score.consistency());
            println!(
                "{place:?}: {ratio:.3} of the bound, {consistency:.2} normalised, {} missing",
                score.missing
            );
            assert!(
                ratio < 1.3 && consistency < 1.4 && score.missing == 0,
                "{place:?}: {ratio} {consistency}"
            );
        }
    }
}

#[test]
fn three_receivers_locate_where_there_is_one_solution() {
    let receivers = [[-10e3, -6e3], [10e3, -6e3], [0.0, 11e3]];
    check(
        (1.1, EXACT),
        0,
        &[[0.0, 0.0], [3e3, 2e3], [-5e3, -3e3]],
        |place| bound_m(5.0 * information_of_times(&receivers, place)),
        |seed, place| {
            let mut network = Network::new(&receivers, seed);
            let rows: Vec<_> = (0..5)
                .flat_map(|k| network.times(EMITTER, f64::from(k), place))
                .collect();
            last(&mut locator(FilterChoice::Auto), rows)
        },
    );
}

#[test]
fn of_two_solutions_none_is_published() {
    let receivers = [[-10e3, -6e3], [10e3, -6e3], [0.0, 11e3]];
    let mut network = Network::new(&receivers, 1);
    let rows: Vec<_> = (0..5)
        .flat_map(|k| network.times(EMITTER, f64::from(k), [-13e3, -8.5e3]))
        .collect();
    let report = last(&mut locator(FilterChoice::Fixed), rows);
    assert!(report.is_none(), "{report:?}");
}

#[test]
fn bearings_and_one_pair_reach_their_bound() {
    let sigma_rad = 0.01;
    let receivers = [[-10e3, 0.0], [10e3, 0.0]];
    let platform = [-25e3, 5e3];
    check(
        (1.1, WITH_DRIFT),
        0,
        &[[5e3, 8e3], [-2e3, 15e3]],
        |place| {
            let away = Vector2::new(place[0] - platform[0], place[1] - platform[1]);
            let across = Vector2::new(away[1], -away[0]) / away.norm_squared() / sigma_rad;
            bound_m(30.0 * (information_of_differences(&receivers, place) + across * across.transpose()))
        },
        |seed, place| {
            let mut network = Network::new(&receivers, seed);
            let mut locator = locator(FilterChoice::Auto);
            let mut report = None;
            for k in 0..30 {
                let time_s = 2.0 * f64::from(k);
                let seen = bearing(time_s, platform, place, sigma_rad, sigma_rad * network.noise.next());
                report = locator.bearing(&seen).unwrap().or(report);
                let rows = network.differences(EMITTER, time_s + 1.0, place);
                report = last(&mut locator, rows).or(report);
            }
            report
        },
    );
}

/// Bound with clocks whose offsets and drifts are unknown: a transmission of the emitter and one of the reference each
/// second.
fn bound_with_clocks_m(place: [f64; 2], from: usize, seconds: usize) -> f64 {
    let count = CORNERS.len();
    // Position, then offset and drift of all receivers but the first, which is the reference of the clocks.
    let size = 2 + 2 * (count - 1);
    let mut information = DMatrix::<f64>::zeros(size, size);
    for second in 0..seconds {
        for is_reference in [true, false] {
            if !is_reference && second < from {
                continue;
            }
            let rows: Vec<DVector<f64>> = (0..count)
                .map(|receiver| {
                    let mut row = DVector::zeros(size);
                    if !is_reference {
                        let away = direction(CORNERS[receiver], place);
                        (row[0], row[1]) = (away[0], away[1]);
                    }
                    if receiver > 0 {
                        row[2 * receiver] = 1.0;
                        row[2 * receiver + 1] = second as f64;
                    }
                    row
                })
                .collect();
            let mean = rows.iter().sum::<DVector<f64>>() / count as f64;
            for row in &rows {
                let row = row - &mean;
                information += &row * row.transpose() / (0.5 * SIGMA_M * SIGMA_M);
            }
        }
    }
    let covariance = information.try_inverse().expect("determined");
    (covariance[(0, 0)] + covariance[(1, 1)]).sqrt()
}

#[test]
fn clocks_are_estimated_from_a_reference_emitter() {
    let reference = [2e3, -1e3];
    for (from, seconds) in [(30, 90), (0, 60), (60, 61)] {
        check(
            (1.2, EXACT),
            0,
            &places()[..6],
            |place| bound_with_clocks_m(place, from, seconds),
            |seed, place| {
                let mut network = Network::new(&CORNERS, seed).with_clocks();
                let mut settings = Settings::default();
                settings.arrivals.clocks = locating::settings::ClockChoice::Estimated;
                settings.motion.filter = FilterChoice::Fixed;
                let mut locator = Locator::new(settings).unwrap();
                let mut report = None;
                for k in 0..seconds {
                    let time_s = k as f64;
                    let rows = network.times(REFERENCE, time_s, reference);
                    last(&mut locator, rows);
                    if k >= from {
                        let rows = network.times(EMITTER, time_s + 0.5, place);
                        report = last(&mut locator, rows).or(report);
                    }
                }
                report
            },
        );
    }
}

/// Distance of the last fix from the truth, metres, by clocks that are estimated for three minutes; infinite without a
/// fix.
fn error_with_clocks_m(seed: u64, set: fn(&mut locating::settings::ArrivalSettings)) -> f64 {
    let (reference, place) = ([2e3, -1e3], [3e3, -6e3]);
    let mut network = Network::new(&CORNERS, seed).with_clocks();
    let mut settings = Settings::default();
    settings.arrivals.clocks = locating::settings::ClockChoice::Estimated;
    set(&mut settings.arrivals);
    settings.motion.filter = FilterChoice::Fixed;
    let mut locator = Locator::new(settings).unwrap();
    let mut report = None;
    for second in 0..180 {
        let time_s = f64::from(second);
        let rows = network.times(REFERENCE, time_s, reference);
        last(&mut locator, rows);
        if second >= 150 {
            let rows = network.times(EMITTER, time_s + 0.5, place);
            report = last(&mut locator, rows).or(report);
        }
    }
    report.map_or(f64::INFINITY, |report| {
        distance([report.raw.position_m[0], report.raw.position_m[1]], place)
    })
}

#[test]
fn a_drift_is_followed_as_far_as_its_keys_permit() {
    let error_m = |set: fn(&mut locating::settings::ArrivalSettings)| {
        let errors = (1..=10).map(|seed| error_with_clocks_m(seed, set));
        errors.sum::<f64>() / 10.0
    };
    // Drifts of 1e-7 are unknown to clocks that are said to have none.
    let free_m = error_m(|_| {});
    let held_m = error_m(|arrivals| arrivals.drift_sigma = 1e-13);
    assert!(free_m < 10.0 && held_m > 5.0 * free_m, "{free_m} {held_m}");
    // Clocks that are said to wander are averaged over a shorter time.
    let wandering_m = error_m(|arrivals| arrivals.drift_noise_per_root_s = 1e-7);
    assert!(wandering_m > 2.0 * free_m, "{wandering_m} {free_m}");
}

#[test]
fn waves_propagate_as_fast_as_their_key_states() {
    let place = [3e3, -6e3];
    let error_m = |propagation_mps: f64| {
        let mut settings = Settings::default();
        settings.arrivals.propagation_mps = propagation_mps;
        settings.arrivals.together_max_s = 10.0;
        settings.motion.filter = FilterChoice::Fixed;
        let mut network = Network::new(&CORNERS, 3);
        let slower = |mut arrival: Arrival| {
            let begun_s = arrival.time_of_measurement_ns as f64 / S as f64;
            if let ArrivalTime::At { t_s, .. } = &mut arrival.time {
                *t_s = begun_s + 1.25 * (*t_s - begun_s);
            }
            arrival.sigma_s *= 1.25;
            arrival
        };
        let rows: Vec<_> = (0..10)
            .flat_map(|k| network.times(EMITTER, 60.0 * f64::from(k), place))
            .map(slower)
            .collect();
        let report = last(&mut Locator::new(settings).unwrap(), rows);
        report.map_or(f64::INFINITY, |report| {
            distance([report.raw.position_m[0], report.raw.position_m[1]], place)
        })
    };
    let (true_m, false_m) = (error_m(C / 1.25), error_m(C));
    assert!(true_m < 30.0 && false_m > 300.0, "{true_m} {false_m}");
}

#[test]
fn a_moving_emitter_is_followed() {
    for (velocity, motion) in [([25.0, -10.0], MotionModel::Straight), ([0.0, 0.0], MotionModel::Fixed)] {
        let mut score = Score::default();
        for seed in 1..=40 {
            let mut network = Network::new(&CORNERS, seed);
            let place = |time: f64| [0, 1].map(|axis| 1e3 + velocity[axis] * time);
            let rows: Vec<_> = (0..120)
                .flat_map(|k| network.times(EMITTER, f64::from(k), place(f64::from(k))))
                .collect();
            let report = last(&mut locator(FilterChoice::Auto), rows);
            assert_eq!(report.map(|report| report.raw.motion), Some(motion), "seed {seed}");
            score.add(report, place(119.0));
        }
        assert!(
            score.missing == 0 && score.consistency() < 2.0,
            "{}",
            score.consistency()
        );
    }
}

#[test]
fn what_cannot_be_is_refused_and_counted() {
    let mut network = Network::new(&CORNERS, 1);
    let good = network.differences(EMITTER, 0.0, [1e3, 1e3])[0];
    let mut locator = locator(FilterChoice::Auto);
    let ArrivalTime::Between { receivers, .. } = good.time else {
        panic!()
    };
    let between = |receivers, tdoa_s| ArrivalTime::Between { receivers, tdoa_s };
    let bad = [
        Arrival { sigma_s: 0.0, ..good },
        Arrival {
            sigma_s: f64::NAN,
            ..good
        },
        Arrival {
            time: between(receivers, f64::NAN),
            ..good
        },
        Arrival {
            time: between([receivers[0]; 2], 0.0),
            ..good
        },
        Arrival {
            reference_m: Some([f64::INFINITY, 0.0, 0.0]),
            ..good
        },
    ];
    for arrival in bad {
        let refused = locator.arrival(&arrival);
        assert!(matches!(refused, Err(BearingRejection::Unusable(_))), "{arrival:?}");
    }
    let far = Arrival {
        time: between(receivers, 1e-3),
        ..good
    };
    assert_eq!(locator.arrival(&far), Err(BearingRejection::Impossible));
    let alone = network.times(EMITTER, 1.0, [1e3, 1e3])[0];
    assert_eq!(locator.arrival(&alone), Ok(None));
    assert_eq!(locator.complete(None), Some(Err(BearingRejection::Alone)));
    assert_eq!(locator.complete(None), None);
    let counts = locator.counts();
    assert_eq!(
        (counts.unusable, counts.impossible, counts.alone, counts.arrivals),
        (5, 1, 1, 2)
    );
}
