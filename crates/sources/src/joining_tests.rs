use observations::{DetectionKind, DetectionPlatform, TransponderReply};
use proptest::prelude::*;
use test_support::S;

use super::*;

fn detection(sensor_id: u32, scan: u32, time_ns: i64) -> SensorEvent {
    SensorEvent::Detection(Detection {
        time_of_measurement_ns: time_ns,
        sensor_id,
        scan,
        detection_id: 0,
        kind: DetectionKind::Position2,
        values: [0.0; 3],
        range_rate_mps: None,
        sigmas: None,
        platform_m: [0.0; 3],
        platform: DetectionPlatform::default(),
        reply: TransponderReply::default(),
        truth: None,
    })
}

fn cutter(boundaries: Boundaries, period_ns: i64) -> CutterSettings {
    CutterSettings {
        boundaries,
        period_ns: Some(period_ns),
        wait_ns: Some(0),
        waiting_max: 1000,
        epoch_ns: 0,
    }
}

fn settings(cutters: Vec<CutterSettings>, wait_ns: i64) -> JoiningSettings {
    JoiningSettings { cutters, wait_ns }
}

fn two(wait_ns: i64) -> ScanJoiner {
    let stated = cutter(Boundaries::Stated, S);
    ScanJoiner::new(&[1, 2], &settings(vec![stated; 2], wait_ns), 0).unwrap()
}

/// Sensor, scan number and time of the scans that are released.
fn released(joiner: &mut ScanJoiner) -> Vec<(u32, u32, i64)> {
    let mut scans = Vec::new();
    while let Some(scan) = joiner.next_scan() {
        scans.push((scan.sensor_id, scan.number, scan.time_ns));
    }
    scans
}

#[test]
fn a_scan_waits_for_the_other_sensor_and_not_longer_than_stated() {
    let mut joiner = two(10 * S);
    let mut take = |sensor: usize, scan, time_s: i64| {
        joiner.take(sensor, &detection(sensor as u32 + 1, scan, time_s * S), 0);
        released(&mut joiner)
    };
    assert_eq!(take(0, 1, 1), []);
    // The scan of time 1 is complete, but the second sensor may still have an earlier one.
    assert_eq!(take(0, 2, 3), []);
    // The second sensor's scan at hand is later.
    assert_eq!(take(1, 1, 2), [(1, 1, S)]);
    assert_eq!(take(1, 2, 4), [(2, 1, 2 * S)]);
    // The second sensor falls silent: after ten seconds the first is not kept waiting.
    assert_eq!(take(0, 3, 5), [(1, 2, 3 * S)]);
    assert_eq!(take(0, 4, 14), []);
    assert_eq!(take(0, 5, 15), [(2, 2, 4 * S)]);
    // A scan of the second sensor at the same time is complete by now.
    assert_eq!(take(0, 6, 16), [(1, 3, 5 * S)]);
    // A scan that comes too late is complete and released at once; the tracker decides about it.
    assert_eq!(take(1, 3, 4), [(2, 3, 4 * S)]);
    assert_eq!(take(1, 4, 7), []);
}

#[test]
fn a_late_detection_of_a_complete_scan_is_rejected() {
    let mut joiner = two(S);
    joiner.take(0, &detection(1, 1, 2 * S), 0);
    joiner.take(0, &detection(1, 2, 4 * S), 0);
    let late = joiner.take(0, &detection(1, 0, S), 0);
    assert_eq!(late, DetectionTreatment::TooLate);
}

#[test]
fn empty_scans_and_marks_bring_scans_on() {
    let mut joiner = two(100 * S);
    joiner.take(0, &detection(1, 1, S), 0);
    joiner.take(0, &SensorEvent::Passed(2 * S), 0);
    assert_eq!(released(&mut joiner), []);
    joiner.take(
        1,
        &SensorEvent::EmptyScan {
            number: 9,
            time_ns: 3 * S,
        },
        0,
    );
    assert_eq!(released(&mut joiner), [(1, 1, S)]);
    joiner.end();
    assert_eq!(released(&mut joiner), [(2, 9, 3 * S)]);
}

/// A radar's north marks show its turns without detections before the next detection comes.
#[test]
fn turns_without_detections_are_known_by_north_marks() {
    let turn = cutter(Boundaries::Turn, 4 * S);
    let rules = settings(vec![turn, cutter(Boundaries::Stated, S)], 0);
    let mut joiner = ScanJoiner::new(&[1, 2], &rules, 0).unwrap();
    joiner.take(0, &SensorEvent::TurnBegins(0), 0);
    joiner.take(0, &detection(1, 0, S), 0);
    for turn in 1..4 {
        joiner.take(0, &SensorEvent::TurnBegins(4 * S * turn), 0);
    }
    let times: Vec<i64> = released(&mut joiner).iter().map(|(.., time_ns)| time_ns / S).collect();
    assert_eq!(times, [1, 5]);
    joiner.take(0, &SensorEvent::TurnBegins(16 * S), 0);
    joiner.take(0, &detection(1, 0, 17 * S), 0);
    joiner.end();
    let times: Vec<i64> = released(&mut joiner).iter().map(|(.., time_ns)| time_ns / S).collect();
    assert_eq!(times, [9, 13, 17]);
}

