//! Reports of a simulated wide-area sensor, compared with the truth.

use observations::WideAreaReport;
use proptest::prelude::*;
use scenario::{FormationSettings, ScenarioSettings, SimulatedWideAreaSensor, Truth, WideAreaSettings};

const START_NS: i64 = 1_700_000_000_000_000_000;

fn formation() -> FormationSettings {
    FormationSettings {
        sizes: vec![(3, 1.0)],
        sector_rad: [0.3; 2],
        way_m: [90_000.0, 10_000.0],
        together_m: [70_000.0, 20_000.0],
        start_m: Some([89_000.0; 2]),
        speed_mps: [200.0; 2],
        ..FormationSettings::default()
    }
}

fn truth(formation: FormationSettings) -> Truth {
    let settings = ScenarioSettings {
        targets: 0,
        formations: vec![formation],
        ..ScenarioSettings::default()
    };
    Truth::new(&settings, 1).expect("valid")
}

fn sensor(settings: &WideAreaSettings, seed: u64) -> SimulatedWideAreaSensor {
    SimulatedWideAreaSensor::new(settings, seed, 0, START_NS).expect("valid")
}

/// Returns all reports of observations before `until_s`.
fn run(sensor: &mut SimulatedWideAreaSensor, truth: &Truth, until_s: f64) -> Vec<WideAreaReport> {
    let mut reports = Vec::new();
    while sensor.observed_s() < until_s {
        sensor.observe(truth, &mut reports);
    }
    reports
}

fn seconds(time_ns: i64) -> f64 {
    (time_ns - START_NS) as f64 / 1e9
}

fn middle(truth: &Truth, time_s: f64) -> [f64; 2] {
    let count = truth.len() as f64;
    [0, 1].map(|axis| truth.at(time_s).map(|target| target.position_m[axis]).sum::<f64>() / count)
}

/// Every period has one report of all three, as late and as inaccurate as set.
#[test]
fn reports_are_as_set() {
    let (truth, settings) = (
        truth(formation()),
        WideAreaSettings {
            period_s: 0.5,
            phase_s: 0.25,
            delay_s: 20.0,
            detection_probability: 0.7,
            count_wrong_probability: 0.2,
            resolution_m: 8000.0,
            ..WideAreaSettings::default()
        },
    );
    let reports = run(&mut sensor(&settings, 4), &truth, 1000.0);
    let close = |found: f64, expected: f64, sigma: f64| assert!((found - expected).abs() < 4.0 * sigma, "{found}");
    close(reports.len() as f64 / 2000.0, 0.7, (0.7f64 * 0.3 / 2000.0).sqrt());
    let count = reports.len() as f64;
    let share = |targets: u32| reports.iter().filter(|report| report.targets == targets).count() as f64 / count;
    close(share(3), 0.8, (0.8f64 * 0.2 / count).sqrt());
    close(share(2), 0.1, (0.1f64 * 0.9 / count).sqrt());
    close(share(2) + share(3) + share(4), 1.0, 1e-12);
    let (mut places, mut velocities) = (0.0, 0.0);
    for report in &reports {
        let time_s = seconds(report.time_ns);
        assert!(((time_s - 0.25) / 0.5).fract() == 0.0);
        assert_eq!(report.arrival_ns - report.time_ns, 20_000_000_000);
        assert_eq!(report.origin_m, None);
        let there = middle(&truth, time_s);
        let [before, after] = [-0.01, 0.01].map(|by| middle(&truth, time_s + by));
        for axis in 0..2 {
            let velocity = (after[axis] - before[axis]) / 0.02;
            places += ((report.position_m[axis] - there[axis]) / 1000.0).powi(2);
            velocities += ((report.velocity_mps[axis] - velocity) / 10.0).powi(2);
        }
    }
    for sum in [places, velocities] {
        close(sum / (2.0 * count), 1.0, (2.0 / (2.0 * count)).sqrt());
    }
}

/// Three targets 3 km apart are one group for a sensor of 4 km and three groups for a sensor of 1 km; a sensor that
/// counts to two reports two of them.
#[test]
fn groups_are_what_it_cannot_tell_apart() {
    let truth = truth(formation());
    for (resolution_m, counted_max, expected) in
        [(4000.0, 256, vec![3]), (4000.0, 2, vec![2]), (1000.0, 2, vec![1, 1, 1])]
    {
        let settings = WideAreaSettings {
            resolution_m,
            counted_max,
            ..WideAreaSettings::default()
        };
        let counts: Vec<u32> = run(&mut sensor(&settings, 1), &truth, 1.0)
            .iter()
            .map(|report| report.targets)
            .collect();
        assert_eq!(counts, expected);
    }
}

