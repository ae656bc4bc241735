//! Simulated sensors, compared with their settings and the truth.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::f64::consts::{PI, TAU};

use estimation::{ComparedComponents, Gaussian, statistical_distance};
use messages::{SensorTrack, TrackState, sensor_track_bits};
use proptest::prelude::*;
use scenario::{
    ScenarioSettings, SensorIdentity, SensorKind, SensorSettings, SimulatedSensor, TargetKind, TargetState, Truth,
};

const START_NS: i64 = 1_700_000_000_000_000_000;

fn truth(seed: u64) -> Truth {
    Truth::new(&ScenarioSettings::default(), seed).expect("valid")
}

fn sensor(settings: &SensorSettings, seed: u64) -> SimulatedSensor {
    SimulatedSensor::new(settings, seed, 3, START_NS).expect("valid")
}

/// Returns all reports delivered before `until_s`.
fn run(sensor: &mut SimulatedSensor, truth: &Truth, until_s: f64) -> Vec<SensorTrack> {
    let mut reports = Vec::new();
    while sensor.next_scan_time_s() < until_s {
        sensor.scan(truth, &mut reports);
    }
    reports
}

fn seconds(report: &SensorTrack) -> f64 {
    (report.time_of_measurement_ns - START_NS) as f64 / 1e9
}

/// Returns the target of a report from a sensor with addresses.
fn target_of(report: &SensorTrack, truth: &Truth) -> TargetState {
    let address = report.identity.address().expect("has an address");
    truth
        .at(seconds(report))
        .find(|target| target.address == address)
        .expect("a target has it")
}

fn with_addresses(kind: SensorKind) -> SensorSettings {
    SensorSettings {
        identity: Some(SensorIdentity::Full),
        ..SensorSettings::new(kind)
    }
}

const KINDS: [SensorKind; 3] = [SensorKind::Radar, SensorKind::Multilateration, SensorKind::AdsB];

#[test]
fn same_seed_same_reports_and_another_seed_others() {
    let truth = truth(1);
    for (name, settings) in SensorSettings::demonstration() {
        let reports = run(&mut sensor(&settings, 1), &truth, 60.0);
        assert!(reports.len() > 400, "{name}: {}", reports.len());
        assert_eq!(reports, run(&mut sensor(&settings, 1), &truth, 60.0), "{name}");
        assert_ne!(reports, run(&mut sensor(&settings, 2), &truth, 60.0), "{name}");
    }
}

/// Measurements depend on time, not on earlier requests: a sensor started later measures the same.
#[test]
fn restarted_sensors_measure_the_same_and_give_new_numbers() {
    let truth = truth(1);
    for (name, settings) in SensorSettings::demonstration() {
        let mut whole = sensor(&settings, 5);
        run(&mut whole, &truth, 100.0);
        let mut late = sensor(&settings, 5);
        late.restart_at(100.0);
        assert_eq!(late.next_scan_time_s(), whole.next_scan_time_s(), "{name}");
        let measured = |reports: Vec<SensorTrack>| -> BTreeMap<(i64, u64, u64), [f64; 3]> {
            reports
                .iter()
                .filter(|report| report.has(sensor_track_bits::MEASURED))
                .map(|report| {
                    let [x, y, _] = report.measured_m.map(f64::to_bits);
                    ((report.time_of_measurement_ns, x, y), report.measured_m)
                })
                .collect()
        };
        let whole = run(&mut whole, &truth, 130.0);
        let late = run(&mut late, &truth, 130.0);
        let numbers: HashSet<u32> = whole.iter().map(|report| report.track_number).collect();
        let restarted = late.iter().filter(|report| report.state != TrackState::Tentative as u8);
        for report in restarted.take(1000) {
            assert!(!numbers.contains(&report.track_number), "{name}");
        }
        let (whole, late) = (measured(whole), measured(late));
        // False targets that began before the restart are missing.
        let common = late.keys().filter(|key| whole.contains_key(key)).count();
        assert!(common == late.len() && whole.len() - common <= 20, "{name}");
    }
}