#[test]
fn missing_numbers_are_scans_in_their_places() {
    let mut joiner = two(0);
    joiner.take(1, &SensorEvent::EmptyScan { number: 1, time_ns: 0 }, 0);
    for (scan, time_s) in [(1, 1), (4, 4)] {
        joiner.take(0, &detection(1, scan, time_s * S), 0);
    }
    joiner.end();
    let expected = [(2, 1, 0), (1, 1, S), (1, 2, 2 * S), (1, 3, 3 * S), (1, 4, 4 * S)];
    assert_eq!(released(&mut joiner), expected);
}

#[test]
fn rules_for_other_sensors_are_refused() {
    assert!(ScanJoiner::new(&[1, 2], &settings(vec![cutter(Boundaries::Turn, S)], 0), 0).is_err());
    assert!(ScanJoiner::new(&[], &JoiningSettings::default(), 0).is_err());
}

proptest! {
    /// Events no farther out of order than the wait give the scans in order, whatever the order between the sensors.
    #[test]
    fn scans_come_in_order_whoever_is_late(
        steps in prop::collection::vec((0..3usize, 1..20i64, 0..15i64), 1..120),
        by_number in any::<bool>(),
    ) {
        const TENTH: i64 = S / 10;
        let boundaries = if by_number { Boundaries::Stated } else { Boundaries::Period };
        let cutters = vec![cutter(boundaries, 5 * TENTH); 3];
        let wait_ns = 25 * TENTH;
        let mut joiner = ScanJoiner::new(&[1, 2, 3], &settings(cutters, wait_ns), 0).unwrap();
        // The time of each sensor rises; the events come with different delays.
        let (mut times, mut events) = ([0i64; 3], Vec::new());
        let mut now = 0;
        for (place, (sensor, step, delay)) in steps.iter().enumerate() {
            now += step;
            times[*sensor] = now;
            events.push((now + delay, place, *sensor, now));
        }
        events.sort();
        let (mut last, mut found, mut late) = ((i64::MIN, 0), 0, 0);
        let mut seen = |joiner: &mut ScanJoiner| -> Result<usize, TestCaseError> {
            let mut count = 0;
            while let Some(scan) = joiner.next_scan() {
                // A gap in the numbers is known only when the next detection comes.
                if scan.detections.is_empty() {
                    continue;
                }
                prop_assert!(last <= (scan.time_ns, scan.sensor_id), "{last:?} {scan:?}");
                last = (scan.time_ns, scan.sensor_id);
                count += scan.detections.len();
            }
            Ok(count)
        };
        for (_, place, sensor, time) in &events {
            let event = detection(*sensor as u32 + 1, *place as u32, time * TENTH);
            late += usize::from(joiner.take(*sensor, &event, 0) != DetectionTreatment::Waits);
            found += seen(&mut joiner)?;
        }
        joiner.end();
        found += seen(&mut joiner)?;
        prop_assert_eq!(found + late, events.len());
    }

    /// One sensor is cut as by its cutter alone.
    #[test]
    fn one_sensor_never_waits(times in prop::collection::vec(0..400i64, 1..80)) {
        let rules = CutterSettings { wait_ns: Some(S), ..cutter(Boundaries::Period, 4 * S) };
        let mut joiner = ScanJoiner::new(&[1], &settings(vec![rules], 100 * S), 0).unwrap();
        let mut alone = Cutter::new(rules);
        for time in times {
            let event = detection(1, 0, time * S / 10);
            let SensorEvent::Detection(only) = event else { unreachable!() };
            prop_assert_eq!(joiner.take(0, &event, time), alone.take(only, time));
            let (mut joined, mut expected) = (Vec::new(), Vec::new());
            while let Some(scan) = alone.next_scan() {
                expected.push((scan.number, scan.time_ns, alone.detections().to_vec(), alone.with_them().to_vec()));
            }
            while joiner.next_scan().is_some() {
                let (scan, (_, receipts)) = (joiner.released(), joiner.receipts());
                if !scan.detections.is_empty() {
                    joined.push((scan.number, scan.time_ns, scan.detections.to_vec(), receipts.to_vec()));
                }
            }
            prop_assert_eq!(joined, expected);
        }
    }
}

/// A scan of a long turn must not end the images of another sensor: their rows may be late by the wait.
#[test]
fn rows_of_an_image_within_the_wait_form_one_scan_beside_a_slow_radar() {
    let rules = settings(vec![cutter(Boundaries::Turn, 4 * S), cutter(Boundaries::Stated, S)], S);
    let mut joiner = ScanJoiner::new(&[1, 2], &rules, 0).unwrap();
    joiner.take(0, &detection(1, 0, S + S / 20), 0);
    for _ in 0..3 {
        let taken = joiner.take(1, &detection(2, 7, S), 0);
        assert_eq!(taken, DetectionTreatment::Waits);
        joiner.take(0, &detection(1, 0, S + S / 5), 0);
    }
    joiner.take(0, &SensorEvent::Passed(9 * S), 0);
    let mut found = Vec::new();
    while let Some(scan) = joiner.next_scan() {
        found.push((scan.sensor_id, scan.detections.len()));
    }
    assert!(found.contains(&(2, 3)), "{found:?}");
}
