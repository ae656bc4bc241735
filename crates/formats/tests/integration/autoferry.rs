//! The Autoferry scenarios: known totals, and detections that lie where the targets were.

use std::f64::consts::TAU;

use formats::autoferry::{self, FerryScan, FerrySensor};
use formats::detections_csv::{DetectionReader, DetectionWriter};
use test_support::recording;

const DAY_NS: i64 = 86_400 * 1_000_000_000;

fn scenario(number: u32) -> Option<Vec<FerryScan>> {
    let read = |kind: &str| recording(&format!("autoferry/scenario{number}/scenario{number}_{kind}.json"));
    Some(autoferry::read(&read("detections")?, &read("groundTruth")?).unwrap())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The distance of each scan's best detection to the nearest target: metres, or radians for a camera.
fn misses(scans: &[FerryScan], sensor: FerrySensor) -> Vec<f64> {
    let of_scan = |scan: &FerryScan| {
        let pairs = scan.detections.iter().flat_map(|detection| {
            scan.truth.iter().map(move |truth| {
                let [east, north, _] = truth.position_m;
                let [x, y, _] = detection.values;
                match sensor {
                    FerrySensor::Lidar | FerrySensor::Radar => (x - east).hypot(y - north),
                    FerrySensor::InfraredCamera | FerrySensor::Camera => {
                        let [own_east, own_north, _] = scan.platform_m;
                        let bearing = (east - own_east).atan2(north - own_north);
                        ((x - bearing + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0).abs()
                    }
                }
            })
        });
        pairs.min_by(f64::total_cmp)
    };
    let own = |scan: &&FerryScan| scan.sensor == sensor;
    scans.iter().filter(own).filter_map(of_scan).collect()
}

#[test]
fn every_scan_is_read_and_detections_lie_at_the_targets() {
    for (number, scans_expected, per_sensor, late_expected) in [
        (2, 1907, [234, 70, 1012, 591], 0),
        (3, 2107, [259, 78, 1117, 653], 0),
        (13, 1885, [232, 69, 1000, 584], 670),
        (16, 1914, [235, 72, 1014, 593], 683),
    ] {
        let Some(scans) = scenario(number) else { return };
        assert_eq!(scans.len(), scans_expected, "scenario {number}");
        let late = scans
            .windows(2)
            .filter(|pair| pair[1].time_of_measurement_ns < pair[0].time_of_measurement_ns);
        assert_eq!(
            late.count(),
            late_expected,
            "scenario {number}: in the order of recording"
        );
        for (sensor, expected) in FerrySensor::ALL.into_iter().zip(per_sensor) {
            let own: Vec<_> = scans.iter().filter(|scan| scan.sensor == sensor).collect();
            assert_eq!(own.len(), expected, "scenario {number}, {sensor:?}");
            assert!(
                own.windows(2)
                    .all(|pair| pair[0].time_of_measurement_ns < pair[1].time_of_measurement_ns)
            );
            assert!(own.iter().zip(0..).all(|(scan, number)| scan.number == number));
            let limit = match sensor {
                FerrySensor::Lidar | FerrySensor::Radar => 10.0,
                FerrySensor::InfraredCamera | FerrySensor::Camera => 0.1,
            };
            let miss = median(misses(&scans, sensor));
            assert!(miss < limit, "scenario {number}, {sensor:?}: {miss}");
        }
        assert!(scans.iter().all(|scan| scan.truth.len() == 2));
    }
}

#[test]
fn detections_pass_through_a_file_unchanged() {
    let Some(scans) = scenario(2) else { return };
    let detections: Vec<_> = scans.iter().flat_map(|scan| scan.detections.iter().copied()).collect();
    assert_eq!(detections.len(), 4239, "of all sensors");
    let first_day_ns = detections[0].time_of_measurement_ns / DAY_NS * DAY_NS;
    let mut text = Vec::new();
    let mut writer = DetectionWriter::begin(&mut text, first_day_ns).unwrap();
    for detection in &detections {
        writer.write(detection).unwrap();
    }
    let reader = DetectionReader::new(&text[..], first_day_ns).unwrap();
    let found: Vec<_> = reader.map(Result::unwrap).collect();
    assert_eq!(found, detections);
}
