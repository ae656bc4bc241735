//! One wrong source of several: the others move no target, and no other source is corrected.
//!
//! Every way in which the source may be wrong is compared with the run in which the source is silent: how far, in which
//! direction to the traffic, from the first report on or later, and with which stated accuracy. If all targets fly in
//! one direction, an error along it looks like a wrong clock.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use fusion::Engine;
use fusion::settings::{AccuracyTable, Settings, SourceSettings, Weighing};
use messages::{Covariance, Identity, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use test_support::{Random, S};

const SIGMA_M: f64 = 20.0;
const SPEED_MPS: f64 = 100.0;
/// Time at which a step or a drift begins, and after which the targets are shown in any case, seconds.
const CHANGE_S: f64 = 40.0;
/// The target that a source leads off.
const LED_OFF: u32 = 7;
/// Time for which a source is named before an alarm is raised, seconds.
const RAISED_S: u32 = 5;
/// Scans after which the errors count.
const SETTLED_S: f64 = 5.0;

/// How targets fly.
#[derive(Clone, Copy, Debug)]
enum Traffic {
    Parallel,
    TwoWay,
    Random,
}

/// What the last source reports.
#[derive(Clone, Copy, Debug)]
enum Wrong {
    Silent,
    /// Off by so many metres from its first report on, which comes late.
    Off(f64),
    /// Off by so many metres from some time on.
    Step(f64),
    /// Led off by so many metres per second.
    Drift(f64),
    /// The same, one target alone; its errors alone count.
    LeadsOff(f64),
}

#[derive(Clone, Copy, Debug)]
struct Case {
    traffic: Traffic,
    wrong: Wrong,
    /// Direction of the error, radians clockwise from north.
    bearing_rad: f64,
    honest: usize,
    /// Standard deviation that the wrong source states, metres.
    claim_m: f64,
    targets: u32,
    seed: u64,
}

impl Case {
    fn heading_rad(&self, target: u32) -> f64 {
        match self.traffic {
            Traffic::Parallel => 0.25 * TAU,
            Traffic::TwoWay => (0.25 + 0.5 * f64::from(target % 2)) * TAU,
            Traffic::Random => f64::from(target) * 2.4,
        }
    }

    fn velocity_mps(&self, target: u32) -> [f64; 2] {
        let (east, north) = self.heading_rad(target).sin_cos();
        [SPEED_MPS * east, SPEED_MPS * north]
    }

    fn place_m(&self, target: u32, time_s: f64) -> [f64; 2] {
        let [east, north] = self.velocity_mps(target);
        let (column, row) = (f64::from(target % 10), f64::from(target / 10));
        [column * 6e3 - 30e3 + east * time_s, row * 6e3 - 30e3 + north * time_s]
    }

    /// Error of the last source in its direction, metres; `None` while it is silent.
    fn error_m(&self, target: u32, time_s: f64) -> Option<f64> {
        let since_s = time_s - CHANGE_S;
        match self.wrong {
            Wrong::LeadsOff(_) if target != LED_OFF || since_s < 0.0 => Some(0.0),
            Wrong::LeadsOff(by_mps) => Some(by_mps * since_s),
            Wrong::Silent => None,
            Wrong::Off(_) if since_s < 0.0 => None,
            Wrong::Off(by_m) => Some(by_m),
            Wrong::Step(_) | Wrong::Drift(_) if since_s < 0.0 => Some(0.0),
            Wrong::Step(by_m) => Some(by_m),
            Wrong::Drift(by_mps) => Some(by_mps * since_s),
        }
    }

    fn end_s(&self) -> f64 {
        match self.wrong {
            Wrong::Drift(_) | Wrong::LeadsOff(_) => CHANGE_S + 60.0,
            _ => CHANGE_S + 25.0,
        }
    }

    /// Runs until a time.
    fn run(&self, until_s: f64) -> Outcome {
        let sources = (0..=self.honest as u32).map(|number| {
            let (name, weighing) = (format!("source-{number}"), Weighing::default());
            SourceSettings::new(&name, &weighing, (1.0, number), [0.0; 2], &AccuracyTable::default()).unwrap()
        });
        let mut engine = Engine::new(Settings::default().with_sources(sources.collect()).unwrap()).unwrap();
        let (mut random, mut errors_m, mut sigmas_m) = (BTreeMap::new(), Vec::new(), Vec::new());
        let mut named = BTreeMap::<(u16, bool), u32>::new();
        let leads_off = matches!(self.wrong, Wrong::LeadsOff(_));
        let settled_s = if leads_off { 18.0 } else { SETTLED_S };
        let (towards_east, towards_north) = self.bearing_rad.sin_cos();
        for scan in 0..until_s as u32 {
            for source in 0..=self.honest as u16 {
                for error in [
                    engine.sources().gross_error(source),
                    engine.sources().contradiction(source),
                ]
                .into_iter()
                .flatten()
                {
                    *named.entry((source, error.is_certain)).or_default() += 1;
                }
            }
            for source in 0..=self.honest {
                for target in 0..self.targets {
                    let share = source as f64 / (self.honest + 1) as f64 + 2e-4 * f64::from(target);
                    let time_s = f64::from(scan) + share;
                    let is_wrong = source == self.honest;
                    let Some(error_m) = (if is_wrong {
                        self.error_m(target, time_s)
                    } else {
                        Some(0.0)
                    }) else {
                        continue;
                    };
                    let sigma_m = if is_wrong { self.claim_m } else { SIGMA_M };
                    let noise = random
                        .entry(source)
                        .or_insert_with(|| Random::new(self.seed + 99 * source as u64));
                    let mut normal = || (0..12).map(|_| noise.unit()).sum::<f64>() - 6.0;
                    let [east, north] = self.place_m(target, time_s);
                    let noise_m = [sigma_m * normal(), sigma_m * normal()];
                    let place_m = [
                        east + error_m * towards_east + noise_m[0],
                        north + error_m * towards_north + noise_m[1],
                        150.0,
                    ];
                    let [east_mps, north_mps] = self.velocity_mps(target);
                    let report = SensorTrack {
                        time_of_measurement_ns: (time_s * S as f64) as i64,
                        source: source as u16,
                        track_number: target + 1,
                        valid: sensor_track_bits::VELOCITY,
                        position_m: place_m,
                        velocity_mps: [east_mps, north_mps, 0.0],
                        covariance: Covariance::diagonal([sigma_m, sigma_m, 30.0], [3.0; 3]),
                        identity: Identity::default().with_address(0x40_0000 + target),
                        state: TrackState::Confirmed as u8,
                        ..SensorTrack::default()
                    };
                    engine.take(&report, &mut |track: &SystemTrack| {
                        if track.state != TrackState::Confirmed as u8 || time_s < CHANGE_S + settled_s {
                            return;
                        }
                        let target = track.identity.address().unwrap() - 0x40_0000;
                        if leads_off && target != LED_OFF {
                            return;
                        }
                        let [east, north] = self.place_m(target, track.reference_time_ns as f64 / S as f64);
                        sigmas_m.push((track.covariance.get(0, 0) + track.covariance.get(1, 1)).sqrt());
                        errors_m.push((track.position_m[0] - east).hypot(track.position_m[1] - north));
                    });
                }
            }
        }
        let corrected =
            (0..=self.honest).filter(|source| engine.sources().source_errors(*source as u16).unwrap().removed[0]);
        assert!(
            errors_m.len() as f64 > 6.0 * f64::from(if leads_off { 1 } else { self.targets }),
            "{self:?}: {}",
            errors_m.len()
        );
        Outcome {
            error_m: median(errors_m),
            sigma_m: median(sigmas_m),
            corrected: corrected.collect(),
            named: named
                .into_iter()
                .filter(|(_, seconds)| *seconds >= RAISED_S)
                .map(|(named, _)| named)
                .collect(),
        }
    }

    /// Checks that the error is no more than `limit` times that without the wrong source, and who is named.
    fn check(&self, limit: f64) {
        let until_s = self.end_s();
        let beside = self.run(until_s);
        let without = Self {
            wrong: Wrong::Silent,
            ..*self
        }
        .run(until_s);
        assert!(
            beside.error_m <= limit * without.error_m,
            "{self:?}: {:.1} m beside the wrong source, {:.1} m without it",
            beside.error_m,
            without.error_m
        );
        let wrong = self.honest;
        assert!(
            beside.corrected.iter().all(|source| *source == wrong),
            "{self:?}: {:?} are corrected",
            beside.corrected
        );
        let expected = [(wrong as u16, true)];
        let is_of_one = matches!(self.wrong, Wrong::LeadsOff(_));
        assert_eq!(beside.named, if is_of_one { &[][..] } else { &expected }, "{self:?}");
        assert_eq!(without.named, [], "{self:?} silent");
    }
}

/// What a run came to, since the change but for the first scans.
#[derive(Debug)]
struct Outcome {
    /// Median error of all states, and median of the stated standard deviation, metres.
    error_m: f64,
    sigma_m: f64,
    /// Sources of which an offset is removed at the end.
    corrected: Vec<usize>,
    /// Sources that were named as wrong for long enough for an alarm, and whether that was certain.
    named: Vec<(u16, bool)>,
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

const DEGREE: f64 = TAU / 360.0;

fn each_case(wrongs: &[Wrong], limit: f64) {
    let mut seed = 1;
    for traffic in [Traffic::Parallel, Traffic::TwoWay, Traffic::Random] {
        for bearing_deg in [0.0, 45.0, 90.0] {
            for (place, wrong) in wrongs.iter().enumerate() {
                seed += 1;
                // Each claim and each number of honest sources meets each direction and each traffic.
                for (honest, claim_m) in [(2, 1.0), (2 + 2 * (place % 2), 20.0)] {
                    Case {
                        traffic,
                        wrong: *wrong,
                        bearing_rad: bearing_deg * DEGREE,
                        honest,
                        claim_m,
                        targets: 50,
                        seed,
                    }
                    .check(limit);
                }
            }
        }
    }
}

#[test]
fn a_source_that_is_off_from_its_first_report_on_moves_no_target() {
    each_case(
        &[
            Wrong::Off(30.0),
            Wrong::Off(100.0),
            Wrong::Off(300.0),
            Wrong::Off(2000.0),
        ],
        1.3,
    );
}

#[test]
fn a_source_that_steps_aside_moves_no_target() {
    each_case(
        &[
            Wrong::Step(30.0),
            Wrong::Step(60.0),
            Wrong::Step(150.0),
            Wrong::Step(300.0),
            Wrong::Step(2000.0),
        ],
        1.3,
    );
}

#[test]
fn a_source_that_is_led_off_slowly_moves_targets_little() {
    each_case(&[Wrong::Drift(2.0)], 2.0);
}

#[test]
fn where_nobody_can_decide_the_stated_accuracy_contains_both() {
    for bearing_deg in [0.0, 45.0, 90.0] {
        for claim_m in [1.0, 20.0] {
            let case = |honest: usize| Case {
                traffic: Traffic::Parallel,
                wrong: Wrong::Step(300.0),
                bearing_rad: bearing_deg * DEGREE,
                honest,
                claim_m,
                targets: 50,
                seed: 3,
            };
            // One against one: neither is named.
            let outcome = case(1).run(CHANGE_S + 40.0);
            assert!(
                outcome.error_m < 2.0 * outcome.sigma_m && outcome.sigma_m > 150.0,
                "{outcome:?}"
            );
            assert!((130.0..190.0).contains(&outcome.error_m), "the middle: {outcome:?}");
            assert_eq!(outcome.named, [(0, false)], "{bearing_deg}, {claim_m}");
            // Two against one: they may be the wrong ones. Four are not.
            let outcome = case(2).run(CHANGE_S + 40.0);
            assert!((140.0..200.0).contains(&outcome.sigma_m), "{outcome:?}");
            let outcome = case(4).run(CHANGE_S + 40.0);
            assert!(outcome.sigma_m < 60.0, "{outcome:?}");
        }
    }
}

#[test]
fn a_source_that_leads_one_target_off_is_not_followed() {
    // By chance, the medians of one target differ by a half. If the source is followed, the ratio is 10 and more.
    each_case(
        &[Wrong::LeadsOff(3.0), Wrong::LeadsOff(10.0), Wrong::LeadsOff(30.0)],
        3.0,
    );
}

#[test]
fn a_new_source_draws_few_targets_to_itself_no_more_than_many() {
    for bearing_deg in [0.0, 90.0] {
        let case = Case {
            traffic: Traffic::Random,
            wrong: Wrong::Off(100.0),
            bearing_rad: bearing_deg * DEGREE,
            honest: 4,
            claim_m: 1.0,
            targets: 3,
            seed: 1,
        };
        // Of three targets, the medians differ by a third by chance.
        let until_s = CHANGE_S + 12.0;
        let beside_m = case.run(until_s).error_m;
        let without_m = Case {
            wrong: Wrong::Silent,
            ..case
        }
        .run(until_s)
        .error_m;
        assert!(
            beside_m < 2.0 * without_m,
            "{case:?}: {beside_m:.1} m, {without_m:.1} m without it"
        );
    }
}