#[test]
fn reports_come_once_per_period() {
    let truth = truth(2);
    for kind in KINDS {
        let settings = SensorSettings {
            detection_probability: Some(1.0),
            equipped_share: Some(1.0),
            ..with_addresses(kind)
        };
        let mut sensor = sensor(&settings, 4);
        let period_s = sensor.period_s();
        let reports = run(&mut sensor, &truth, 50.0 * period_s + 0.5);
        let mut latest: HashMap<u32, f64> = HashMap::new();
        let mut counts: HashMap<u32, u32> = HashMap::new();
        for report in &reports {
            let number = report.track_number;
            *counts.entry(number).or_default() += 1;
            if let Some(before) = latest.insert(number, seconds(report)) {
                let gap_s = seconds(report) - before;
                let jitter = if kind == SensorKind::AdsB { 0.21 } else { 0.05 };
                assert!((gap_s - period_s).abs() <= jitter * period_s, "{kind:?}: {gap_s} s");
            }
        }
        let seen = truth
            .at(0.0)
            .filter(|target| kind != SensorKind::Radar || target.position_m[2] > 300.0)
            .count();
        assert!(counts.len() >= seen, "{kind:?}");
        // Circuits land, so a radar loses a few.
        let steady = counts.values().filter(|count| (49..=51).contains(*count)).count();
        assert!(steady + 12 >= seen, "{kind:?}: {steady} of {seen}");
    }
}

#[test]
fn deliveries_follow_the_measurements() {
    let truth = truth(2);
    for (name, settings) in SensorSettings::demonstration() {
        let mut sensor = sensor(&settings, 4);
        let mut reports = Vec::new();
        let mut before_s = f64::NEG_INFINITY;
        for _ in 0..200 {
            let (due_s, progress_s) = (sensor.next_scan_time_s(), sensor.progress_s());
            assert!(due_s > before_s, "{name}");
            before_s = due_s;
            reports.clear();
            sensor.scan(&truth, &mut reports);
            assert!(reports.is_sorted_by_key(|report| report.time_of_measurement_ns));
            for report in &reports {
                assert!(seconds(report) <= due_s + 1e-6, "{name}");
                assert!(seconds(report) >= progress_s - 1e-6, "{name}");
            }
        }
    }
}

/// A radar measures each target when its antenna points at it: azimuth and time belong together.
#[test]
fn antenna_points_at_what_it_measures() {
    let truth = truth(1);
    let settings = SensorSettings {
        phase_s: Some(1.3),
        position_m: Some([10_000.0, -5000.0, 0.0]),
        ..with_addresses(SensorKind::Radar)
    };
    let reports = run(&mut sensor(&settings, 1), &truth, 60.0);
    for report in &reports {
        let target = target_of(report, &truth);
        let [x, y, _] = target.position_m;
        let azimuth = (x - 10_000.0).atan2(y + 5000.0) / std::f64::consts::TAU;
        let antenna = (seconds(report) - 1.3) / 4.0;
        let apart = (azimuth - antenna + 0.5).rem_euclid(1.0) - 0.5;
        assert!(apart.abs() < 1e-5, "{apart} turns");
    }
}

/// Measurement errors, normalised by the stated standard deviations, are chi-square; detections are as frequent as
/// stated. The seed is fixed, so the outcome is reproducible.
#[test]
fn statistics_are_as_set() {
    let truth = truth(3);
    for kind in KINDS {
        let settings = with_addresses(kind);
        let reports = run(&mut sensor(&settings, 9), &truth, 400.0);
        let (mut sum, mut count, mut missed) = (0.0, 0u32, 0u32);
        for report in &reports {
            let target = target_of(report, &truth);
            if !report.has(sensor_track_bits::MEASURED) {
                missed += u32::from(target.position_m[2] > 300.0);
                continue;
            }
            let height_sigma = match kind {
                SensorKind::Radar => 15.0,
                SensorKind::Multilateration => 20.0,
                SensorKind::AdsB => 10.0,
            };
            let error = (report.measured_m[2] - target.position_m[2]) / height_sigma;
            sum += error * error;
            count += 1;
        }
        let average = sum / f64::from(count);
        let bound = 4.0 * (2.0 / f64::from(count)).sqrt();
        assert!((average - 1.0).abs() < bound, "{kind:?}: {average}");
        let probability = match kind {
            SensorKind::Radar => 0.95,
            SensorKind::Multilateration => 0.98,
            SensorKind::AdsB => 0.97,
        };
        let share = f64::from(count) / f64::from(count + missed);
        assert!((share - probability).abs() < 0.012, "{kind:?}: {share}");
    }
}

