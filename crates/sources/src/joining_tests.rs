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
        height: None,
        velocity: None,
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

/// Of a radar alone, too, and detections of the turns that are known to be empty are late.
#[test]
fn turns_without_detections_of_a_radar_alone_are_known_by_north_marks() {
    let turn = CutterSettings {
        wait_ns: Some(S),
        ..cutter(Boundaries::Turn, 4 * S)
    };
    let mut joiner = ScanJoiner::new(&[1], &settings(vec![turn], 0), 0).unwrap();
    joiner.take(0, &SensorEvent::TurnBegins(0), 0);
    joiner.take(0, &detection(1, 0, 2 * S), 0);
    let mut found = Vec::new();
    for turn in 1..5 {
        joiner.take(0, &SensorEvent::TurnBegins(4 * S * turn), 0);
        while let Some(scan) = joiner.next_scan() {
            found.push((scan.number, scan.time_ns / S));
            assert_eq!(joiner.is_by_time(), joiner.receipts().1.is_empty());
        }
    }
    // The turns of 6 and 10 s were over, with the wait, at 11 and 15 s.
    let first = found[0].0;
    assert_eq!(found, [(first, 2), (first + 1, 6), (first + 2, 10)]);
    let late = joiner.take(0, &detection(1, 0, 13 * S), 0);
    assert_eq!(late, DetectionTreatment::TooLate);
    joiner.take(0, &detection(1, 0, 15 * S), 0);
    joiner.take(0, &detection(1, 0, 17 * S), 0);
    joiner.end();
    let numbers: Vec<(u32, i64)> = released(&mut joiner)
        .iter()
        .map(|(_, number, time_ns)| (*number, time_ns / S))
        .collect();
    assert_eq!(numbers, [(first + 3, 15), (first + 4, 17)]);
}

/// The clock that only shows pictures states no scan of the sensor.
#[test]
fn the_clock_of_pictures_completes_a_scan_and_states_none() {
    let rules = settings(vec![cutter(Boundaries::Turn, 4 * S)], 0);
    let mut joiner = ScanJoiner::new(&[1], &rules, 0).unwrap();
    joiner.take(0, &detection(1, 0, S), 0);
    joiner.passed_by_clock(60 * S);
    assert_eq!(released(&mut joiner).len(), 1);
    assert_eq!(joiner.shown_ns(), 60 * S);
    // A single mark with a wrong time makes one scan empty, and not all until then.
    joiner.take(0, &SensorEvent::Passed(60 * S), 0);
    assert_eq!(released(&mut joiner).len(), 1);
    for _ in 0..3 {
        joiner.take(0, &SensorEvent::Passed(60 * S), 0);
    }
    assert_eq!(released(&mut joiner).len(), 6);
}

/// A camera that numbers its images and has a stated period: its time shows the images that it has not sent.
#[test]
fn numbered_scans_are_known_to_be_empty_by_the_sensors_time() {
    let rules = |period_ns| {
        let stated = CutterSettings {
            period_ns,
            ..cutter(Boundaries::Stated, S)
        };
        ScanJoiner::new(&[1, 2], &settings(vec![stated, cutter(Boundaries::Turn, 9 * S)], 0), 0).unwrap()
    };
    for (period_ns, empty) in [(None, vec![]), (Some(2 * S), vec![3, 5])] {
        let mut joiner = rules(period_ns);
        joiner.take(0, &detection(1, 7, S), 0);
        joiner.take(0, &SensorEvent::Passed(5 * S - 1), 0);
        assert_eq!(released(&mut joiner), [(1, 7, S)]);
        joiner.take(0, &SensorEvent::Passed(7 * S), 0);
        let times = released(&mut joiner)
            .iter()
            .map(|(.., time_ns)| time_ns / S)
            .collect::<Vec<_>>();
        assert_eq!(times, empty);
        let late = joiner.take(0, &detection(1, 8, 4 * S), 0) == DetectionTreatment::TooLate;
        assert_eq!(late, period_ns.is_some());
        // Its own numbers go on, whether or not they count the images without detections.
        joiner.take(0, &detection(1, 9, 8 * S), 0);
        joiner.end();
        let own = released(&mut joiner).last().copied();
        assert_eq!(own, Some((1, 9, 8 * S)));
    }
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
    /// The events of each sensor keep their own order: a sensor that numbers its scans has no wait here.
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
        let (mut came, mut events) = ([0i64; 3], Vec::new());
        let mut now = 0;
        for (place, (sensor, step, delay)) in steps.iter().enumerate() {
            now += step;
            came[*sensor] = came[*sensor].max(now + delay);
            events.push((came[*sensor], place, *sensor, now));
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