/// The origin is the position of the first sighting, at any later distance; the sensor reports nothing outside its
/// coverage.
#[test]
fn origins_stay_and_coverage_ends() {
    let truth = truth(formation());
    let settings = WideAreaSettings {
        origins: true,
        absence_s: 60.0,
        range_max_m: 60_000.0,
        position_sigma_m: 0.0,
        velocity_sigma_mps: 0.0,
        ..WideAreaSettings::default()
    };
    let reports = run(&mut sensor(&settings, 1), &truth, 900.0);
    let first = reports.first().expect("comes within 60 km");
    let away_m = first.position_m[0].hypot(first.position_m[1]);
    assert!((58_000.0..60_000.0).contains(&away_m), "{away_m}");
    let origin_m = first.origin_m.expect("is told");
    assert_eq!(origin_m, [first.position_m[0], first.position_m[1]]);
    let inward = reports.iter().filter(|report| seconds(report.time_ns) < 500.0);
    assert!(inward.clone().count() > 30);
    for report in inward {
        assert_eq!((report.targets, report.origin_m), (3, Some(origin_m)));
    }
    // The groups have left the coverage, which is no absence.
    assert!(reports.iter().all(|report| report.targets > 0));
    let last_s = seconds(reports.last().expect("some").time_ns);
    assert!(last_s < 850.0, "{last_s}");
}

/// After a group has descended below the coverage, the sensor reports zero targets for a while, moved along the
/// group's path.
#[test]
fn absence_is_reported_where_a_group_has_vanished() {
    let low = FormationSettings {
        height_m: 1000.0,
        low_m: Some(20.0),
        ..formation()
    };
    let truth = truth(low);
    let settings = WideAreaSettings {
        absence_s: 40.0,
        period_s: 4.0,
        position_sigma_m: 0.0,
        velocity_sigma_mps: 0.0,
        ..WideAreaSettings::default()
    };
    let reports = run(&mut sensor(&settings, 1), &truth, 500.0);
    let vanished = reports
        .iter()
        .position(|report| report.targets == 0)
        .expect("they vanish");
    let (before, absences) = reports.split_at(vanished);
    assert!(before.iter().all(|report| report.targets == 3));
    assert_eq!(absences.len(), 10, "for 40 s: {absences:?}");
    let last = before.last().expect("were there");
    for report in absences {
        let seconds = (report.time_ns - last.time_ns) as f64 / 1e9;
        assert_eq!((report.targets, report.origin_m), (0, None));
        for axis in 0..2 {
            let moved = last.position_m[axis] + last.velocity_mps[axis] * seconds;
            assert!((report.position_m[axis] - moved).abs() < 1e-6);
        }
    }
    let silent = WideAreaSettings {
        absence_s: 0.0,
        ..settings
    };
    assert_eq!(run(&mut sensor(&silent, 1), &truth, 500.0), before);
}

#[test]
fn messages_name_key_value_and_limit() {
    settings::check(&WideAreaSettings::default()).expect("defaults are usable");
    let read = |text: &str| {
        let document = settings::Document::parse(text, &[]).expect("well-formed");
        document.read::<WideAreaSettings>().map_err(|error| error.to_string())
    };
    for (text, expected) in [
        (
            "period_s = 0",
            "period_s: 0 is out of range; it must lie between 0.1 and 600",
        ),
        ("phase_s = 9", "phase_s: 9 is out of range; it must lie between 0 and 8"),
        (
            "delay_s = -1",
            "delay_s: -1 is out of range; it must lie between 0 and 600",
        ),
        (
            "count_wrong_probability = nan",
            "count_wrong_probability: NaN is out of range; it must lie between 0 and 1",
        ),
        (
            "counted_max = 0",
            "counted_max: 0 is out of range; it must lie between 1 and 256",
        ),
        (
            "absence_s = 121",
            "absence_s: 121 is out of range; it must lie between 0 and 120",
        ),
    ] {
        assert_eq!(read(text).expect_err("not usable"), expected);
    }
    assert!(read("count = 2").is_err(), "unknown key");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// The same settings and seed give the same reports; counts add up to the covered targets; and a sensor started
    /// later reports the same, except for remembered values.
    #[test]
    fn reports_follow_from_seed_and_time(seed: u64, delay_s in 0.0..30.0f64, resolution_m in 100.0..20e3f64, later_s in 0.0..300.0f64) {
        let world = ScenarioSettings {
            formations: vec![FormationSettings { count: 5, ..FormationSettings::default() }],
            ..ScenarioSettings::default()
        };
        let truth = Truth::new(&world, seed).expect("valid");
        let settings = WideAreaSettings { delay_s, resolution_m, range_max_m: 80e3, ..WideAreaSettings::default() };
        let reports = run(&mut sensor(&settings, seed), &truth, 400.0);
        prop_assert_eq!(&reports, &run(&mut sensor(&settings, seed), &truth, 400.0));
        prop_assert!(reports.is_sorted_by_key(|report| report.arrival_ns));
        for time_ns in reports.iter().map(|report| report.time_ns) {
            let counted: u32 = reports.iter().filter(|report| report.time_ns == time_ns).map(|report| report.targets).sum();
            let covered = truth.at(seconds(time_ns)).filter(|target| {
                let [east, north, up] = target.position_m;
                east.hypot(north) <= 80e3 && up >= 300.0
            });
            prop_assert_eq!(counted as usize, covered.count());
        }
        let mut late = sensor(&settings, seed);
        late.restart_at(later_s);
        prop_assert!(late.next_delivery_s() >= later_s && late.next_delivery_s() < later_s.max(delay_s) + 8.0);
        let begun_ns = START_NS + (late.observed_s() * 1e9).round() as i64;
        let expected: Vec<_> = reports.into_iter().filter(|report| report.time_ns >= begun_ns).collect();
        prop_assert_eq!(run(&mut late, &truth, 400.0), expected);
    }
}