/// The sensor's own covariance is consistent where its model is valid: straight flight.
#[test]
fn local_tracks_are_consistent() {
    let truth = truth(3);
    for kind in KINDS {
        let reports = run(&mut sensor(&with_addresses(kind), 9), &truth, 300.0);
        let (mut sum, mut count) = (0.0, 0u32);
        for report in reports.iter().filter(|report| seconds(report) > 60.0) {
            let target = target_of(report, &truth);
            if target.kind != TargetKind::EnRoute {
                continue;
            }
            let exact = Gaussian::new(target.position_m, target.velocity_mps, &messages::Covariance::default());
            let track = Gaussian::new(report.position_m, report.velocity_mps, &report.covariance);
            let distance = statistical_distance(&track, &exact, ComparedComponents::PositionAndVelocity);
            assert!(distance.is_finite());
            sum += distance;
            count += 1;
        }
        // Six degrees of freedom; the model allows for more acceleration than a long leg has, and less than a turn.
        let average = sum / f64::from(count);
        assert!((3.0..=7.0).contains(&average), "{kind:?}: {average} over {count}");
    }
}

#[test]
fn tracks_live_and_die_as_set() {
    let truth = truth(1);
    let settings = SensorSettings {
        dropouts_per_hour: Some(30.0),
        dropout_duration_s: Some(20.0),
        ..with_addresses(SensorKind::Radar)
    };
    let reports = run(&mut sensor(&settings, 1), &truth, 600.0);
    let mut tracks: BTreeMap<u32, Vec<&SensorTrack>> = BTreeMap::new();
    for report in &reports {
        tracks.entry(report.track_number).or_default().push(report);
    }
    let mut addresses = HashSet::new();
    let mut returned = 0;
    for reports in tracks.values() {
        let state = |report: &SensorTrack| TrackState::from_code(report.state).expect("known");
        assert_eq!(state(reports[0]), TrackState::Tentative);
        let ended = reports
            .iter()
            .position(|report| state(report) == TrackState::Terminated);
        assert!(
            ended.is_none_or(|place| place == reports.len() - 1),
            "said once, and last"
        );
        let address = reports[0].identity.address();
        assert!(reports.iter().all(|report| report.identity.address() == address));
        returned += u32::from(!addresses.insert(address));
    }
    // About 60 targets, five dropouts each, every one long enough to end the track.
    assert!(returned > 150, "{returned}");
}

#[test]
fn false_tracks_are_as_many_as_set_and_anonymous() {
    let truth = truth(1);
    let settings = SensorSettings {
        false_tracks_per_period: Some(2.0),
        detection_probability: Some(1.0),
        ..with_addresses(SensorKind::Radar)
    };
    let reports = run(&mut sensor(&settings, 1), &truth, 800.0);
    let false_numbers: HashSet<u32> = reports
        .iter()
        .filter(|report| report.identity.address().is_none())
        .map(|report| report.track_number)
        .collect();
    // 200 periods with two each; false targets shorter than a turn often stay undetected.
    assert!((250..=450).contains(&false_numbers.len()), "{}", false_numbers.len());
}

#[test]
fn coverage_and_identity() {
    let truth = truth(1);
    let near = SensorSettings {
        range_max_m: Some(40_000.0),
        ..with_addresses(SensorKind::Multilateration)
    };
    let mut vehicles = 0;
    for report in run(&mut sensor(&near, 1), &truth, 20.0) {
        let target = target_of(&report, &truth);
        if report.has(sensor_track_bits::MEASURED) {
            assert!(target.position_m[0].hypot(target.position_m[1]) <= 40_000.0);
        }
        assert_eq!(report.identity.mode_3a(), target.mode_3a);
        assert_eq!(report.has(sensor_track_bits::ON_GROUND), target.on_ground);
        assert_eq!(report.source, 3);
        vehicles += u32::from(target.kind == TargetKind::Surface);
    }
    assert!(vehicles > 200);

    let primary = SensorSettings {
        identity: Some(SensorIdentity::None),
        ..SensorSettings::new(SensorKind::Radar)
    };
    for report in run(&mut sensor(&primary, 1), &truth, 20.0) {
        assert_eq!(report.identity, messages::Identity::default());
        assert!(!report.has(sensor_track_bits::HEIGHT));
        assert_eq!((report.position_m[2], report.velocity_mps[2]), (0.0, 0.0));
    }
}

/// Heights between the limits are observed, heights above the upper limit are not.
#[test]
fn targets_above_the_greatest_height_are_not_observed() {
    let truth = truth(1);
    let highest_m = |height_max_m: Option<f64>| {
        let settings = SensorSettings {
            height_max_m,
            ..with_addresses(SensorKind::Multilateration)
        };
        let reports = run(&mut sensor(&settings, 1), &truth, 60.0);
        let measured = reports.iter().filter(|report| report.has(sensor_track_bits::MEASURED));
        let heights_m = measured.map(|report| target_of(report, &truth).position_m[2]);
        heights_m.fold(f64::NEG_INFINITY, f64::max)
    };
    // The limit is a height above the ellipsoid, the position is in the plane of the system frame.
    let highest = (highest_m(None), highest_m(Some(3000.0)));
    assert!(
        highest.0 > 5000.0 && (1000.0..=3000.0).contains(&highest.1),
        "{highest:?}"
    );
}

/// The errors of each horizontal axis have the stated standard deviation.
#[test]
fn horizontal_errors_are_as_set() {
    let truth = truth(3);
    for kind in [SensorKind::Multilateration, SensorKind::AdsB] {
        let settings = SensorSettings {
            horizontal_sigma_m: Some(70.0),
            ..with_addresses(kind)
        };
        let reports = run(&mut sensor(&settings, 9), &truth, 60.0);
        let measured = reports.iter().filter(|report| report.has(sensor_track_bits::MEASURED));
        let (mut squares, mut count) = ([0.0; 2], 0.0);
        for report in measured {
            let exact_m = target_of(report, &truth).position_m;
            for axis in 0..2 {
                squares[axis] += (report.measured_m[axis] - exact_m[axis]).powi(2);
            }
            count += 1.0;
        }
        // Four standard deviations of a mean of squares.
        let bound = 4.0 * (2.0_f64 / count).sqrt();
        for sum in squares {
            let ratio = sum / count / 70.0_f64.powi(2);
            assert!((ratio - 1.0).abs() < bound, "{kind:?}: {ratio}, {count} measurements");
        }
    }
}

/// The means of the errors of a radar are its biases.
#[test]
fn biases_of_a_radar_shift_range_and_azimuth() {
    let truth = truth(3);
    let settings = SensorSettings {
        range_bias_m: Some(250.0),
        azimuth_bias_rad: Some(0.02),
        ..with_addresses(SensorKind::Radar)
    };
    let reports = run(&mut sensor(&settings, 9), &truth, 200.0);
    let (mut range_m, mut azimuth_rad, mut count) = (0.0, 0.0, 0.0);
    for report in reports.iter().filter(|report| report.has(sensor_track_bits::MEASURED)) {
        let exact_m = target_of(report, &truth).position_m;
        let [measured, exact] = [report.measured_m, exact_m].map(|[x, y, _]| (x.hypot(y), x.atan2(y)));
        range_m += measured.0 - exact.0;
        azimuth_rad += (measured.1 - exact.1 + PI).rem_euclid(TAU) - PI;
        count += 1.0;
    }
    let (range_m, azimuth_rad) = (range_m / count, azimuth_rad / count);
    assert!((range_m - 250.0).abs() < 10.0, "{range_m} m over {count} measurements");
    assert!(
        (azimuth_rad - 0.02).abs() < 2e-4,
        "{azimuth_rad} over {count} measurements"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_start_is_found_at_once(time_s in 0.0..1e6f64, phase in 0.0..1.0f64, deliveries in 1u32..64) {
        for kind in KINDS {
            let settings = SensorSettings {
                phase_s: Some(phase),
                deliveries_per_period: Some(deliveries),
                ..SensorSettings::new(kind)
            };
            let mut sensor = sensor(&settings, 1);
            let length_s = sensor.period_s() / f64::from(deliveries);
            sensor.restart_at(time_s);
            let due_s = sensor.next_scan_time_s();
            prop_assert!(due_s >= time_s);
            prop_assert!(due_s < time_s + length_s + 1e-6 || due_s <= phase + length_s + 0.03);
        }
    }
}

#[test]
fn observes_exactly_the_targets_that_it_reports() {
    let truth = truth(2);
    for kind in KINDS {
        let settings = SensorSettings {
            range_max_m: Some(60_000.0),
            equipped_share: Some(0.7),
            ..with_addresses(kind)
        };
        let mut sensor = sensor(&settings, 5);
        let reported: HashSet<u32> = run(&mut sensor, &truth, 120.0)
            .iter()
            .map(|report| target_of(report, &truth).id)
            .collect();
        let mut observed = HashSet::new();
        for step in 0..1200 {
            let targets = truth.at(f64::from(step) * 0.1);
            observed.extend(targets.filter(|target| sensor.observes(target)).map(|target| target.id));
        }
        // A target that left or entered the coverage at an end of the run may have been missed.
        assert!(reported.is_subset(&observed), "{kind:?}");
        assert!(
            reported.len() + 2 >= observed.len() && observed.len() < 70,
            "{kind:?} {}",
            observed.len()
        );
    }
}
